//! All alerts: raised, renewed and ended as their groups come and go.

use super::evaluate::{Evaluation, Patience, Symptom};
use super::group::{Group, group};
use super::journal::Journal;
use super::judged::Judged;
use super::model::{Alert, AlertPlace, AlertState, Change, Scope};
use super::nflog::{Notification, Receiver};
use super::place;
use super::recordings::Recordings;
use super::rule::Rules;
use super::vehicles::Vehicles;
use crate::api::grade::Grade;
use crate::api::train::model::AlertCounts;
use railgrip_indicators::{INDICATORS, Table};
use railgrip_messages::{Stamp, Verdicts};
use railgrip_settings::AlertSettings;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::PathBuf;

/// Alerts that are over and still listed.
pub(super) const REMEMBERED: usize = 200;
/// A cause that comes back again and again must stay away at most so many times longer.
const MOST_PATIENCE: u32 = 5;
/// While the journal refuses, it is tried again after this time, ns.
const JOURNAL_PAUSE_NS: u64 = 5_000_000_000;
/// Recordings of mismatches, which are written while an alert is raised, are looked for so often, ns.
const RECORDING_PAUSE_NS: u64 = 2_000_000_000;

/// All alerts of a train.
#[derive(Debug)]
pub struct AlertBook {
    rules: Rules,
    settings: AlertSettings,
    wagons: u32,
    vehicles: Vehicles,
    recordings: Recordings,
    evaluation: Evaluation,
    judged: Judged,
    pub(super) open: BTreeMap<Group, Alert>,
    pub(super) over: VecDeque<Alert>,
    last_id: u64,
    news: Vec<Alert>,
    version: u64,
    journal: Option<Journal>,
    unsaved: BTreeSet<u64>,
    notifications: Vec<Notification>,
    refused_ns: Option<u64>,
    /// When recordings were last looked for, monotonic, ns.
    looked_ns: u64,
    trouble: Option<String>,
}

impl AlertBook {
    /// No alert yet of a train of so many wagons; recordings of mismatches lie in `gaps`.
    #[must_use]
    pub fn new(settings: AlertSettings, wagons: u32, gaps: PathBuf) -> Self {
        Self::with(INDICATORS, settings, wagons, gaps)
    }

    /// The same by the rules of another table of indicators.
    #[must_use]
    pub fn with(table: Table, settings: AlertSettings, wagons: u32, gaps: PathBuf) -> Self {
        Self {
            rules: Rules { table, together: false },
            settings,
            wagons,
            vehicles: Vehicles::default(),
            recordings: Recordings { folder: gaps, started_s: None },
            evaluation: Evaluation::default(),
            judged: Judged::default(),
            open: BTreeMap::new(),
            over: VecDeque::new(),
            last_id: 0,
            news: Vec::new(),
            version: 0,
            journal: None,
            unsaved: BTreeSet::new(),
            notifications: Vec::new(),
            refused_ns: None,
            looked_ns: 0,
            trouble: None,
        }
    }

    /// The wagons are these vehicles.
    #[must_use]
    pub fn of_vehicles(self, vehicles: Vehicles) -> Self {
        Self { vehicles, ..self }
    }

    /// The train was started at that second, Unix; unknown where it has no sign of its own.
    #[must_use]
    pub fn started(mut self, unix_s: Option<i64>) -> Self {
        self.recordings.started_s = unix_s;
        self
    }

    /// The wagons are judged together from now on, by their causes.
    #[must_use]
    pub fn judged_together(mut self) -> Self {
        self.rules.together = true;
        self
    }

    /// Raises, groups and clears by other settings from now on.
    pub fn settle_by(&mut self, settings: AlertSettings) {
        self.settings = settings;
    }

    /// Tells other receivers from now on, and keeps so many notifications at most. What waits for a receiver that is gone stays.
    pub fn address(&mut self, receivers: Vec<Receiver>, most_waiting: u32) {
        if let Some(journal) = &mut self.journal {
            journal.address(receivers, most_waiting);
        }
    }

