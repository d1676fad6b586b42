//! The store itself: takes messages in, gives snapshots out.

use crate::alerts::model::Alert;
use crate::alerts::{AlertBook, SharedBook, Vehicles};
use crate::history::consist::started_s;
use crate::store::inference::{Inference, Whole};
use crate::store::judgement::Judgement;
use crate::store::received::Received;
use crate::store::snapshot::{Basis, Snapshot};
use crate::store::symptoms;
use railgrip_indicators::train::track::KeptCell;
use railgrip_indicators::{INDICATORS, Table};
use railgrip_messages::{Event, Health, Heard, Heartbeat, NO_WAGON, SourceState, Stamp, Validated, Verdicts};
use railgrip_settings::TrainSettings;

/// Everything that is known about the train.
#[derive(Debug)]
pub struct Store {
    train: String,
    table: Table,
    received: Received,
    inference: Inference,
    judgement: Judgement,
    alerts: SharedBook,
    started: Option<Stamp>,
    /// A wagon has been heard for the first time since the last look.
    first_news: bool,
    /// What is wrong with the history.
    history: Option<String>,
}

impl Store {
    /// Nothing has arrived yet.
    #[must_use]
    pub fn new(settings: &TrainSettings) -> Self {
        Self::with(INDICATORS, settings)
    }

    /// The same by another table of indicators.
    #[must_use]
    pub fn with(table: Table, settings: &TrainSettings) -> Self {
        let book = AlertBook::with(
            table,
            settings.alerts,
            settings.wagons.len() as u32,
            settings.instance.gap_folder(),
        );
        let numbers = settings.wagons.iter().map(|wagon| wagon.vehicle_number.as_ref());
        let numbers = numbers.map(|number| number.map(|number| number.written().to_owned()));
        let book = book.of_vehicles(Vehicles::new(numbers.collect())).started(started_s(settings));
        let book = if settings.judged_together { book.judged_together() } else { book };
        Self {
            train: settings.name.clone(),
            table,
            judgement: Judgement::new(settings.judged_together),
            received: Received::new(settings),
            inference: Inference::new(settings, table),
            alerts: SharedBook::new(book),
            started: None,
            first_news: false,
            history: None,
        }
    }

    /// Goes on by the thresholds of other settings of the same train; what is known stays.
    pub fn take_over(&mut self, settings: &TrainSettings) {
        self.received.stale_after_s = settings.http.stale_after_s;
        self.inference.judge_by(settings.indicators);
        self.alerts.lock().settle_by(settings.alerts);
    }

    /// What a wagon says, without what it can say only where it runs alone; to be asked before it is taken.
    #[must_use]
    pub fn limit(&self, health: &Health) -> Health {
        self.judgement.limit(self.table, health)
    }

    /// Checks and takes what is wrong with a train whose wagons are judged together; false if it is refused.
    pub fn receive_verdicts(&mut self, verdicts: &Verdicts, now: Stamp) -> bool {
        let taken = self.received.admit_verdicts(verdicts, now).is_some();
        if taken {
            self.judgement.take(verdicts);
        }
        taken
    }

    /// Checks and takes the indicators that came on the channel of a wagon; `None` if they are refused.
    pub fn receive_health<'a>(
        &mut self,
        channel: u32,
        health: &'a Health,
        now: Stamp,
    ) -> Option<Validated<'a, Health>> {
        let valid = self.received.admit(channel, health, now)?;
        if let Some(before) = self.received.take_health(valid) {
            self.first_news |= before.is_none();
            let slides = valid.wheelset[..valid.wheelset_count()].iter().any(|one| one.sliding != 0);
            if self.judgement.charts(valid.wagon, slides) {
                self.inference.chart(&valid, before.as_deref());
            }
        }
        Some(valid)
    }

    /// Whether a wagon has been heard for the first time since this was last asked: whoever waits for that need not wait for the
    /// next snapshot.
    pub fn take_first_news(&mut self) -> bool {
        std::mem::take(&mut self.first_news)
    }

    /// Checks and takes what the microphone of a wagon heard; `None` if it is refused.
    pub fn receive_heard<'a>(
        &mut self,
        channel: u32,
        heard: &'a Heard,
        now: Stamp,
    ) -> Option<Validated<'a, Heard>> {
        let valid = self.received.admit(channel, heard, now)?;
        self.received.take_heard(valid);
        Some(valid)
    }

    /// Checks and takes the heartbeat of a process; `None` if it is refused.
    pub fn receive_heartbeat<'a>(
        &mut self,
        beat: &'a Heartbeat,
        now: Stamp,
    ) -> Option<Validated<'a, Heartbeat>> {
        let valid = self.received.admit(NO_WAGON, beat, now)?;
        self.received.take_heartbeat(valid);
        Some(valid)
    }

    /// Checks and takes what the source of samples has counted; false if it is refused.
    pub fn receive_source(&mut self, state: &SourceState, now: Stamp) -> bool {
        let valid = self.received.admit(NO_WAGON, state, now);
        let taken = valid.is_some();
        if let Some(valid) = valid {
            self.received.take_source(valid);
        }
        taken
    }

    /// Checks and takes an event of another process; `None` if it is refused.
    pub fn receive_event<'a>(&mut self, event: &'a Event, now: Stamp) -> Option<Validated<'a, Event>> {
        let valid = self.received.admit(NO_WAGON, event, now)?;
        self.received.take_event(valid);
        Some(valid)
    }

    /// Takes what is wrong with the history, if anything is.
    pub fn set_history_trouble(&mut self, trouble: Option<String>) {
        self.history = trouble;
    }

    /// What can be said now.
    pub fn snapshot(&mut self, now: Stamp) -> Snapshot {
        self.received.forget_silent_processes(now);
        self.inference.compare(&self.received, now.monotonic_ns);
        let whole = self.inference.whole(&self.received, &self.judgement, now.monotonic_ns);
        let news = self.judge(&whole, now);
        let basis =
            Basis::new(self.table, &self.train, &self.received, &self.inference, &self.judgement, whole);
        Snapshot::take(basis, &self.alerts, news, now)
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
    fn judge(&mut self, whole: &Whole, now: Stamp) -> Vec<Alert> {
        let started = *self.started.get_or_insert(now);
        let mut book = self.alerts.lock();
        let judgement = &self.judgement;
        symptoms::judge(&mut book, self.table, &self.received, &self.inference, judgement, started, now);
        symptoms::judge_train(&mut book, whole, now);
        symptoms::judge_together(&mut book, judgement, started, now);
        symptoms::judge_service(&mut book, self.history.as_deref(), now);
        book.settle(now);
        book.take_news()
    }
}
