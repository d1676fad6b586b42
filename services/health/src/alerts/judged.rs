//! Verdicts about a train whose wagons are judged together, as symptoms: which places each cause has, under which wagon it is
//! listed, and what else is known of it.

use super::evaluate::Symptom;
use super::model::{Alert, Instead};
use crate::api::grade::Grade;
use railgrip_causes::Cause;
use railgrip_messages::{Verdict, Verdicts};
use std::collections::{BTreeMap, BTreeSet};

/// A judge that has begun anew says nothing of what was found before until it has seen so many brake applications.
const KNOWS_AFTER: u32 = 5;

/// What was judged last.
#[derive(Debug, Default)]
pub(super) struct Judged {
    /// By cause and wagon: the first wagon of the fault.
    homes: BTreeMap<(&'static str, u32), u32>,
    /// By cause and first wagon.
    verdicts: BTreeMap<(&'static str, u32), Verdict>,
    /// What this run of the judge has told.
    told: BTreeSet<Symptom>,
    instants: u64,
}

impl Judged {
    /// Each place of each verdict with its grade and reason, and each place of `before` that none names any more: as one that
    /// is well, or unknown while the judge has not seen enough.
    pub fn take(&mut self, verdicts: &Verdicts, before: &[Symptom]) -> Vec<(Symptom, Grade, String)> {
        if verdicts.instants < self.instants {
            self.told.clear();
        }
        self.instants = verdicts.instants;
        let mut named = Vec::new();
        for verdict in verdicts.standing() {
            let Some(cause) = Cause::from_code(verdict.cause) else { continue };
            let rule = cause.word();
            let grade: Grade =
                railgrip_messages::Grade::from_code(verdict.grade).map_or(Grade::Unknown, Into::into);
            let home = verdict.wagons().next().unwrap_or(0);
            self.verdicts.insert((rule, home), *verdict);
            let wagons: Vec<u32> = if home == 0 { vec![0] } else { verdict.wagons().collect() };
            for wagon in wagons {
                self.homes.insert((rule, wagon), home);
                for wheelset in wheelsets(verdict) {
                    let symptom = Symptom { wagon, wheelset, rule };
                    self.told.insert(symptom.clone());
                    named.push((symptom, grade, verdict.reason.as_str().to_owned()));
                }
            }
        }
        let gone = before.iter().filter(|symptom| named.iter().all(|(other, ..)| other != *symptom));
        let gone: Vec<_> = gone
            .map(|symptom| {
                let knows = verdicts.brakings >= KNOWS_AFTER || self.told.contains(symptom);
                let grade = if knows { Grade::Ok } else { Grade::Unknown };
                (symptom.clone(), grade, String::new())
            })
            .collect();
        named.extend(gone);
        named
    }

    /// Under which wagon a symptom is listed.
    pub fn home(&self, rule: &'static str, wagon: u32) -> u32 {
        self.homes.get(&(rule, wagon)).copied().unwrap_or(wagon)
    }

    /// Goes on from a place of an alert that was listed under `home` before a restart.
    pub fn restore(&mut self, rule: &'static str, wagon: u32, home: u32) {
        self.homes.insert((rule, wagon), home);
    }

    /// Adds to an alert what its verdict says besides.
    pub fn explain(&self, cause: &str, home: u32, alert: &mut Alert) {
        let Some(cause) = Cause::from_word(cause) else { return };
        let Some(verdict) = self.verdicts.get(&(cause.word(), home)) else { return };
        alert.probability = Some(verdict.probability);
        alert.brakings_seen = Some(verdict.brakings_seen);
        alert.wheelsets = (1..=32).filter(|number| verdict.wheelsets >> (number - 1) & 1 == 1).collect();
        let runners = verdict.instead.iter().zip(verdict.instead_probability);
        let runner = |(code, probability): (&u32, f64)| {
            Some(Instead { cause: Cause::from_code(*code)?.word().to_owned(), probability })
        };
        alert.instead = runners.filter_map(runner).collect();
    }
}

/// The wheelset, 1 leading, where one is told; else the wagon as a whole.
fn wheelsets(verdict: &Verdict) -> Vec<Option<u32>> {
    let bits = verdict.wheelsets;
    let told: Vec<Option<u32>> = (0..32).filter(|k| bits >> k & 1 == 1).map(|k| Some(k + 1)).collect();
    // Two may be a pair that cannot be told apart; more are the wagon.
    if (1..=2).contains(&told.len()) { told } else { vec![None] }
}
