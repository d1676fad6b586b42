//! Alerts on the disk, and who is notified of them.

use crate::alerts::journal::Journal;
use crate::alerts::notify;
use crate::shared::Shared;
use crate::store::Store;
use railgrip_settings::TrainSettings;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Alerts on the disk, and the threads that notify receivers.
pub(super) struct Notifying {
    stop: Arc<AtomicBool>,
    threads: Vec<std::thread::JoinHandle<()>>,
}

impl Notifying {
    /// Goes on from the journal. Without one alerts are live only, and nobody is notified.
    pub fn open(settings: &TrainSettings, shared: &Shared, store: &Store) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let (path, notify) = (&settings.alert_journal, &settings.notify);
        notify.deprecated.iter().for_each(|note| tracing::warn!("{note}"));
        let (receivers, most) = (notify::receivers(notify), notify.most_waiting);
        let opened = Journal::open(path, &settings.name, receivers, most)
            .and_then(|journal| journal.alerts().map(|kept| (journal, kept)));
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
