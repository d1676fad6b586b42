//! Grouping: symptoms of one cause make one alert, of a wagon or of the whole train.

use super::evaluate::Firing;
use super::model::AlertPlace;
use super::place;
use super::rule::Rules;
use crate::api::grade::Grade;
use std::collections::BTreeMap;

/// A group: a cause, of one wagon or of the whole train.
pub(super) type Group = (String, Option<u32>);

/// By cause, then by wagon.
type Places<'a> = BTreeMap<&'a str, BTreeMap<u32, Vec<AlertPlace>>>;

/// Groups what fires. `is_common(cause, wagons)` says whether so many wagons mean that the cause is the train's, and
/// `home(rule, wagon)` under which wagon a symptom is listed: one fault may lie in several.
pub(super) fn group<'a>(
    rules: Rules,
    firing: impl Iterator<Item = Firing<'a>>,
    is_common: impl Fn(&str, usize) -> bool,
    home: impl Fn(&'static str, u32) -> u32,
) -> BTreeMap<Group, Vec<AlertPlace>> {
    let mut causes: Places<'_> = BTreeMap::new();
    for Firing { symptom, grade, reason, well_since } in firing {
        let wagons = causes.entry(rules.cause_of(symptom.rule)).or_default();
        wagons.entry(home(symptom.rule, symptom.wagon)).or_default().push(AlertPlace {
            wagon: symptom.wagon,
            vehicle_number: None,
            wheelset: symptom.wheelset,
            indicator: symptom.rule.to_owned(),
            grade,
            well_since,
            reason,
        });
    }
    let mut groups = BTreeMap::new();
    for (cause, wagons) in &causes {
        let left: BTreeMap<u32, Vec<AlertPlace>> = wagons
            .iter()
            .filter(|(wagon, _)| !is_inhibited(rules, &causes, cause, **wagon))
            .map(|(wagon, places)| (*wagon, places.clone()))
            .collect();
        let name = (*cause).to_owned();
        let common = || rules.judged(cause).is_none() && is_common(cause, left.len());
        if !left.is_empty() && (rules.is_of_the_train(cause) || common()) {
            groups.insert((name, None), left.into_values().flatten().collect());
        } else {
            groups.extend(left.into_iter().map(|(wagon, places)| ((name.clone(), Some(wagon)), places)));
        }
    }
    groups
}

/// True if a cause that explains this one, by its rule, needs action on the same wagon.
fn is_inhibited(rules: Rules, causes: &Places<'_>, cause: &str, wagon: u32) -> bool {
    let acts = |source: &str| {
        let places = causes.get(source).and_then(|wagons| wagons.get(&wagon));
        places.is_some_and(|places| place::grade(places) == Grade::Act)
    };
    // What is judged at a wagon, or of the rail, explains what that wagon shows of itself.
    let judged = |(source, wagons): (&&str, &BTreeMap<u32, Vec<AlertPlace>>)| {
        let here = |place: &AlertPlace| place.wagon == wagon || place.wagon == 0;
        rules.judged(source).is_some() && wagons.values().flatten().any(here)
    };
    rules.inhibited_by(cause).iter().any(|source| acts(source))
        || (rules.is_explained_by_the_judge(cause) && causes.iter().any(judged))
}
