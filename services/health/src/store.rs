//! What is known about the train, and the snapshots of it that requests are answered from.
//!
//! One thread feeds the store and takes a snapshot several times a second; requests only read the latest one. What most
//! requests ask for is serialised once a snapshot, not once a request.

use crate::alerts::{AlertBook, Cause, SharedBook};
use crate::heard;
use crate::model::{
    Alert, AlertList, DataState, Grade, ProcessView, TrainView, WagonList, WagonRow, WagonView,
};
use crate::neighbours::Neighbours;
use crate::time::rfc3339;
use crate::train::Whole;
use crate::view::{self, Freshness};
use axum::body::Bytes;
use railgrip_indicators::IndicatorSettings;
use railgrip_indicators::belief::{Evidence, Rail};
use railgrip_indicators::stopping::BrakedWagon;
use railgrip_indicators::track::{KeptCell, TrackMap};
use railgrip_messages::{Health, Heard, Heartbeat, ProcessKind, Stamp, WheelsetHealth};
use railgrip_settings::{CapabilitySettings, TrainSettings};
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A process that has been quiet for so long is no longer listed, s.
const PROCESS_GONE_S: f64 = 30.0;
/// Stopping distances and the map are worked out so often, ns.
const WHOLE_PERIOD_NS: u64 = 2_000_000_000;

/// Everything that arrived.
#[derive(Debug)]
pub struct Store {
    train: String,
    wagons: Vec<Known>,
    heartbeats: BTreeMap<(u32, u32), Heartbeat>,
    alerts: SharedBook,
    stale_after_s: f64,
    started: Option<Stamp>,
    map: TrackMap,
    capability: CapabilitySettings,
    indicators: IndicatorSettings,
    neighbours: Neighbours,
    /// When the neighbours were last compared, monotonic, ns.
    compared_ns: Option<u64>,
    /// What is said of the whole train, and when that was worked out.
    whole: Option<(u64, Arc<Whole>)>,
    /// What is wrong with the history.
    history: Option<String>,
}

