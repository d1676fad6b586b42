//! railgrip estimator.

use railgrip_bus::{Bus, BusConfig, BusError, Lifecycle};
use railgrip_messages::ProcessKind;
use railgrip_settings::TrainSettings;

/// Why the estimator process ended.
#[derive(Debug, thiserror::Error)]
pub enum EstimatorError {
    /// The bus refused or went away.
    #[error(transparent)]
    Bus(#[from] BusError),
}

/// Runs until `lifecycle` asks to stop.
///
/// # Errors
/// See [`EstimatorError`].
pub fn run(settings: &TrainSettings, wagon: u32, lifecycle: &Lifecycle) -> Result<(), EstimatorError> {
    let bus = Bus::open(BusConfig::of(settings), ProcessKind::Estimator, wagon)?;
    lifecycle.ready();
    while !lifecycle.should_stop() {
        std::thread::sleep(std::time::Duration::from_millis(100));
        bus.check_holder()?;
        lifecycle.beat();
    }
    Ok(())
}
