//! What happens to one alert, and its line in the history.

use super::model::{Alert, AlertEvent, AlertPlace, AlertState, Change, Evidence, Scope};
use super::recordings::Recordings;
use super::{diagnosis, place};
use crate::api::grade::Grade;
use crate::time::rfc3339;
use railgrip_messages::Stamp;
use std::path::{Path, PathBuf};

/// Lines that an alert's history keeps.
const LINES: usize = 50;
/// Evidence begins this time before the alert, s, and ends this time after it.
const EVIDENCE_S: i64 = 600;

impl Alert {
    /// A new alert.
    pub(super) fn new(
        id: u64,
        cause: &str,
        scope: Scope,
        advice: &str,
        places: Vec<AlertPlace>,
        now: Stamp,
    ) -> Self {
        let grade = place::grade(&places);
        let mut alert = Self {
            id,
            cause: cause.to_owned(),
            scope,
            wagon: 0,
            vehicle_number: None,
            wheelset: None,
            wheelsets: Vec::new(),
            wagons: Vec::new(),
            vehicle_numbers: Vec::new(),
            affected: Vec::new(),
            places: Vec::new(),
            grade,
            grade_now: grade,
            reason: String::new(),
            probability: None,
            instead: Vec::new(),
            brakings_seen: None,
            advice: advice.to_owned(),
            evidence: Evidence { history: String::new(), recording: None, diagnosis: None },
            active: true,
            state: AlertState::Active,
            acknowledged: None,
            silenced: None,
            times: 1,
            raised_at: rfc3339(now.unix_ns),
            cleared_at: None,
            history: Vec::new(),
            changes: 0,
            unix_ns: now.unix_ns,
        };
        alert.show(places);
        alert
    }

    /// Takes over where the cause shows now.
    pub(super) fn show(&mut self, places: Vec<AlertPlace>) {
        let worst = place::worst(&places);
        self.wagons = place::wagons(&places);
        self.affected.extend(&self.wagons);
        self.affected.sort_unstable();
        self.affected.dedup();
        self.wagon = self.wagons.first().copied().unwrap_or(0);
        let alone = |place: &&AlertPlace| self.scope == Scope::Wagon && place::pair(&places, place).is_none();
        self.wheelset = worst.filter(alone).and_then(|place| place.wheelset);
        self.grade_now = place::grade(&places);
        self.reason = place::reason(self.scope, &places);
        let wagon = worst.map_or(1, |place| place.wagon.max(1));
        self.places = places;
        let around_s = self.unix_ns.div_euclid(1_000_000_000);
        self.evidence.history = format!(
            "/api/v1/wagons/{wagon}/history?from={}&to={}",
            around_s - EVIDENCE_S,
            around_s + EVIDENCE_S
        );
    }

    /// What happens at one of its wagons, in words that need not name the wagon.
    pub(crate) fn reason_at(&self, wagon: u32) -> String {
        let there: Vec<AlertPlace> =
            self.places.iter().filter(|place| place.wagon == wagon).cloned().collect();
        place::reason(Scope::Wagon, &there)
    }

    /// Names the latest recording that was kept of its wagon.
    pub(super) fn find_recording(&mut self, recordings: &Recordings) {
        if let Some(path) = recordings.of(self).first() {
            self.evidence.recording = Some(path.display().to_string());
        }
    }

    /// Joins what the diagnosis of the latest recording that has one found; what is known of an older one stays until then.
    /// True if there is news.
    pub(super) fn find_diagnosis(&mut self, recordings: &Recordings) -> bool {
        let named = self.evidence.recording.as_ref().map(PathBuf::from);
        let mut all = recordings.of(self).into_iter().chain(named);
        let Some(answered) = all.find(|path| path.join(diagnosis::ANSWER).exists()) else {
            return false;
        };
        let known =
            self.evidence.diagnosis.as_ref().is_some_and(|known| Path::new(&known.recording) == answered);
        let found = if known { None } else { diagnosis::read(&answered) };
        let news = found.is_some();
        self.evidence.diagnosis = found.or(self.evidence.diagnosis.take());
        news
    }

    /// Writes a line of history and renews the state.
    pub(super) fn note(&mut self, change: Change, by: Option<&str>, note: Option<String>, now: Stamp) {
        self.changes += 1;
        if self.history.len() >= LINES {
            self.history.remove(1);
        }
        let grade = if change == Change::Cleared { Grade::Ok } else { self.grade_now };
        self.history.push(AlertEvent {
            at: rfc3339(now.unix_ns),
            change,
            grade,
            by: by.map(str::to_owned),
            note,
        });
        self.state = match (self.active, &self.silenced, &self.acknowledged) {
            (false, _, _) => AlertState::Cleared,
            (true, Some(_), _) => AlertState::Silenced,
            (true, None, Some(_)) => AlertState::Acknowledged,
            (true, None, None) => AlertState::Active,
        };
    }

    /// The cause is gone, or became part of another alert.
    pub(super) fn end(&mut self, change: Change, note: Option<String>, now: Stamp) {
        self.active = false;
        self.grade_now = Grade::Ok;
        // A cause goes from one wagon after the other; the last one alone would tell the wrong story afterwards.
        if !self.affected.is_empty() {
            self.wagons.clone_from(&self.affected);
        }
        self.cleared_at = Some(rfc3339(now.unix_ns));
        self.unix_ns = now.unix_ns;
        self.note(change, None, note, now);
    }

    /// The cause is back.
    pub(super) fn come_back(&mut self, places: Vec<AlertPlace>, now: Stamp) {
        self.active = true;
        self.cleared_at = None;
        self.acknowledged = None;
        self.times += 1;
        self.unix_ns = now.unix_ns;
        self.affected.clear();
        self.show(places);
        self.grade = self.grade.max(self.grade_now);
        self.note(Change::Returned, None, None, now);
    }

    /// It became worse: whoever put it aside or took notice did so for something lesser.
    pub(super) fn become_worse(&mut self, now: Stamp) {
        self.grade = self.grade_now;
        self.acknowledged = None;
        self.silenced = None;
        self.note(Change::Worse, None, Some(self.reason.clone()), now);
    }
}
