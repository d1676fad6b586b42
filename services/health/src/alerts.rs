//! Alerts that people do not learn to ignore: one a cause, raised only when the cause lasts, cleared only when it stays away.

use crate::model::{Alert, AlertCounts, Grade};
use crate::time::rfc3339;
use railgrip_messages::Stamp;
use railgrip_settings::AlertSettings;
use std::collections::{BTreeMap, VecDeque};

/// Alerts that are over and still listed.
const REMEMBERED: usize = 200;

/// What an alert is about.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Cause {
    /// The wagon.
    pub wagon: u32,
    /// The wheelset, 1 leading.
    pub wheelset: Option<u32>,
    /// The indicator, or `silent`.
    pub name: &'static str,
}

/// All alerts, with the state of what may become one.
#[derive(Debug)]
pub struct AlertBook {
    settings: AlertSettings,
    watched: BTreeMap<Cause, Watched>,
    over: VecDeque<Alert>,
    count: u64,
}

#[derive(Debug, Default)]
struct Watched {
    bad_since_ns: Option<u64>,
    good_since_ns: Option<u64>,
    alert: Option<Alert>,
}

impl AlertBook {
    /// No alert yet.
    #[must_use]
    pub fn new(settings: AlertSettings) -> Self {
        Self { settings, watched: BTreeMap::new(), over: VecDeque::new(), count: 0 }
    }

    /// Takes in how a cause is judged now. `Unknown` neither raises nor clears. Gives the alert if it was raised, cleared or
    /// became worse.
    pub fn judge(&mut self, cause: Cause, grade: Grade, reason: &str, now: Stamp) -> Option<Alert> {
        let settings = self.settings;
        match grade {
            Grade::Unknown => None,
            Grade::Ok => {
                let watched = self.watched.get_mut(&cause)?;
                watched.bad_since_ns = None;
                let since_ns = *watched.good_since_ns.get_or_insert(now.monotonic_ns);
                let good_s = now.monotonic_ns.saturating_sub(since_ns) as f64 * 1e-9;
                (good_s >= settings.clear_after_s).then(|| self.clear(&cause, now)).flatten()
            }
            Grade::Watch | Grade::Act => {
                let watched = self.watched.entry(cause.clone()).or_default();
                watched.good_since_ns = None;
                let since_ns = *watched.bad_since_ns.get_or_insert(now.monotonic_ns);
                let bad_s = now.monotonic_ns.saturating_sub(since_ns) as f64 * 1e-9;
                match &mut watched.alert {
                    Some(alert) if grade > alert.grade => {
                        (alert.grade, alert.reason) = (grade, reason.to_owned());
                        Some(alert.clone())
                    }
                    Some(_) => None,
                    None if bad_s < settings.raise_after_s => None,
                    None => {
                        self.count += 1;
                        let alert = raised(self.count, &cause, grade, reason, now);
                        watched.alert = Some(alert.clone());
                        Some(alert)
                    }
                }
            }
        }
    }

    fn clear(&mut self, cause: &Cause, now: Stamp) -> Option<Alert> {
        let mut alert = self.watched.remove(cause)?.alert?;
        alert.active = false;
        alert.cleared_at = Some(rfc3339(now.unix_ns));
        self.over.push_front(alert.clone());
        self.over.truncate(REMEMBERED);
        Some(alert)
    }

    /// Active alerts, worst and latest first, then those that are over.
    #[must_use]
    pub fn list(&self) -> Vec<Alert> {
        let mut active: Vec<Alert> = self.active().cloned().collect();
        active.sort_by_key(|alert| (std::cmp::Reverse(alert.grade), std::cmp::Reverse(alert.id)));
        active.extend(self.over.iter().cloned());
        active
    }

    /// How many are active.
    #[must_use]
    pub fn counts(&self) -> AlertCounts {
        let of = |grade| self.active().filter(|alert| alert.grade == grade).count() as u32;
        AlertCounts { watch: of(Grade::Watch), act: of(Grade::Act) }
    }

    fn active(&self) -> impl Iterator<Item = &Alert> {
        self.watched.values().filter_map(|watched| watched.alert.as_ref())
    }
}

