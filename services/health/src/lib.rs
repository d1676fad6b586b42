//! Health: the indicators of the train over HTTP, for maintenance, Prometheus and people.
//!
//! One thread ([`collect`]) listens to the channels and renews a [`store::Snapshot`] several times a second; requests are
//! answered from the latest one, so that no request ever waits for a channel. [`api::router`] can be tested without a
//! socket and without channels. Stale data are marked with their age and never shown as the present.

pub mod access;
pub mod alerts;
pub mod api;
mod collect;
pub mod history;
pub mod limits;
pub mod notes;
pub mod page;
pub mod settings;
pub mod shared;
pub mod store;
pub mod time;
mod web;

use crate::access::{Access, LocalSocket};
use crate::shared::{Build, Shared};
use crate::store::Store;
use railgrip_bus::{BusError, Lifecycle, now};
use railgrip_settings::TrainSettings;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::TcpListener;

/// How often it is looked whether this process has joined its train.
const JOIN_POLL: Duration = Duration::from_millis(5);
/// How often the stop flag is looked at.
const STOP_POLL: Duration = Duration::from_millis(50);
/// How long running requests may take once the service shall stop.
const DRAIN: Duration = Duration::from_secs(2);

/// Why the health service ended.
#[derive(Debug, thiserror::Error)]
pub enum HealthError {
    /// The channels cannot be used.
    #[error(transparent)]
    Bus(#[from] BusError),
    /// Certificate, tokens or the like cannot be used.
    #[error(transparent)]
    Access(#[from] access::AccessError),
    /// The thread that reads the channels has panicked; the log says where.
    #[error("the thread that reads the channels has panicked, so nothing new could be shown")]
    CollectorPanicked,
    /// Nothing can be served there.
    #[error("{what}: {source}")]
    Serve {
        /// Address or file.
        what: String,
        /// What the system says.
        source: std::io::Error,
    },
}

/// Runs until asked to stop.
///
/// # Errors
/// An address that cannot be listened on, or channels that cannot be used.
pub fn run(settings: &TrainSettings, lifecycle: &Lifecycle, build: Build) -> Result<(), HealthError> {
    let shared = Shared::new(Store::new(settings).snapshot(now()), now);
    shared.built_from(build);
    shared.judge_by(limits::Limits::of(settings));
    shared.notes().keep(settings.alert_journal.with_file_name("notes.jsonl"));
    let (recorder, writer) = remember(settings, &shared).unzip();
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .map_err(|source| HealthError::Serve { what: "runtime".to_owned(), source })?;
    // Whoever may not join the train takes no port and leaves the address of whoever may alone.
    let joined = Lifecycle::new();
    let result = side_by_side(
        &runtime,
        lifecycle,
        || collect::collect(settings, &shared, lifecycle, &joined, recorder).map_err(HealthError::from),
        |ended| serve(settings, shared.clone(), lifecycle, &joined, ended),
    );
    // The recorder is gone with the collector, so the writer writes what is left and ends.
    if let Some(writer) = writer {
        let _ = writer.join();
    }
    result
}

/// Collects on a thread of its own and serves on this one until both have ended; the end of either, a panic included, ends
/// the other. A service that goes on answering without a collector would show the past for ever.
fn side_by_side<F: Future<Output = Result<(), HealthError>>>(
    runtime: &tokio::runtime::Runtime,
    lifecycle: &Lifecycle,
    collect: impl FnOnce() -> Result<(), HealthError> + Send,
    serve: impl FnOnce(Lifecycle) -> F,
) -> Result<(), HealthError> {
    std::thread::scope(|scope| {
        let ended = Lifecycle::new();
        let collector = scope.spawn({
            let ended = StopWhenDropped(ended.clone());
            move || {
                let _ended = ended;
                collect()
            }
        });
        let served = runtime.block_on(serve(ended));
        if served.is_err() {
            lifecycle.stop();
        }
        collector.join().unwrap_or(Err(HealthError::CollectorPanicked))?;
        served
    })
}

/// Stops when it goes, also while a panic unwinds.
struct StopWhenDropped(Lifecycle);

impl Drop for StopWhenDropped {
    fn drop(&mut self) {
        self.0.stop();
    }
}

/// Starts the history, if there shall be one.
fn remember(
    settings: &TrainSettings,
    shared: &Shared,
) -> Option<(history::Recorder, std::thread::JoinHandle<()>)> {
    if !settings.history.enabled {
        return None;
    }
    let wheelsets = settings.wagons.iter().map(|wagon| wagon.vehicle.wheelsets()).max().unwrap_or(0);
    let history = history::History::new(settings.history.database(), wheelsets);
    let history = history.of_vehicles(history::consist::numbers(settings));
    let history = Arc::new(history.started(history::consist::started_s(settings)));
    shared.remember(Arc::clone(&history));
    Some(history::start(&settings.history, history))
}

async fn serve(
    settings: &TrainSettings,
    shared: Shared,
    lifecycle: &Lifecycle,
    joined: &Lifecycle,
    ended: Lifecycle,
) -> Result<(), HealthError> {
    while !joined.is_ready() {
        if ended.should_stop() || lifecycle.should_stop() {
            return Ok(());
        }
        tokio::time::sleep(JOIN_POLL).await;
    }
    let failed = |what: String| move |source| HealthError::Serve { what, source };
    let access = Access::open(settings)?;
    let wanted = settings.http.listen;
    let listener = TcpListener::bind(wanted).await.map_err(failed(wanted.to_string()))?;
    let address = listener.local_addr().map_err(failed(wanted.to_string()))?;
    let file = settings.instance.http_address_file();
    let written = if access.scheme() == "https" { format!("https://{address}") } else { address.to_string() };
    write_whole(&file, &format!("{written}\n")).map_err(failed(file.display().to_string()))?;
    let local =
        access.needs_local_socket().then(|| LocalSocket::open(&settings.instance.http_socket())).flatten();
    lifecycle.ready();
    tracing::info!("{}://{address}/", access.scheme());
    let stopping = async {
        while !lifecycle.should_stop() && !ended.should_stop() {
            tokio::time::sleep(STOP_POLL).await;
        }
        shared.close();
    };
    let closing = {
        let mut closing = shared.closing();
        async move {
            let _ = closing.wait_for(|closing| *closing).await;
        }
    };
    let router = access::guard(api::router(shared.clone()), &access);
    let server = access::serve(listener, local, router, access, closing);
    let drained = async {
        stopping.await;
        tokio::time::sleep(DRAIN).await;
    };
    tokio::select! {
        () = server => {}
        () = drained => {}
    }
    // A successor may have written its own address while this process drained; that one must stay.
    if std::fs::read_to_string(&file).is_ok_and(|text| text.trim() == written) {
        let _ = std::fs::remove_file(&file);
    }
    Ok(())
}

/// Writes a small file so that no reader sees half of it.
fn write_whole(file: &Path, text: &str) -> std::io::Result<()> {
    let beside = file.with_extension("new");
    std::fs::write(&beside, text)?;
    std::fs::rename(&beside, file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[allow(clippy::panic, clippy::unwrap_used, reason = "it is the panic that is tested")]
    fn a_panic_of_the_collector_ends_the_service() {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        let until_ended = |ended: Lifecycle| async move {
            while !ended.should_stop() {
                tokio::time::sleep(Duration::from_millis(1)).await;
            }
            Ok(())
        };
        let result =
            side_by_side(&runtime, &Lifecycle::new(), || panic!("as a collector that errs"), until_ended);
        assert!(matches!(result, Err(HealthError::CollectorPanicked)), "{result:?}");
        let result = side_by_side(&runtime, &Lifecycle::new(), || Ok(()), until_ended);
        assert!(result.is_ok(), "{result:?}");
    }
}
