//! The store itself: takes messages in, gives snapshots out.

use crate::alerts::model::Alert;
use crate::alerts::{AlertBook, SharedBook};
use crate::store::inference::Inference;
use crate::store::received::Received;
use crate::store::snapshot::Snapshot;
use crate::store::symptoms;
use railgrip_indicators::track::KeptCell;
use railgrip_messages::{Health, Heard, Heartbeat, Stamp};
use railgrip_settings::TrainSettings;

/// Everything that is known about the train.
#[derive(Debug)]
pub struct Store {
    train: String,
    received: Received,
    inference: Inference,
    alerts: SharedBook,
    started: Option<Stamp>,
    /// What is wrong with the history.
    history: Option<String>,
}

impl Store {
    /// Nothing has arrived yet.
    #[must_use]
    pub fn new(settings: &TrainSettings) -> Self {
        Self {
            train: settings.name.clone(),
            received: Received::new(settings),
            inference: Inference::new(settings),
            alerts: SharedBook::new(AlertBook::new(
                settings.alerts,
                settings.wagons.len() as u32,
                settings.instance.dir.join("gaps"),
            )),
            started: None,
            history: None,
        }
    }

    /// Takes the indicators of a wagon; those of an unknown wagon, and older ones than it has, are ignored.
    pub fn take_health(&mut self, health: &Health) {
        if let Some(before) = self.received.take_health(health) {
            self.inference.chart(health, before.as_deref());
        }
    }

    /// Takes what a microphone heard.
    pub fn take_heard(&mut self, heard: &Heard) {
        self.received.take_heard(heard);
    }

    /// Takes the heartbeat of a process.
    pub fn take_heartbeat(&mut self, beat: &Heartbeat) {
        self.received.take_heartbeat(beat);
    }

    /// Takes what is wrong with the history, if anything is.
    pub fn set_history_trouble(&mut self, trouble: Option<String>) {
        self.history = trouble;
    }

    /// What can be said now.
    pub fn snapshot(&mut self, now: Stamp) -> Snapshot {
        self.received.forget_silent_processes(now);
        self.inference.compare(&self.received, now.monotonic_ns);
        let news = self.judge(now);
        Snapshot::take(&self.train, &self.received, &mut self.inference, &self.alerts, news, now)
    }

    /// Goes on from cells of the map that were kept; returns how many there were.
    pub fn restore_map(&mut self, cells: &[(i64, Vec<u8>)], now: Stamp) -> usize {
        self.inference.restore_map(cells, now)
    }

    /// Cells of the map that have changed since this was last asked.
    pub fn changed_map(&mut self, now: Stamp) -> Vec<KeptCell> {
        self.inference.changed_map(now)
    }

    /// The alerts, for whoever keeps them.
    #[must_use]
    pub fn book(&self) -> SharedBook {
        self.alerts.clone()
    }

    /// Judges every symptom; returns the alerts to which something happened.
    fn judge(&mut self, now: Stamp) -> Vec<Alert> {
        let started = *self.started.get_or_insert(now);
        let mut book = self.alerts.lock();
        symptoms::judge(&mut book, &self.received, &self.inference, started, now);
        symptoms::judge_service(&mut book, self.history.as_deref(), now);
        book.settle(now);
        book.take_news()
    }
}
