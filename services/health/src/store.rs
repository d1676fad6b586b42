//! What is known about the train, and the snapshots of it that requests are answered from.
//!
//! One thread feeds the store and takes a snapshot several times a second; requests only read the latest one. What most
//! requests ask for is serialised once a snapshot, not once a request.

use crate::alerts::{AlertBook, Cause};
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
    alerts: AlertBook,
    stale_after_s: f64,
    started: Option<Stamp>,
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
    /// Alerts raised or cleared since the snapshot before.
    pub news: Vec<Alert>,
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
            alerts: AlertBook::new(settings.alerts),
            stale_after_s: settings.http.stale_after_s,
            started: None,
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
        };
        Snapshot {
            taken: now,
            rows_json: json(&list),
            train_json: json(&train),
            train,
            rows,
            wagons,
            alerts: AlertList { alerts: self.alerts.list() },
            not_ready,
            news,
        }
    }

    fn judge(&mut self, now: Stamp) -> Vec<Alert> {
        let mut news = Vec::new();
        let started = *self.started.get_or_insert(now);
        for known in &self.wagons {
            let wagon = known.number;
            // A wagon of which nothing came is as old as this service.
            let last = known.health.as_deref().map_or(started, |health| health.acquired);
            let age_s = last.age_s(now.monotonic_ns);
            let stale = age_s > self.stale_after_s;
            let (grade, reason) = if stale {
                (Grade::Act, format!("no news for {age_s:.0} s"))
            } else {
                (Grade::Ok, String::new())
            };
            let silent = Cause { wagon, wheelset: None, name: "silent" };
            news.extend(self.alerts.judge(silent, grade, &reason, now));
            let Some(health) = known.health.as_deref().filter(|_| !stale) else { continue };
            for (name, wheelset, indicator) in view::judged(health) {
                let cause = Cause { wagon, wheelset, name };
                news.extend(self.alerts.judge(
                    cause,
                    indicator.grade().into(),
                    indicator.reason.as_str(),
                    now,
                ));
            }
        }
        news
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
            alerts: self.alerts.counts(),
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
