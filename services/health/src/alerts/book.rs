//! All alerts, with the state of what may become one.

mod people;

pub use people::Refusal;

use super::journal::{Journal, Letter};
use super::model::{Alert, AlertPlace, AlertState, Change, Scope};
use super::rules;
use crate::api::grade::Grade;
use crate::api::train::model::AlertCounts;
use railgrip_messages::Stamp;
use railgrip_settings::AlertSettings;
use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::PathBuf;

/// Alerts that are over and still listed.
const REMEMBERED: usize = 200;
/// A cause that comes back again and again must stay away at most so many times longer.
const MOST_PATIENCE: u32 = 5;
/// While the journal refuses, it is tried again after so long, ns.
const JOURNAL_PAUSE_NS: u64 = 5_000_000_000;
/// Recordings of mismatches, which are written while an alert is raised, are looked for so often, ns.
const RECORDING_PAUSE_NS: u64 = 2_000_000_000;

/// A symptom: an indicator at one place. Wagon 0 is the train itself, or this service.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Cause {
    /// The wagon.
    pub wagon: u32,
    /// The wheelset, 1 leading.
    pub wheelset: Option<u32>,
    /// The indicator, or `silent`, `no_pressure`, `late`, `storage`.
    pub name: &'static str,
}

/// Whether a symptom counts.
#[derive(Debug, Default)]
struct Watched {
    bad_since_ns: Option<u64>,
    good_since_ns: Option<u64>,
    /// Since when it is worse than what counts, or less bad.
    other_since_ns: Option<u64>,
    counts: Option<(Grade, String)>,
}

/// A cause, of the train or of one wagon.
type Key = (String, Option<u32>);

/// See the module.
#[derive(Debug)]
pub struct AlertBook {
    settings: AlertSettings,
    wagons: u32,
    gaps: PathBuf,
    watched: BTreeMap<Cause, Watched>,
    open: BTreeMap<Key, Alert>,
    over: VecDeque<Alert>,
    last_id: u64,
    news: Vec<Alert>,
    version: u64,
    journal: Option<Journal>,
    unsaved: BTreeSet<u64>,
    letters: Vec<Letter>,
    refused_ns: Option<u64>,
    /// When recordings were last looked for, monotonic, ns.
    looked_ns: u64,
    trouble: Option<String>,
}

impl AlertBook {
    /// No alert yet of a train of so many wagons; recordings of mismatches lie in `gaps`.
    #[must_use]
    pub fn new(settings: AlertSettings, wagons: u32, gaps: PathBuf) -> Self {
        Self {
            settings,
            wagons,
            gaps,
            watched: BTreeMap::new(),
            open: BTreeMap::new(),
            over: VecDeque::new(),
            last_id: 0,
            news: Vec::new(),
            version: 0,
            journal: None,
            unsaved: BTreeSet::new(),
            letters: Vec::new(),
            refused_ns: None,
            looked_ns: 0,
            trouble: None,
        }
    }

    /// Goes on from what the journal kept, and keeps everything in it from now on.
    pub fn keep_in(&mut self, journal: Journal, kept: Vec<Alert>) {
        for alert in kept {
            self.last_id = self.last_id.max(alert.id);
            if !alert.active {
                self.over.push_back(alert);
                continue;
            }
            for place in alert.places.iter().filter(|place| place.wagon <= self.wagons) {
                let Some(name) = rules::SYMPTOMS.iter().find(|name| **name == place.indicator) else {
                    continue;
                };
                let cause = Cause { wagon: place.wagon, wheelset: place.wheelset, name };
                let counts = Some((place.grade, place.reason.clone()));
                self.watched.insert(cause, Watched { counts, ..Watched::default() });
            }
            let wagon = (alert.scope == Scope::Wagon).then_some(alert.wagon);
            self.open.insert((alert.cause.clone(), wagon), alert);
        }
        self.over.make_contiguous().sort_by_key(|alert| std::cmp::Reverse(alert.unix_ns));
        self.journal = Some(journal);
        self.version += 1;
    }

