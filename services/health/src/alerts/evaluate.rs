//! Rules, evaluated: which symptoms fire. A symptom fires when its rule has been broken for long enough, and stops when
//! it has been kept for long enough.

use crate::api::grade::Grade;
use crate::time::rfc3339;
use railgrip_messages::Stamp;
use std::collections::BTreeMap;

/// A symptom: a rule broken at one place. Wagon 0 is the train itself, or this service.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Symptom {
    /// The wagon.
    pub wagon: u32,
    /// The wheelset, 1 leading.
    pub wheelset: Option<u32>,
    /// Name of the rule: an indicator, or `silent`, `storage`, `history`.
    pub rule: &'static str,
}

/// Between what is seen now and what was seen before.
const BEFORE: &str = "; before: ";

/// How long a symptom must last until it counts, and be gone until it does not, s.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patience {
    pub raise_s: f64,
    pub clear_s: f64,
}

/// A symptom that fires.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Firing<'a> {
    pub symptom: &'a Symptom,
    /// How bad it was when it was last seen.
    pub grade: Grade,
    /// Why, in words; of one that is not seen any more also since when.
    pub reason: String,
    /// Since when it is well, RFC 3339, if it is.
    pub well_since: Option<String>,
}

/// What is seen in place of a symptom that fires.
const WELL: &str = "well since";
const UNKNOWN: &str = "unknown since";

/// A symptom while it is watched.
#[derive(Debug, Default)]
struct Watched {
    bad_since_ns: Option<u64>,
    good_since_ns: Option<u64>,
    /// Since when it is worse than what counts, or less bad.
    other_since_ns: Option<u64>,
    fires: Option<(Grade, String)>,
    /// While it fires and is not seen any more: since when, in words.
    past: Option<String>,
}

/// All symptoms that fire, or may soon.
#[derive(Debug, Default)]
pub(super) struct Evaluation {
    watched: BTreeMap<Symptom, Watched>,
}

impl Evaluation {
    /// Goes on from a symptom that fired before a restart.
    pub fn restore(&mut self, symptom: Symptom, grade: Grade, reason: String) {
        let reason = reason.split_once(BEFORE).map_or(reason.as_str(), |(_, before)| before).to_owned();
        self.watched.insert(symptom, Watched { fires: Some((grade, reason)), ..Watched::default() });
    }

    /// Takes in how a symptom is judged now. `Unknown` neither raises nor clears.
    pub fn judge(&mut self, symptom: Symptom, grade: Grade, reason: &str, patience: Patience, now: Stamp) {
        match grade {
            Grade::Unknown => {
                if let Some(watched) = self.watched.get_mut(&symptom) {
                    watched.is_past(UNKNOWN, now);
                }
            }
            Grade::Ok => self.good(&symptom, patience, now),
            Grade::Watch | Grade::Act => {
                let watched = self.watched.entry(symptom).or_default();
                watched.past = None;
                watched.bad(grade, reason, patience, now.monotonic_ns);
            }
        }
    }

    fn good(&mut self, symptom: &Symptom, patience: Patience, now: Stamp) {
        let Some(watched) = self.watched.get_mut(symptom) else { return };
        watched.bad_since_ns = None;
        watched.is_past(WELL, now);
        let since_ns = *watched.good_since_ns.get_or_insert(now.monotonic_ns);
        if watched.fires.is_none() || seconds(since_ns, now.monotonic_ns) >= patience.clear_s {
            self.watched.remove(symptom);
        }
    }

    /// The symptoms under watch whose rules are chosen.
    pub fn of_rules(&self, chosen: impl Fn(&str) -> bool) -> Vec<Symptom> {
        self.watched.keys().filter(|symptom| chosen(symptom.rule)).cloned().collect()
    }

    /// The symptoms that fire, with how bad they are and why. What lasts only because it is not yet gone for long enough says
    /// since when: it must not contradict what is seen now.
    pub fn firing(&self) -> impl Iterator<Item = Firing<'_>> {
        self.watched.iter().filter_map(|(symptom, watched)| {
            let (grade, reason) = watched.fires.as_ref()?;
            let reason = match &watched.past {
                Some(since) => format!("{since}{BEFORE}{reason}"),
                None => reason.clone(),
            };
            let well = watched.past.as_deref().and_then(|past| past.strip_prefix(WELL));
            let well_since = well.map(|since| since.trim().to_owned());
            Some(Firing { symptom, grade: *grade, reason, well_since })
        })
    }
}

impl Watched {
    /// What fires is not seen any more; what is seen instead, from now on.
    fn is_past(&mut self, since: &str, now: Stamp) {
        let goes_on = self.past.as_deref().is_some_and(|past| past.starts_with(since));
        if self.fires.is_some() && !goes_on {
            self.past = Some(format!("{since} {}", rfc3339(now.unix_ns)));
        }
    }

    fn bad(&mut self, grade: Grade, reason: &str, patience: Patience, now_ns: u64) {
        self.good_since_ns = None;
        let since_ns = *self.bad_since_ns.get_or_insert(now_ns);
        match &mut self.fires {
            None if seconds(since_ns, now_ns) >= patience.raise_s => {
                self.fires = Some((grade, reason.to_owned()));
            }
            None => {}
            Some((fires, words)) if *fires == grade => {
                self.other_since_ns = None;
                if words != reason {
                    reason.clone_into(words);
                }
            }
            Some(fires) => {
                let since_ns = *self.other_since_ns.get_or_insert(now_ns);
                let needed_s = if grade > fires.0 { patience.raise_s } else { patience.clear_s };
                if seconds(since_ns, now_ns) >= needed_s {
                    *fires = (grade, reason.to_owned());
                    self.other_since_ns = None;
                }
            }
        }
    }
}

fn seconds(since_ns: u64, now_ns: u64) -> f64 {
    now_ns.saturating_sub(since_ns) as f64 * 1e-9
}