#[derive(Debug)]
struct Known {
    number: u32,
    name: String,
    nominal: BrakedWagon,
    nominal_friction: f64,
    /// Adhesion available on dry, wet, low and very low rail.
    rail: [f64; 4],
    health: Option<Box<Health>>,
    microphone: bool,
    heard: Option<Heard>,
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
    /// What is said of the whole train.
    pub whole: Arc<Whole>,
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
            nominal: BrakedWagon {
                mass_kg: wagon.vehicle.body.mass_kg,
                friction_ratio: [1.0; 3],
                adhesion: [wagon.vehicle.rail.dry; 3],
                braked_share: 1.0,
                resistance: [
                    wagon.vehicle.resistance.constant_n,
                    wagon.vehicle.resistance.linear_n_s_per_m,
                    wagon.vehicle.resistance.drag_n_s2_per_m2,
                ],
            },
            nominal_friction: wagon.vehicle.brake.friction_coefficient,
            rail: {
                let rail = &wagon.vehicle.rail;
                [rail.dry, rail.wet, rail.low, 0.5 * rail.low]
            },
            health: None,
            microphone: settings.microphone(wagon.number).is_some(),
            heard: None,
        };
        let rail = settings.wagons.first().map_or([0.30, 0.12, 0.06], |wagon| {
            let rail = &wagon.vehicle.rail;
            [rail.dry, rail.wet, rail.low]
        });
        let capability = settings.capability.clone();
        let rail = Rail::new(rail, settings.indicators.adhesion.prior_dry, capability.map_memory_s);
        let map = TrackMap::new(rail, capability.cell_m, capability.most_cells as usize);
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
            map,
            capability,
            indicators: settings.indicators,
            neighbours: Neighbours::default(),
            compared_ns: None,
            whole: None,
            history: None,
        }
    }

    /// Takes the indicators of a wagon; those of an unknown wagon, and older ones than it has, are ignored.
    pub fn take_health(&mut self, health: &Health) {
        let Some(known) = self.wagons.iter_mut().find(|known| known.number == health.wagon) else { return };
        let newer = |old: &Health| health.published_monotonic_ns >= old.published_monotonic_ns;
        if known.health.as_deref().is_none_or(newer) {
            let before_ns = known.health.as_deref().map(|old| old.acquired.monotonic_ns);
            chart(&mut self.map, health, before_ns);
            known.health = Some(Box::new(*health));
        }
    }

    /// Takes what a microphone heard.
    pub fn take_heard(&mut self, heard: &Heard) {
        if let Some(known) = self.wagons.iter_mut().find(|known| known.number == heard.wagon) {
            known.heard = Some(*heard);
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
        self.compare(now_ns);
        let news = self.judge(now);
        let mut rows = Vec::with_capacity(self.wagons.len());
        let mut wagons = Vec::with_capacity(self.wagons.len());
        for known in &self.wagons {
            let health = known.health.as_deref();
            let fresh = Freshness::of(health, now_ns, self.stale_after_s);
            let estimator = self.heartbeats.get(&(ProcessKind::Estimator.code(), known.number));
            let mut row = view::row(known.number, &known.name, health, fresh);
            let mut wagon = view::wagon(known.number, &known.name, health, estimator, fresh, now_ns);
            if row.state == DataState::Live {
                self.neighbours.amend(&mut row, &mut wagon, &self.indicators);
            }
            rows.push(row);
            wagon.acoustic =
                known.microphone.then(|| heard::acoustic(known.heard.as_ref(), now_ns, self.stale_after_s));
            wagons.push(wagon);
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
            whole: self.latest_whole(now_ns),
            alerts,
            not_ready,
            news,
            book: self.alerts.clone(),
            alert_version,
        }
    }

    /// Goes on from cells of the map that were kept; returns how many there were.
    pub fn restore_map(&mut self, cells: &[(i64, Vec<u8>)], now: Stamp) -> usize {
        self.map.restore(cells, unix_ahead_s(now))
    }

    /// Cells of the map that have changed since this was last asked.
    pub fn changed_map(&mut self, now: Stamp) -> Vec<KeptCell> {
        self.map.take_changed(unix_ahead_s(now))
    }

    /// The alerts, for whoever keeps them.
    #[must_use]
    pub fn book(&self) -> SharedBook {
        self.alerts.clone()
    }

    /// Sets the live wagons beside each other.
    fn compare(&mut self, now_ns: u64) {
        let before_ns = self.compared_ns.replace(now_ns).unwrap_or(now_ns);
        let fresh = |health: &&Health| health.acquired.age_s(now_ns) <= self.stale_after_s;
        let live: Vec<&Health> =
            self.wagons.iter().filter_map(|known| known.health.as_deref()).filter(fresh).collect();
        let dt_s = now_ns.saturating_sub(before_ns) as f64 * 1e-9;
        self.neighbours.take(&live, now_ns, dt_s, &self.indicators);
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
            if let Some(without) = self.neighbours.without(wagon, &self.indicators) {
                book.judge(
                    Cause { wagon, wheelset: None, name: "no_pressure" },
                    without.grade,
                    &without.reason,
                    now,
                );
            }
            let delay = self.neighbours.delay(wagon, &self.indicators);
            book.judge(Cause { wagon, wheelset: None, name: "late" }, delay.grade, &delay.reason, now);
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

    /// The wagons as they brake now; what is stale or unknown is nominal with a wide interval.
    fn whole(&self, now_ns: u64) -> Whole {
        let braked = |known: &Known| {
            let mut now = known.nominal;
            now.friction_ratio = [1.0, 0.7, 1.1];
            let fresh = |health: &&Health| health.acquired.age_s(now_ns) <= self.stale_after_s;
            if let Some(health) = known.health.as_deref().filter(fresh) {
                let friction = &health.brake_friction;
                if friction.known != 0 {
                    now.friction_ratio = [friction.value, friction.low, friction.high]
                        .map(|value| value / known.nominal_friction);
                }
                let available = &health.adhesion_available;
                if available.known != 0 && health.adhesion_available_is_bound == 0 {
                    now.adhesion = [available.value, available.low, available.high];
                } else if available.known != 0 {
                    // No slide of late: the mean over what the rail may be, within what is known of it.
                    let classes = known.rail.iter().zip(health.condition_probability);
                    let mean: f64 = classes.map(|(adhesion, share)| adhesion * share).sum();
                    let high = available.high.max(available.low);
                    now.adhesion = [mean.clamp(available.low, high), available.low, high];
                }
                let wheelsets = &health.wheelset[..health.wheelset_count()];
                let isolated = wheelsets.iter().map(|one| &one.isolated);
                let without: f64 = isolated.filter(|one| one.known != 0).map(|one| one.value).sum();
                if !wheelsets.is_empty() {
                    now.braked_share = (1.0 - without / wheelsets.len() as f64).clamp(0.0, 1.0);
                }
            }
            (now, known.nominal)
        };
        let known = self.wagons.iter().filter(|known| {
            let health = known.health.as_deref();
            health.is_some_and(|health| {
                health.acquired.age_s(now_ns) <= self.stale_after_s && health.brake_friction.known != 0
            })
        });
        let (braked, known) = (self.wagons.iter().map(braked).collect(), known.count());
        Whole::new(braked, known, &self.capability, &self.map, now_ns as f64 * 1e-9)
    }

    /// What is said of the whole train; worked out anew every few seconds.
    fn latest_whole(&mut self, now_ns: u64) -> Arc<Whole> {
        if let Some((at_ns, whole)) = &self.whole
            && now_ns.saturating_sub(*at_ns) < WHOLE_PERIOD_NS
        {
            return Arc::clone(whole);
        }
        let whole = Arc::new(self.whole(now_ns));
        self.whole = Some((now_ns, Arc::clone(&whole)));
        whole
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

/// What the wall clock is ahead of the monotonic one, s.
fn unix_ahead_s(now: Stamp) -> f64 {
    now.unix_ns as f64 * 1e-9 - now.monotonic_ns as f64 * 1e-9
}

/// Puts what a wagon says onto the map, for the time since it last spoke.
fn chart(map: &mut TrackMap, health: &Health, before_ns: Option<u64>) {
    let known = health.position_m != 0.0 && health.v_m_s > 0.5 && health.mu_w_sigma > 0.0;
    let Some(before_ns) = before_ns.filter(|_| known) else { return };
    let seconds = health.acquired.monotonic_ns.saturating_sub(before_ns) as f64 * 1e-9;
    if !(0.0..=1.0).contains(&seconds) || seconds == 0.0 {
        return;
    }
    let wheelsets = &health.wheelset[..health.wheelset_count()];
    let slides =
        |one: &&WheelsetHealth| one.sliding != 0 && (one.wsp_active != 0 || one.pressing_force_n > 2000.0);
    let (sum, number) =
        wheelsets.iter().filter(slides).fold((0.0, 0.0), |(sum, n), one| (sum + one.mu_w.abs(), n + 1.0));
    let sliding = number > 0.0;
    let utilised = if sliding { sum / number } else { health.mu_w.abs() };
    let evidence = Evidence { utilised, sigma: health.mu_w_sigma, sliding };
    let now_s = health.acquired.monotonic_ns as f64 * 1e-9;
    map.add(health.wagon, health.position_m, now_s, seconds, evidence);
}

/// JSON of a view; views hold nothing that cannot be JSON.
pub(crate) fn json(view: &impl Serialize) -> Bytes {
    serde_json::to_vec(view).unwrap_or_default().into()
}