    /// Takes what is wrong with a train whose wagons are judged together; what is not named any more is gone.
    pub fn judge_together(&mut self, verdicts: &Verdicts, now: Stamp) {
        let rules = self.rules;
        let before = self.evaluation.of_rules(|rule| rules.judged(rule).is_some());
        for (symptom, grade, reason) in self.judged.take(verdicts, &before) {
            self.judge(symptom, grade, &reason, now);
        }
    }

    /// Goes on from what the journal kept, and keeps everything in it from now on.
    pub fn keep_in(&mut self, journal: Journal, kept: Vec<Alert>) {
        for mut alert in kept {
            self.vehicles.name(&mut alert);
            self.last_id = self.last_id.max(alert.id);
            if !alert.active {
                self.over.push_back(alert);
                continue;
            }
            for place in alert.places.iter().filter(|place| place.wagon <= self.wagons) {
                let Some(rule) = self.rules.known(&place.indicator) else {
                    continue;
                };
                let symptom = Symptom { wagon: place.wagon, wheelset: place.wheelset, rule };
                self.judged.restore(rule, place.wagon, alert.wagon);
                self.evaluation.restore(symptom, place.grade, place.reason.clone());
            }
            let wagon = (alert.scope == Scope::Wagon).then_some(alert.wagon);
            self.open.insert((alert.cause.clone(), wagon), alert);
        }
        self.over.make_contiguous().sort_by_key(|alert| std::cmp::Reverse(alert.unix_ns));
        self.journal = Some(journal);
        self.version += 1;
    }

    /// Takes in how a symptom is judged now. `Unknown` neither raises nor clears.
    pub fn judge(&mut self, symptom: Symptom, grade: Grade, reason: &str, now: Stamp) {
        let clear_s = self.clear_after_s(&symptom);
        let raise_s = self.settings.raise_after_s * self.rules.patience(symptom.rule, grade);
        let patience = Patience { raise_s, clear_s };
        self.evaluation.judge(symptom, grade, reason, patience, now);
    }

    /// What comes back again and again must stay away longer: twice as long each time.
    fn clear_after_s(&self, symptom: &Symptom) -> f64 {
        let name = self.rules.cause_of(symptom.rule);
        let alert = [Some(symptom.wagon), None]
            .into_iter()
            .find_map(|wagon| self.open.get(&(name.to_owned(), wagon)));
        let times = alert.map_or(1, |alert| alert.times);
        self.settings.clear_after_s * f64::from(1u32 << (times - 1).min(MOST_PATIENCE))
    }

    /// Turns the symptoms that fire into alerts; to be called after all were judged.
    pub fn settle(&mut self, now: Stamp) {
        let is_common = |cause: &str, wagons| self.is_common(cause, wagons);
        let home = |rule, wagon| self.judged.home(rule, wagon);
        let mut shown = group(self.rules, self.evaluation.firing(), is_common, home);
        shown.values_mut().flatten().for_each(|place| {
            self.vehicles.name_place(place);
            place::ease(place);
        });
        let gone: Vec<Group> = self.open.keys().filter(|key| !shown.contains_key(*key)).cloned().collect();
        for key in gone {
            let into = shown.contains_key(&(key.0.clone(), None)) && key.1.is_some();
            self.end(&key, into, now);
        }
        let keys: Vec<Group> = shown.keys().cloned().collect();
        for key in keys {
            let places = shown.remove(&key).unwrap_or_default();
            if self.open.contains_key(&key) {
                self.renew(&key, places, now);
            } else {
                self.raise(key, places, now);
            }
        }
        for ((cause, wagon), alert) in &mut self.open {
            self.judged.explain(cause, wagon.unwrap_or(0), alert);
        }
        self.find_recordings(now);
        self.end_silences(now);
        self.save(now);
    }

    /// Adds recordings to alerts that were raised before theirs was written, and what their diagnosis found, which comes
    /// minutes later: the alert may be over by then.
    fn find_recordings(&mut self, now: Stamp) {
        if now.monotonic_ns.saturating_sub(self.looked_ns) < RECORDING_PAUSE_NS {
            return;
        }
        self.looked_ns = now.monotonic_ns;
        let rules = self.rules;
        let lacks =
            |alert: &&mut Alert| alert.evidence.recording.is_none() && rules.is_recorded(&alert.cause);
        for alert in self.open.values_mut().filter(lacks) {
            alert.find_recording(&self.recordings);
            if alert.evidence.recording.is_some() {
                self.version += 1;
                self.unsaved.insert(alert.id);
            }
        }
        for alert in self.open.values_mut().chain(&mut self.over) {
            if rules.is_recorded(&alert.cause) && alert.find_diagnosis(&self.recordings) {
                self.version += 1;
                self.unsaved.insert(alert.id);
            }
        }
    }

