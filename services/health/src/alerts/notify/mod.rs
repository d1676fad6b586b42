//! Notification of receivers by webhook and MQTT.
//!
//! Notifications wait in the [outbox](crate::alerts::nflog) and leave it when their receiver has confirmed them: an HTTP
//! status of the 200s, or the broker's PUBACK. Each receiver has a thread of its own and gets its notifications in order. While it cannot be reached, the pause between two attempts doubles, up to a limit, with some jitter. A notification
//! may arrive twice (a kill between confirmation and removal), and carries a key by which the receiver can tell.

mod mqtt;
mod notifier;
pub(crate) mod routes;
mod status;
mod webhook;

pub use notifier::{Notifier, Outcome};
pub use status::{ReceiverList, ReceiverStates, ReceiverView};

use crate::alerts::journal::Journal;
use crate::alerts::nflog::Receiver;
use railgrip_settings::{NotifySettings, ReceiverSettings, ReceiverWay};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// An empty outbox is looked at this often.
const POLL: Duration = Duration::from_millis(200);
/// The first pause after a failure.
const FIRST_PAUSE: Duration = Duration::from_millis(500);
/// A notification that its receiver refuses for good is given up after so many times.
const REFUSALS: u32 = 5;

/// The receivers of a train, as the outbox addresses them.
#[must_use]
pub fn receivers(settings: &NotifySettings) -> Vec<Receiver> {
    let receiver = |one: &ReceiverSettings| Receiver { name: one.name.clone(), act_only: one.act_only };
    settings.receivers.iter().map(receiver).collect()
}

/// Starts a thread a receiver; they end soon after `stop` is set.
pub fn start(
    settings: &NotifySettings,
    train: &str,
    journal: &Path,
    states: &ReceiverStates,
    stop: &Arc<AtomicBool>,
) -> Vec<JoinHandle<()>> {
    let longest = Duration::from_secs_f64(settings.longest_pause_s);
    let begin = |receiver: &ReceiverSettings| {
        let (receiver, train, path) = (receiver.clone(), train.to_owned(), journal.to_owned());
        let (states, stop) = (states.clone(), Arc::clone(stop));
        std::thread::spawn(move || {
            let mut notifier = notifier_of(receiver.way, &train, &stop);
            let round = Round { name: &receiver.name, longest, states: &states, stop: &stop };
            while !stop.load(Ordering::Relaxed) {
                match Journal::open(&path, &train, Vec::new(), u32::MAX) {
                    Ok(journal) => round.walk(&journal, notifier.as_mut()),
                    Err(error) => round.report(error.to_string(), None),
                }
                round.sleep(Duration::from_secs(5));
            }
        })
    };
    settings.receivers.iter().map(begin).collect()
}

/// The way to a receiver.
fn notifier_of(way: ReceiverWay, train: &str, stop: &Arc<AtomicBool>) -> Box<dyn Notifier> {
    match way {
        ReceiverWay::Webhook(settings) => Box::new(webhook::Webhook::new(settings)),
        ReceiverWay::Mqtt(settings) => {
            Box::new(mqtt::Mqtt::new(settings, train.to_owned(), Arc::clone(stop)))
        }
    }
}

/// The round of one receiver's thread.
struct Round<'a> {
    name: &'a str,
    longest: Duration,
    states: &'a ReceiverStates,
    stop: &'a AtomicBool,
}

impl Round<'_> {
    /// Carries notifications until it shall stop or the journal fails.
    fn walk(&self, journal: &Journal, notifier: &mut dyn Notifier) {
        let mut pause = FIRST_PAUSE;
        while !self.stop.load(Ordering::Relaxed) {
            let (counts, next) = match (journal.counts(self.name), journal.next(self.name)) {
                (Ok(counts), Ok(next)) => (counts, next),
                (Err(error), _) | (_, Err(error)) => return self.report(error.to_string(), None),
            };
            let Some(notification) = next else {
                self.states.set(self.name, counts, None);
                self.sleep(POLL);
                continue;
            };
            let outcome = notifier.notify(&notification);
            if matches!(outcome, Outcome::Later(_)) && self.stop.load(Ordering::Relaxed) {
                // What was broken off by stopping is no trouble of the receiver.
                return;
            }
            let given_up = notification.refused + 1 >= REFUSALS;
            let kept = match &outcome {
                Outcome::Confirmed => journal.done(self.name, notification.id, true),
                Outcome::Refused(_) if given_up => journal.done(self.name, notification.id, false),
                Outcome::Refused(_) => journal.refused(notification.id),
                Outcome::Later(_) => Ok(()),
            };
            if let Err(error) = kept {
                return self.report(error.to_string(), Some(counts));
            }
            match outcome {
                Outcome::Confirmed => {
                    self.states.set(self.name, journal.counts(self.name).unwrap_or(counts), None);
                    pause = FIRST_PAUSE;
                }
                Outcome::Refused(said) if given_up => {
                    tracing::error!(
                        receiver = self.name,
                        key = notification.key,
                        said,
                        "a notification is given up"
                    );
                    self.report(format!("given up: {said}"), Some(counts));
                    pause = FIRST_PAUSE;
                }
                Outcome::Refused(said) | Outcome::Later(said) => {
                    self.report(said, Some(counts));
                    self.sleep(jittered(pause, &notification.key));
                    pause = (pause * 2).min(self.longest);
                }
            }
        }
    }

    fn report(&self, trouble: String, counts: Option<[u64; 4]>) {
        if self.states.set(self.name, counts.unwrap_or_default(), Some(trouble.clone())) {
            tracing::warn!(receiver = self.name, trouble, "alerts cannot be sent; they wait");
        }
    }

    fn sleep(&self, pause: Duration) {
        let until = Instant::now() + pause;
        while !self.stop.load(Ordering::Relaxed) {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return;
            }
            std::thread::sleep(left.min(POLL));
        }
    }
}

/// A pause, longer by up to a quarter, so that the trains of a fleet do not knock at the same instant.
fn jittered(pause: Duration, key: &str) -> Duration {
    let hash =
        key.bytes().fold(0x811c_9dc5_u32, |hash, byte| (hash ^ u32::from(byte)).wrapping_mul(0x0100_0193));
    pause.mul_f64(1.0 + 0.25 * f64::from(hash % 1000) / 1000.0)
}
