//! Alerts on the disk, and who is notified of them.

use crate::alerts::journal::{Journal, JournalError};
use crate::alerts::model::Alert;
use crate::alerts::moved::{Numbers, moved};
use crate::alerts::notify;
use crate::shared::Shared;
use crate::store::Store;
use railgrip_settings::{TrainSettings, WagonSettings};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Alerts on the disk, and the threads that notify receivers.
pub(super) struct Notifying {
    stop: Arc<AtomicBool>,
    threads: Vec<std::thread::JoinHandle<()>>,
}

/// The alerts that are kept, each where its vehicle runs now.
fn recall(mut journal: Journal, settings: &TrainSettings) -> Result<(Journal, Vec<Alert>), JournalError> {
    let key = |wagon: &WagonSettings| wagon.vehicle_number.as_ref().map(|number| number.key().to_owned());
    let now: Numbers = settings.wagons.iter().map(key).collect();
    let kept = journal.alerts()?;
    let before = journal.consist()?.unwrap_or_else(|| now.clone());
    let (alerts, changed) = moved(kept, &before, &now, railgrip_bus::now().unix_ns);
    if changed {
        tracing::info!("the train has been made up anew; alerts follow their vehicles");
        journal.save(&alerts.iter().collect::<Vec<_>>(), &[], &[])?;
    }
    journal.set_consist(&now)?;
    Ok((journal, alerts))
}

impl Notifying {
    /// Goes on from the journal. Without one alerts are live only, and nobody is notified.
    pub fn open(settings: &TrainSettings, shared: &Shared, store: &Store) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let (path, notify) = (&settings.alert_journal, &settings.notify);
        notify.deprecated.iter().for_each(|note| tracing::warn!("{note}"));
        let (receivers, most) = (notify::receivers(notify), notify.most_waiting);
        let opened = Journal::open(path, &settings.name, receivers, most)
            .and_then(|journal| recall(journal, settings));
        let book = store.book();
        let threads = match opened {
            Ok((journal, kept)) => {
                book.lock().keep_in(journal, kept);
                notify::start(notify, &settings.name, path, shared.receiver_states(), &stop)
            }
            Err(error) => {
                tracing::error!(%error, "alerts are not kept, and nobody is notified");
                book.lock().set_trouble(error.to_string());
                Vec::new()
            }
        };
        Self { stop, threads }
    }

    /// Stops the threads and waits for them.
    pub fn close(self) {
        self.stop.store(true, std::sync::atomic::Ordering::Relaxed);
        for thread in self.threads {
            let _ = thread.join();
        }
    }
}