    /// True if so many wagons with one cause mean that it is the train's; once it is, it stays so until it is gone.
    fn is_common(&self, cause: &str, wagons: usize) -> bool {
        let share = self.settings.group_share * f64::from(self.wagons);
        let many = wagons as f64 >= share.max(f64::from(self.settings.group_least));
        many || self.open.contains_key(&(cause.to_owned(), None))
    }

    fn raise(&mut self, key: Group, places: Vec<AlertPlace>, now: Stamp) {
        let window_ns = (self.settings.reopen_within_s * 1e9) as i64;
        let scope = if key.1.is_some() { Scope::Wagon } else { Scope::Train };
        let same = |alert: &Alert| {
            let here = |wagon| alert.wagon == wagon && (wagon == 0 || alert.wagons.contains(&wagon));
            alert.cause == key.0
                && alert.scope == scope
                && key.1.is_none_or(here)
                && (0..=window_ns).contains(&(now.unix_ns - alert.unix_ns))
                && alert.history.last().is_none_or(|line| line.change != Change::Merged)
        };
        let known = self.over.iter().position(same).and_then(|index| self.over.remove(index));
        let (mut alert, change) = match known {
            Some(mut alert) => {
                if alert.silenced.as_ref().is_some_and(|silence| silence.until_unix_ns <= now.unix_ns) {
                    alert.silenced = None;
                }
                alert.come_back(places, now);
                (alert, Change::Returned)
            }
            None => {
                self.last_id += 1;
                let advice = self.rules.advice(&key.0, scope);
                let mut alert = Alert::new(self.last_id, &key.0, scope, advice, places, now);
                let said = alert.reason.clone();
                alert.note(Change::Raised, None, Some(said), now);
                (alert, Change::Raised)
            }
        };
        self.vehicles.name(&mut alert);
        if self.rules.is_recorded(&alert.cause) {
            alert.find_recording(&self.recordings);
        }
        self.tell(&alert, change, now);
        self.open.insert(key, alert);
    }

    fn renew(&mut self, key: &Group, places: Vec<AlertPlace>, now: Stamp) {
        let Some(alert) = self.open.get_mut(key) else { return };
        if alert.places == places {
            return;
        }
        let (worst, before, wagons) = (alert.grade, alert.grade_now, alert.wagons.len());
        let seen = places.iter().any(|place| place.well_since.is_none());
        alert.show(places);
        self.vehicles.name(alert);
        let change = if alert.grade_now > worst {
            alert.become_worse(now);
            Some(Change::Worse)
        } else if alert.wagons.len() > wagons {
            alert.note(Change::Spread, None, Some(alert.reason.clone()), now);
            Some(Change::Spread)
        // What only waits until it is over is not told as better: it may be back at once.
        } else if alert.grade_now < before && seen {
            alert.note(Change::Better, None, Some(alert.reason.clone()), now);
            Some(Change::Better)
        } else {
            None
        };
        let alert = alert.clone();
        match change {
            Some(change) => self.tell(&alert, change, now),
            // Words and figures move all the time; they are shown, but neither told nor kept.
            None => self.version += 1,
        }
    }

    fn end(&mut self, key: &Group, merged: bool, now: Stamp) {
        let Some(mut alert) = self.open.remove(key) else { return };
        let change = if merged { Change::Merged } else { Change::Cleared };
        let note = merged.then(|| "part of an alert of the whole train now".to_owned());
        alert.end(change, note, now);
        self.vehicles.name(&mut alert);
        self.tell(&alert, change, now);
        self.over.push_front(alert);
        if let Some(forgotten) = self.over.get(REMEMBERED) {
            self.unsaved.insert(forgotten.id);
        }
        self.over.truncate(REMEMBERED);
    }