    /// Takes in how a symptom is judged now. `Unknown` neither raises nor clears.
    pub fn judge(&mut self, cause: Cause, grade: Grade, reason: &str, now: Stamp) {
        let now_ns = now.monotonic_ns;
        let seconds = |since_ns: u64| now_ns.saturating_sub(since_ns) as f64 * 1e-9;
        let raise_s = self.settings.raise_after_s * rules::patience(cause.name, grade);
        let clear_s = self.clear_after_s(&cause);
        match grade {
            Grade::Unknown => {}
            Grade::Ok => {
                let Some(watched) = self.watched.get_mut(&cause) else { return };
                watched.bad_since_ns = None;
                let since_ns = *watched.good_since_ns.get_or_insert(now_ns);
                if watched.counts.is_none() || seconds(since_ns) >= clear_s {
                    self.watched.remove(&cause);
                }
            }
            Grade::Watch | Grade::Act => {
                let watched = self.watched.entry(cause).or_default();
                watched.good_since_ns = None;
                let since_ns = *watched.bad_since_ns.get_or_insert(now_ns);
                match &mut watched.counts {
                    None if seconds(since_ns) >= raise_s => {
                        watched.counts = Some((grade, reason.to_owned()));
                    }
                    None => {}
                    Some((counts, words)) if *counts == grade => {
                        watched.other_since_ns = None;
                        if words != reason {
                            reason.clone_into(words);
                        }
                    }
                    Some(counts) => {
                        let since_ns = *watched.other_since_ns.get_or_insert(now_ns);
                        let needed_s = if grade > counts.0 { raise_s } else { clear_s };
                        if seconds(since_ns) >= needed_s {
                            *counts = (grade, reason.to_owned());
                            watched.other_since_ns = None;
                        }
                    }
                }
            }
        }
    }

    /// What comes back again and again must stay away longer: twice as long each time.
    fn clear_after_s(&self, cause: &Cause) -> f64 {
        let name = rules::cause_of(cause.name);
        let alert =
            [Some(cause.wagon), None].into_iter().find_map(|wagon| self.open.get(&(name.to_owned(), wagon)));
        let times = alert.map_or(1, |alert| alert.times);
        self.settings.clear_after_s * f64::from(1u32 << (times - 1).min(MOST_PATIENCE))
    }

    /// Turns the symptoms that count into alerts; to be called after all were judged.
    pub fn settle(&mut self, now: Stamp) {
        let mut shown = self.grouped();
        let gone: Vec<Key> = self.open.keys().filter(|key| !shown.contains_key(*key)).cloned().collect();
        for key in gone {
            let into = shown.contains_key(&(key.0.clone(), None)) && key.1.is_some();
            self.end(&key, into, now);
        }
        let keys: Vec<Key> = shown.keys().cloned().collect();
        for key in keys {
            let places = shown.remove(&key).unwrap_or_default();
            if self.open.contains_key(&key) {
                self.renew(&key, places, now);
            } else {
                self.raise(key, places, now);
            }
        }
        self.find_recordings(now);
        self.unshelve_in_time(now);
        self.save(now);
    }

    /// Adds recordings to alerts that were raised before theirs was written.
    fn find_recordings(&mut self, now: Stamp) {
        if now.monotonic_ns.saturating_sub(self.looked_ns) < RECORDING_PAUSE_NS {
            return;
        }
        self.looked_ns = now.monotonic_ns;
        for alert in self.open.values_mut().filter(|alert| alert.evidence.recording.is_none()) {
            alert.find_recording(&self.gaps);
            if alert.evidence.recording.is_some() {
                self.version += 1;
                self.unsaved.insert(alert.id);
            }
        }
    }

    /// The symptoms that count by cause, and by wagon unless the cause is the train's.
    fn grouped(&self) -> BTreeMap<Key, Vec<AlertPlace>> {
        let mut by_cause: BTreeMap<&str, BTreeMap<u32, Vec<AlertPlace>>> = BTreeMap::new();
        for (cause, watched) in &self.watched {
            let Some((grade, reason)) = &watched.counts else { continue };
            by_cause.entry(rules::cause_of(cause.name)).or_default().entry(cause.wagon).or_default().push(
                AlertPlace {
                    wagon: cause.wagon,
                    wheelset: cause.wheelset,
                    indicator: cause.name.to_owned(),
                    grade: *grade,
                    reason: reason.clone(),
                },
            );
        }
        let acts = |name: &str, wagon: u32| {
            by_cause
                .get(name)
                .and_then(|wagons| wagons.get(&wagon))
                .is_some_and(|places| rules::grade(places) == Grade::Act)
        };
        let explained = |name: &str, wagon: u32| {
            ["isolated", "sensors"]
                .iter()
                .any(|other| rules::is_explained_by(name, other) && acts(other, wagon))
        };
        let mut shown = BTreeMap::new();
        for (name, wagons) in &by_cause {
            let left: BTreeMap<u32, Vec<AlertPlace>> = wagons
                .iter()
                .filter(|(wagon, _)| !explained(name, **wagon))
                .map(|(wagon, places)| (*wagon, places.clone()))
                .collect();
            let whole = (*name).to_owned();
            if !left.is_empty() && (rules::is_of_the_train(name) || self.is_common(name, left.len())) {
                shown.insert((whole, None), left.into_values().flatten().collect());
            } else {
                shown.extend(left.into_iter().map(|(wagon, places)| ((whole.clone(), Some(wagon)), places)));
            }
        }
        shown
    }

