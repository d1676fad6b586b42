//! What is known about the train, and the snapshots of it that requests are answered from.
//!
//! One thread feeds the store and takes a snapshot several times a second; requests only read the latest one. What most
//! requests ask for is serialised once a snapshot, not once a request.

use crate::alerts::{AlertBook, Cause, SharedBook};
use crate::model::{
    Alert, AlertList, DataState, Grade, ProcessView, TrainView, WagonList, WagonRow, WagonView,
};
use crate::time::rfc3339;
use crate::view::{self, Freshness};
use axum::body::Bytes;
use railgrip_messages::{Health, Heartbeat, ProcessKind, Stamp};
use railgrip_settings::TrainSettings;
use serde::Serialize;
use std::collections::BTreeMap;

/// A process that has been quiet for so long is no longer listed, s.
const PROCESS_GONE_S: f64 = 30.0;

/// Everything that arrived.
#[derive(Debug)]
pub struct Store {
    train: String,
    wagons: Vec<Known>,
    heartbeats: BTreeMap<(u32, u32), Heartbeat>,
    alerts: SharedBook,
    stale_after_s: f64,
    started: Option<Stamp>,
    /// What is wrong with the history.
    history: Option<String>,
}

#[derive(Debug)]
struct Known {
    number: u32,
    name: String,
    health: Option<Box<Health>>,
}

/// The train at one instant, ready to be served.
#[derive(Debug, Clone)]
pub struct Snapshot {
    /// When it was taken.
    pub taken: Stamp,
    /// The train at a glance.
    pub train: TrainView,
    /// One line a wagon.
    pub rows: Vec<WagonRow>,
    /// All about each wagon.
    pub wagons: Vec<WagonView>,
    /// All alerts.
    pub alerts: AlertList,
    /// Why the train is not ready; empty if it is.
    pub not_ready: Vec<String>,
    /// `rows` as JSON.
    pub rows_json: Bytes,
    /// `train` as JSON.
    pub train_json: Bytes,
    /// What happened to alerts since the snapshot before.
    pub news: Vec<Alert>,
    /// The alerts themselves, for those who change them.
    pub book: SharedBook,
    /// Version of the alerts in this snapshot.
    pub alert_version: u64,
}

impl Store {
    /// Nothing has arrived yet.
    #[must_use]
    pub fn new(settings: &TrainSettings) -> Self {
        let known = |wagon: &railgrip_settings::WagonSettings| Known {
            number: wagon.number,
            name: wagon.name.clone(),
            health: None,
        };
        Self {
            train: settings.name.clone(),
            wagons: settings.wagons.iter().map(known).collect(),
            heartbeats: BTreeMap::new(),
            alerts: SharedBook::new(AlertBook::new(
                settings.alerts,
                settings.wagons.len() as u32,
                settings.instance.dir.join("gaps"),
            )),
            stale_after_s: settings.http.stale_after_s,
            started: None,
            history: None,
        }
    }

    /// Takes the indicators of a wagon; those of an unknown wagon, and older ones than it has, are ignored.
    pub fn take_health(&mut self, health: &Health) {
        let Some(known) = self.wagons.iter_mut().find(|known| known.number == health.wagon) else { return };
        let newer = |old: &Health| health.published_monotonic_ns >= old.published_monotonic_ns;
        if known.health.as_deref().is_none_or(newer) {
            known.health = Some(Box::new(*health));
        }
    }

    /// Takes the heartbeat of a process.
    pub fn take_heartbeat(&mut self, beat: &Heartbeat) {
        self.heartbeats.insert((beat.process, beat.wagon), *beat);
    }

    /// Takes what is wrong with the history, if anything is.
    pub fn set_history_trouble(&mut self, trouble: Option<String>) {
        self.history = trouble;
    }