    fn end_silences(&mut self, now: Stamp) {
        let due = |alert: &&mut Alert| {
            alert.silenced.as_ref().is_some_and(|silence| silence.until_unix_ns <= now.unix_ns)
        };
        let mut back = Vec::new();
        for alert in self.open.values_mut().filter(due) {
            alert.silenced = None;
            alert.note(Change::Unsilenced, None, Some("its time is over".to_owned()), now);
            back.push(alert.clone());
        }
        back.iter().for_each(|alert| self.tell(alert, Change::Unsilenced, now));
    }

    pub(super) fn tell(&mut self, alert: &Alert, change: Change, now: Stamp) {
        self.version += 1;
        self.news.push(alert.clone());
        self.unsaved.insert(alert.id);
        if change.is_notified() && alert.silenced.is_none() {
            self.notifications.push(Notification { alert: alert.clone(), change, at_unix_ns: now.unix_ns });
        }
    }

    /// Writes what changed. While the disk refuses, everything live goes on and it is tried again.
    pub(super) fn save(&mut self, now: Stamp) {
        let Some(journal) = &mut self.journal else {
            self.unsaved.clear();
            self.notifications.clear();
            return;
        };
        if self.unsaved.is_empty() && self.notifications.is_empty() {
            return;
        }
        let waits = |refused_ns| now.monotonic_ns.saturating_sub(refused_ns) < JOURNAL_PAUSE_NS;
        if self.refused_ns.is_some_and(waits) {
            return;
        }
        let known = || self.open.values().chain(&self.over).filter(|alert| self.unsaved.contains(&alert.id));
        let (kept, gone): (Vec<&Alert>, Vec<u64>) = (
            known().collect(),
            self.unsaved.iter().copied().filter(|id| !known().any(|alert| alert.id == *id)).collect(),
        );
        match journal.save(&kept, &gone, &self.notifications) {
            Ok(()) => {
                self.unsaved.clear();
                self.notifications.clear();
                (self.refused_ns, self.trouble) = (None, None);
            }
            Err(error) => {
                if self.trouble.is_none() {
                    tracing::warn!(%error, "alerts are not kept: a restart would forget them");
                }
                (self.refused_ns, self.trouble) = (Some(now.monotonic_ns), Some(error.to_string()));
            }
        }
    }

    /// Why alerts are not kept at the moment, if so.
    #[must_use]
    pub fn trouble(&self) -> Option<&str> {
        self.trouble.as_deref()
    }

    /// Says that alerts are not kept, and why.
    pub fn set_trouble(&mut self, trouble: String) {
        self.trouble = Some(trouble);
    }

    /// Rises with every change.
    #[must_use]
    pub const fn version(&self) -> u64 {
        self.version
    }

    /// What happened since it was last asked.
    pub fn take_news(&mut self) -> Vec<Alert> {
        std::mem::take(&mut self.news)
    }

    /// Active alerts, those that nobody has taken notice of first, worst and latest first; then those that are over.
    #[must_use]
    pub fn list(&self) -> Vec<Alert> {
        let mut active: Vec<Alert> = self.open.values().cloned().collect();
        let rest = |alert: &Alert| match alert.state {
            AlertState::Active => 0,
            AlertState::Acknowledged => 1,
            AlertState::Silenced | AlertState::Cleared => 2,
        };
        active.sort_by_key(|alert| {
            (rest(alert), std::cmp::Reverse(alert.grade_now), std::cmp::Reverse(alert.id))
        });
        active.extend(self.over.iter().cloned());
        active
    }

    /// The alert of that number.
    #[must_use]
    pub fn get(&self, id: u64) -> Option<Alert> {
        self.open.values().chain(&self.over).find(|alert| alert.id == id).cloned()
    }

    /// How many are active and not silenced.
    #[must_use]
    pub fn counts(&self) -> AlertCounts {
        let told = self.open.values().filter(|alert| alert.silenced.is_none());
        let of = |grade| told.clone().filter(|alert| alert.grade_now == grade).count() as u32;
        AlertCounts { watch: of(Grade::Watch), act: of(Grade::Act) }
    }
}
