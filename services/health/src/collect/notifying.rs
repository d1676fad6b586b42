//! Alerts on the disk, and who is notified of them.

use crate::alerts::journal::{Journal, JournalError};
use crate::alerts::model::{Alert, Change};
use crate::alerts::moved::{Numbers, moved, nameless};
use crate::alerts::nflog::Notification;
use crate::alerts::notify;
use crate::shared::Shared;
use crate::store::Store;
use railgrip_settings::{NotifySettings, TrainSettings, WagonSettings};
use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Longest wait for receivers when the service stops; `up` kills who takes longer than 5 s.
const CLOSING: Duration = Duration::from_secs(3);
/// How often it is looked whether they are done.
const CLOSING_POLL: Duration = Duration::from_millis(10);

/// Alerts on the disk, and the threads that notify receivers.
pub(super) struct Notifying {
    stop: Arc<AtomicBool>,
    threads: Vec<JoinHandle<()>>,
    notified: NotifySettings,
    /// There is a journal, without which nobody is notified.
    kept: bool,
}

/// The alerts that are kept, each where its vehicle runs now.
fn recall(mut journal: Journal, settings: &TrainSettings) -> Result<(Journal, Vec<Alert>), JournalError> {
    let session = settings.instance.session();
    let key = |wagon: &WagonSettings| match &wagon.vehicle_number {
        Some(number) => Some(number.key().to_owned()),
        None => nameless(&session, wagon.number),
    };
    let now: Numbers = settings.wagons.iter().map(key).collect();
    let kept = journal.alerts()?;
    let known = journal.consist()?;
    // Most starts are those of one process, and need not wait for the disk.
    let is_known = known.as_ref() == Some(&now);
    let before = known.unwrap_or_else(|| now.clone());
    let active: BTreeSet<u64> = kept.iter().filter(|alert| alert.active).map(|alert| alert.id).collect();
    let at_unix_ns = railgrip_bus::now().unix_ns;
    let (alerts, changed) = moved(kept, &before, &now, at_unix_ns);
    if changed {
        let unnamed = settings.wagons.iter().filter(|wagon| wagon.vehicle_number.is_none()).count();
        tracing::info!(
            unnamed,
            "the train has been started or made up anew; alerts follow vehicle numbers, wagons without one start fresh"
        );
        let over = alerts.iter().filter(|alert| !alert.active && active.contains(&alert.id));
        let over = over.filter(|alert| alert.silenced.is_none()).map(|alert| Notification {
            alert: alert.clone(),
            change: Change::Cleared,
            at_unix_ns,
        });
        journal.save(&alerts.iter().collect::<Vec<_>>(), &[], &over.collect::<Vec<_>>())?;
    }
    if !is_known {
        journal.set_consist(&now)?;
    }
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
        let notified = notify.clone();
        let (threads, kept) = match opened {
            Ok((journal, kept)) => {
                book.lock().keep_in(journal, kept);
                (notify::start(notify, &settings.name, path, shared.receiver_states(), &stop), true)
            }
            Err(error) => {
                tracing::error!(%error, "alerts are not kept, and nobody is notified");
                book.lock().set_trouble(error.to_string());
                (Vec::new(), false)
            }
        };
        Self { stop, threads, notified, kept }
    }

    /// Notifies other receivers from now on. The threads of the old ones end first, so that nobody is told twice; that may take
    /// as long as a receiver's answer, and nobody waits for it here.
    pub fn take_over(&mut self, settings: &TrainSettings, shared: &Shared, store: &Store) {
        if !self.kept || self.notified == settings.notify {
            return;
        }
        self.notified.clone_from(&settings.notify);
        let notify = self.notified.clone();
        store.book().lock().address(notify::receivers(&notify), notify.most_waiting);
        self.stop.store(true, Ordering::Relaxed);
        self.stop = Arc::new(AtomicBool::new(false));
        let (old, stop) = (std::mem::take(&mut self.threads), Arc::clone(&self.stop));
        let (train, path) = (settings.name.clone(), settings.alert_journal.clone());
        let states = shared.receiver_states().clone();
        self.threads.push(std::thread::spawn(move || {
            join(old);
            states.keep(|name| notify.receivers.iter().any(|one| one.name == name));
            join(notify::start(&notify, &train, &path, &states, &stop));
        }));
    }

    /// Stops the threads and waits for them, though not as long as a webhook may take to answer: what it confirms too late comes
    /// again, with the same key.
    pub fn close(self) {
        self.stop.store(true, Ordering::Relaxed);
        let until = Instant::now() + CLOSING;
        while self.threads.iter().any(|thread| !thread.is_finished()) && Instant::now() < until {
            std::thread::sleep(CLOSING_POLL);
        }
        let (ended, late): (Vec<_>, Vec<_>) = self.threads.into_iter().partition(JoinHandle::is_finished);
        join(ended);
        if !late.is_empty() {
            tracing::warn!(
                late = late.len(),
                "receivers have not answered yet; nobody waits for them any more"
            );
        }
    }
}

fn join(threads: Vec<JoinHandle<()>>) {
    for thread in threads {
        let _ = thread.join();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_receiver_that_takes_its_time_does_not_keep_the_service() {
        let slow = std::thread::spawn(|| std::thread::sleep(Duration::from_secs(20)));
        let threads = vec![slow, std::thread::spawn(|| ())];
        let notified = NotifySettings::default();
        let began = Instant::now();
        Notifying { stop: Arc::default(), threads, notified, kept: true }.close();
        assert!((CLOSING..Duration::from_secs(5)).contains(&began.elapsed()), "{:?}", began.elapsed());
    }
}