    /// True if so many wagons with one cause mean that it is the train's; once it is, it stays so until it is gone.
    fn is_common(&self, cause: &str, wagons: usize) -> bool {
        let share = self.settings.group_share * f64::from(self.wagons);
        let many = wagons as f64 >= share.max(f64::from(self.settings.group_least));
        many || self.open.contains_key(&(cause.to_owned(), None))
    }

    fn raise(&mut self, key: Key, places: Vec<AlertPlace>, now: Stamp) {
        let window_ns = (self.settings.reopen_within_s * 1e9) as i64;
        let scope = if key.1.is_some() { Scope::Wagon } else { Scope::Train };
        let same = |alert: &Alert| {
            alert.cause == key.0
                && alert.scope == scope
                && (scope == Scope::Train || key.1 == Some(alert.wagon))
                && (0..=window_ns).contains(&(now.unix_ns - alert.unix_ns))
                && alert.history.last().is_none_or(|line| line.change != Change::Merged)
        };
        let known = self.over.iter().position(same).and_then(|index| self.over.remove(index));
        let (mut alert, change) = match known {
            Some(mut alert) => {
                if alert.shelved.as_ref().is_some_and(|shelf| shelf.until_unix_ns <= now.unix_ns) {
                    alert.shelved = None;
                }
                alert.come_back(places, now);
                (alert, Change::Returned)
            }
            None => {
                self.last_id += 1;
                let mut alert = Alert::new(self.last_id, &key.0, scope, places, now);
                let said = alert.reason.clone();
                alert.note(Change::Raised, None, Some(said), now);
                (alert, Change::Raised)
            }
        };
        alert.find_recording(&self.gaps);
        self.tell(&alert, change, now);
        self.open.insert(key, alert);
    }

    fn renew(&mut self, key: &Key, places: Vec<AlertPlace>, now: Stamp) {
        let Some(alert) = self.open.get_mut(key) else { return };
        if alert.places == places {
            return;
        }
        let (worst, before, wagons) = (alert.grade, alert.grade_now, alert.wagons.len());
        alert.show(places);
        let change = if alert.grade_now > worst {
            alert.become_worse(now);
            Some(Change::Worse)
        } else if alert.wagons.len() > wagons {
            alert.note(Change::Spread, None, Some(alert.reason.clone()), now);
            Some(Change::Spread)
        } else if alert.grade_now < before {
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

    fn end(&mut self, key: &Key, merged: bool, now: Stamp) {
        let Some(mut alert) = self.open.remove(key) else { return };
        let change = if merged { Change::Merged } else { Change::Cleared };
        let note = merged.then(|| "part of an alert of the whole train now".to_owned());
        alert.end(change, note, now);
        self.tell(&alert, change, now);
        self.over.push_front(alert);
        if let Some(forgotten) = self.over.get(REMEMBERED) {
            self.unsaved.insert(forgotten.id);
        }
        self.over.truncate(REMEMBERED);
    }

    fn unshelve_in_time(&mut self, now: Stamp) {
        let due = |alert: &&mut Alert| {
            alert.shelved.as_ref().is_some_and(|shelf| shelf.until_unix_ns <= now.unix_ns)
        };
        let mut back = Vec::new();
        for alert in self.open.values_mut().filter(due) {
            alert.shelved = None;
            alert.note(Change::Unshelved, None, Some("its time is over".to_owned()), now);
            back.push(alert.clone());
        }
        back.iter().for_each(|alert| self.tell(alert, Change::Unshelved, now));
    }

    fn tell(&mut self, alert: &Alert, change: Change, now: Stamp) {
        self.version += 1;
        self.news.push(alert.clone());
        self.unsaved.insert(alert.id);
        if change.is_delivered() && alert.shelved.is_none() {
            self.letters.push(Letter { alert: alert.clone(), change, at_unix_ns: now.unix_ns });
        }
    }

    /// Writes what changed. While the disk refuses, everything live goes on and it is tried again.
    fn save(&mut self, now: Stamp) {
        let Some(journal) = &mut self.journal else {
            self.unsaved.clear();
            self.letters.clear();
            return;
        };
        if self.unsaved.is_empty() && self.letters.is_empty() {
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
        match journal.save(&kept, &gone, &self.letters) {
            Ok(()) => {
                self.unsaved.clear();
                self.letters.clear();
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
            AlertState::Shelved | AlertState::Cleared => 2,
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

    /// How many are active and not shelved.
    #[must_use]
    pub fn counts(&self) -> AlertCounts {
        let told = self.open.values().filter(|alert| alert.shelved.is_none());
        let of = |grade| told.clone().filter(|alert| alert.grade_now == grade).count() as u32;
        AlertCounts { watch: of(Grade::Watch), act: of(Grade::Act) }
    }
}

#[cfg(test)]
mod tests;