fn raised(id: u64, cause: &Cause, grade: Grade, reason: &str, now: Stamp) -> Alert {
    Alert {
        id,
        cause: cause.name.to_owned(),
        wagon: cause.wagon,
        wheelset: cause.wheelset,
        grade,
        reason: reason.to_owned(),
        advice: advice(cause.name).to_owned(),
        active: true,
        raised_at: rfc3339(now.unix_ns),
        cleared_at: None,
    }
}

/// What to do about a cause.
fn advice(cause: &str) -> &'static str {
    match cause {
        "brake_friction" => "Check pads, discs and rigging of this wagon: wear, glazing, water or oil.",
        "asymmetry" => "Compare pads and rigging of the front and the rear wheelset.",
        "rail" => "Expect long braking distances here; sand or reduce speed, and tell those who follow.",
        "slides" => "Listen for wheel flats and inspect the treads of this wheelset.",
        "wsp_share" => {
            "If other wagons do not slide here, check slide protection and pad friction of this wagon."
        }
        "sensors" => "Check speed sensors, pressure sensors and their wiring on this wagon.",
        "filter" => "The model does not explain this wagon: record it and diagnose the gap.",
        "silent" => "Check the data connection and the processes of this wagon.",
        _ => "Have a look at this wagon.",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTINGS: AlertSettings = AlertSettings { raise_after_s: 2.0, clear_after_s: 10.0 };

    fn at(seconds: f64) -> Stamp {
        let ns = (seconds * 1e9) as u64;
        Stamp { unix_ns: ns as i64, monotonic_ns: ns }
    }

    fn cause() -> Cause {
        Cause { wagon: 3, wheelset: Some(2), name: "brake_friction" }
    }

    /// Judges once every half second; gives the times at which something was told.
    fn play(book: &mut AlertBook, from_s: f64, until_s: f64, grade: Grade) -> Vec<(f64, Grade, bool)> {
        let steps = ((until_s - from_s) / 0.5) as usize;
        (0..steps)
            .filter_map(|step| {
                let now_s = from_s + 0.5 * step as f64;
                let alert = book.judge(cause(), grade, "low", at(now_s))?;
                Some((now_s, alert.grade, alert.active))
            })
            .collect()
    }

    #[test]
    fn an_alert_is_raised_when_its_cause_lasts_and_cleared_when_it_stays_away() {
        let mut book = AlertBook::new(SETTINGS);
        assert_eq!(play(&mut book, 0.0, 1.5, Grade::Watch), []);
        assert_eq!(play(&mut book, 1.5, 2.0, Grade::Ok), [], "a short cause is forgotten");
        assert_eq!(play(&mut book, 2.0, 8.0, Grade::Watch), [(4.0, Grade::Watch, true)]);
        assert_eq!(play(&mut book, 8.0, 17.0, Grade::Ok), []);
        assert_eq!(play(&mut book, 17.0, 18.0, Grade::Watch), [], "it is the same alert");
        assert_eq!(play(&mut book, 18.0, 29.0, Grade::Ok), [(28.0, Grade::Watch, false)]);
        let list = book.list();
        assert_eq!((list.len(), list[0].active, list[0].id), (1, false, 1));
        assert_eq!(book.counts(), AlertCounts::default());
    }

    #[test]
    fn worse_is_told_once_and_unknown_changes_nothing() {
        let mut book = AlertBook::new(SETTINGS);
        play(&mut book, 0.0, 4.0, Grade::Watch);
        assert_eq!(play(&mut book, 4.0, 8.0, Grade::Act), [(4.0, Grade::Act, true)]);
        assert_eq!(play(&mut book, 8.0, 60.0, Grade::Unknown), []);
        assert_eq!(book.counts(), AlertCounts { watch: 0, act: 1 });
        assert_eq!(book.list()[0].wheelset, Some(2));
        assert!(book.list()[0].advice.contains("pads"));
    }

    #[test]
    fn the_list_of_the_past_is_bounded() {
        let mut book = AlertBook::new(AlertSettings { raise_after_s: 0.0, clear_after_s: 0.0 });
        for second in 0..500 {
            let now = at(f64::from(second));
            book.judge(cause(), Grade::Act, "low", now);
            book.judge(cause(), Grade::Ok, "fine", now);
        }
        assert_eq!((book.list().len(), book.list()[0].id), (REMEMBERED, 500));
    }
}
