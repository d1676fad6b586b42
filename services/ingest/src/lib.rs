//! railgrip ingest.

use railgrip_bus::{Bus, BusConfig, BusError, Lifecycle};
use railgrip_messages::{NO_WAGON, ProcessKind};
use railgrip_settings::TrainSettings;

/// Why the ingest process ended.
#[derive(Debug, thiserror::Error)]
pub enum IngestError {
    /// The bus refused or went away.
    #[error(transparent)]
    Bus(#[from] BusError),
}

/// Runs until `lifecycle` asks to stop.
///
/// # Errors
/// See [`IngestError`].
pub fn run(settings: &TrainSettings, lifecycle: &Lifecycle) -> Result<(), IngestError> {
    let bus = Bus::open(BusConfig::of(settings), ProcessKind::Ingest, NO_WAGON)?;
    lifecycle.ready();
    while !lifecycle.should_stop() {
        std::thread::sleep(std::time::Duration::from_millis(100));
        bus.check_holder()?;
        lifecycle.beat();
    }
    Ok(())
}