    /// What can be said now.
    pub fn snapshot(&mut self, now: Stamp) -> Snapshot {
        let now_ns = now.monotonic_ns;
        self.heartbeats.retain(|_, beat| beat.stamp.age_s(now_ns) < PROCESS_GONE_S);
        let news = self.judge(now);
        let mut rows = Vec::with_capacity(self.wagons.len());
        let mut wagons = Vec::with_capacity(self.wagons.len());
        for known in &self.wagons {
            let health = known.health.as_deref();
            let fresh = Freshness::of(health, now_ns, self.stale_after_s);
            let estimator = self.heartbeats.get(&(ProcessKind::Estimator.code(), known.number));
            rows.push(view::row(known.number, &known.name, health, fresh));
            wagons.push(view::wagon(known.number, &known.name, health, estimator, fresh, now_ns));
        }
        let not_ready: Vec<String> = rows
            .iter()
            .filter(|row| row.state != DataState::Live)
            .map(|row| format!("wagon {} ({}) is {}", row.id, row.name, row.reason))
            .collect();
        let train = self.train_view(&rows, not_ready.is_empty(), now);
        let list = WagonList {
            train: self.train.clone(),
            generated_at: train.generated_at.clone(),
            wagons: rows.clone(),
            next: None,
        };
        let book = self.alerts.lock();
        let (alert_version, alerts) = (book.version(), AlertList { alerts: book.list(), next: None });
        drop(book);
        Snapshot {
            taken: now,
            rows_json: json(&list),
            train_json: json(&train),
            train,
            rows,
            wagons,
            alerts,
            not_ready,
            news,
            book: self.alerts.clone(),
            alert_version,
        }
    }

    /// The alerts, for whoever keeps them.
    #[must_use]
    pub fn book(&self) -> SharedBook {
        self.alerts.clone()
    }

    fn judge(&mut self, now: Stamp) -> Vec<Alert> {
        let started = *self.started.get_or_insert(now);
        let mut book = self.alerts.lock();
        for known in &self.wagons {
            let wagon = known.number;
            // A wagon of which nothing came is as old as this service.
            let last = known.health.as_deref().map_or(started, |health| health.acquired);
            let age_s = last.age_s(now.monotonic_ns);
            let stale = age_s > self.stale_after_s;
            let (grade, reason) = if stale {
                (Grade::Act, format!("no news since {}", rfc3339(last.unix_ns)))
            } else {
                (Grade::Ok, String::new())
            };
            let silent = Cause { wagon, wheelset: None, name: "silent" };
            book.judge(silent, grade, &reason, now);
            let Some(health) = known.health.as_deref().filter(|_| !stale) else { continue };
            for (name, wheelset, indicator) in view::judged(health) {
                let cause = Cause { wagon, wheelset, name };
                book.judge(cause, indicator.grade().into(), indicator.reason.as_str(), now);
            }
        }
        let (grade, reason) = match book.trouble() {
            Some(trouble) => (Grade::Act, format!("alerts are not kept: {trouble}")),
            None => (Grade::Ok, String::new()),
        };
        book.judge(Cause { wagon: 0, wheelset: None, name: "storage" }, grade, &reason, now);
        let (grade, reason) = match &self.history {
            Some(trouble) => (Grade::Act, format!("nothing is remembered, all else goes on: {trouble}")),
            None => (Grade::Ok, String::new()),
        };
        book.judge(Cause { wagon: 0, wheelset: None, name: "history" }, grade, &reason, now);
        book.settle(now);
        book.take_news()
    }

    fn train_view(&self, rows: &[WagonRow], ready: bool, now: Stamp) -> TrainView {
        let count = |state| rows.iter().filter(|row| row.state == state).count() as u32;
        let mut worst: Vec<WagonRow> = rows.iter().filter(|row| row.grade >= Grade::Watch).cloned().collect();
        worst.sort_by_key(|row| std::cmp::Reverse(row.grade));
        let known = rows.iter().max_by_key(|row| (row.grade, std::cmp::Reverse(row.id)));
        let (grade, reason) = match known {
            Some(row) if row.grade >= Grade::Watch => {
                (row.grade, format!("wagon {}: {}", row.id, row.reason))
            }
            Some(row) if row.grade == Grade::Ok => {
                (Grade::Ok, "everything known is as it should be".to_owned())
            }
            _ => (Grade::Unknown, "nothing is known yet".to_owned()),
        };
        TrainView {
            name: self.train.clone(),
            generated_at: rfc3339(now.unix_ns),
            ready,
            grade,
            reason,
            wagons: rows.len() as u32,
            live: count(DataState::Live),
            stale: count(DataState::Stale),
            silent: count(DataState::Silent),
            worst,
            alerts: self.alerts.lock().counts(),
            processes: self.processes(now.monotonic_ns),
        }
    }

    fn processes(&self, now_ns: u64) -> Vec<ProcessView> {
        self.heartbeats.values().map(|beat| view::process(beat, now_ns)).collect()
    }
}

/// JSON of a view; views hold nothing that cannot be JSON.
pub(crate) fn json(view: &impl Serialize) -> Bytes {
    serde_json::to_vec(view).unwrap_or_default().into()
}
