//! Delivery of alerts by webhook and MQTT.
//!
//! Letters wait in the outbox of the [journal](crate::alerts::journal) and leave it when their receiver has confirmed them:
//! an HTTP status of the 200s, or the broker's PUBACK. Each receiver has a thread of its own and gets its letters in
//! order. While it cannot be reached, the pause between two attempts doubles, up to a limit, with some jitter. A letter
//! may arrive twice (a kill between confirmation and removal), and carries a key by which the receiver can tell.

mod mqtt;
pub(crate) mod routes;
mod status;
mod webhook;

pub use status::{DeliveryView, Mailbox, TargetView};

use crate::alerts::journal::{Journal, Target, Waiting};
use railgrip_settings::DeliverySettings;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// An empty outbox is looked at this often.
const POLL: Duration = Duration::from_millis(200);
/// Longest wait for a receiver's answer.
const ANSWER: Duration = Duration::from_secs(10);
/// The first pause after a failure.
const FIRST_PAUSE: Duration = Duration::from_millis(500);
/// A letter that its receiver refuses for good is given up after so many times.
const REFUSALS: u32 = 5;

/// How an attempt ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Outcome {
    /// The receiver has confirmed it.
    Confirmed,
    /// It could not be reached, or is not well; later.
    Later(String),
    /// It says that it will not take this letter.
    Refused(String),
}

/// A way to a receiver.
pub trait Courier {
    /// Tries once.
    fn carry(&mut self, letter: &Waiting) -> Outcome;
}

/// The receivers of a train, as the journal addresses them.
#[must_use]
pub fn targets(settings: &DeliverySettings) -> Vec<Target> {
    let webhooks =
        settings.webhooks.iter().map(|hook| Target { name: hook.name.clone(), act_only: hook.act_only });
    let mqtt = settings.mqtt.iter().map(|mqtt| Target { name: "mqtt".to_owned(), act_only: mqtt.act_only });
    webhooks.chain(mqtt).collect()
}

/// Starts a thread a receiver; they end soon after `stop` is set.
pub fn start(
    settings: &DeliverySettings,
    train: &str,
    journal: &Path,
    mailbox: &Mailbox,
    stop: &Arc<AtomicBool>,
) -> Vec<JoinHandle<()>> {
    let mut threads = Vec::new();
    let longest = Duration::from_secs_f64(settings.longest_pause_s);
    let mut begin = |name: &str, courier: Box<dyn FnOnce() -> Box<dyn Courier> + Send>| {
        let (name, train, path) = (name.to_owned(), train.to_owned(), journal.to_owned());
        let (mailbox, stop) = (mailbox.clone(), Arc::clone(stop));
        threads.push(std::thread::spawn(move || {
            let mut courier = courier();
            let round = Round { name: &name, longest, mailbox: &mailbox, stop: &stop };
            while !stop.load(Ordering::Relaxed) {
                match Journal::open(&path, &train, Vec::new(), u32::MAX) {
                    Ok(journal) => round.walk(&journal, courier.as_mut()),
                    Err(error) => round.report(error.to_string(), None),
                }
                round.sleep(Duration::from_secs(5));
            }
        }));
    };
    for hook in &settings.webhooks {
        let own = hook.clone();
        begin(&hook.name, Box::new(move || Box::new(webhook::Webhook::new(own))));
    }
    if let Some(mqtt) = &settings.mqtt {
        let (own, train) = (mqtt.clone(), train.to_owned());
        begin("mqtt", Box::new(move || Box::new(mqtt::Mqtt::new(own, train))));
    }
    threads
}

/// The round of one receiver's postman.
struct Round<'a> {
    name: &'a str,
    longest: Duration,
    mailbox: &'a Mailbox,
    stop: &'a AtomicBool,
}

impl Round<'_> {
    /// Carries letters until it shall stop or the journal fails.
    fn walk(&self, journal: &Journal, courier: &mut dyn Courier) {
        let mut pause = FIRST_PAUSE;
        while !self.stop.load(Ordering::Relaxed) {
            let (counts, next) = match (journal.counts(self.name), journal.next(self.name)) {
                (Ok(counts), Ok(next)) => (counts, next),
                (Err(error), _) | (_, Err(error)) => return self.report(error.to_string(), None),
            };
            let Some(letter) = next else {
                self.mailbox.set(self.name, counts, None);
                self.sleep(POLL);
                continue;
            };
            let outcome = courier.carry(&letter);
            let given_up = letter.refused + 1 >= REFUSALS;
            let kept = match &outcome {
                Outcome::Confirmed => journal.done(self.name, letter.id, true),
                Outcome::Refused(_) if given_up => journal.done(self.name, letter.id, false),
                Outcome::Refused(_) => journal.refused(letter.id),
                Outcome::Later(_) => Ok(()),
            };
            if let Err(error) = kept {
                return self.report(error.to_string(), Some(counts));
            }
            match outcome {
                Outcome::Confirmed => {
                    self.mailbox.set(self.name, journal.counts(self.name).unwrap_or(counts), None);
                    pause = FIRST_PAUSE;
                }
                Outcome::Refused(said) if given_up => {
                    tracing::error!(receiver = self.name, key = letter.key, said, "a letter is given up");
                    self.report(format!("given up: {said}"), Some(counts));
                    pause = FIRST_PAUSE;
                }
                Outcome::Refused(said) | Outcome::Later(said) => {
                    self.report(said, Some(counts));
                    self.sleep(jittered(pause, &letter.key));
                    pause = (pause * 2).min(self.longest);
                }
            }
        }
    }

    fn report(&self, trouble: String, counts: Option<[u64; 4]>) {
        if self.mailbox.set(self.name, counts.unwrap_or_default(), Some(trouble.clone())) {
            tracing::warn!(receiver = self.name, trouble, "alerts cannot be delivered; they wait");
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
