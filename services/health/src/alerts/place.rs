//! The places of an alert: the worst of them, which wagons, and all of it in words.

use super::model::{AlertPlace, Scope};
use crate::api::grade::Grade;

/// The worst place; among equals one that names its wheelset, as that says where to look, then the first.
pub(super) fn worst(places: &[AlertPlace]) -> Option<&AlertPlace> {
    places.iter().rev().max_by_key(|place| (place.grade, place.wheelset.is_some()))
}

/// What happens, in words.
pub(super) fn reason(scope: Scope, places: &[AlertPlace]) -> String {
    let Some(worst) = worst(places) else { return String::new() };
    let wheelset = match pair(places, worst) {
        Some([first, second]) => format!("wheelsets {first}, {second}: "),
        None => worst.wheelset.map_or_else(String::new, |number| format!("wheelset {number}: ")),
    };
    match (scope, worst.wagon) {
        (Scope::Wagon, _) | (_, 0) => format!("{wheelset}{}", worst.reason),
        (Scope::Train, wagon) => {
            let wagons = wagons(places);
            let (noun, list) = (if wagons.len() == 1 { "wagon" } else { "wagons" }, spans(&wagons));
            if wagons.len() == 1 {
                return format!("{noun} {list}: {wheelset}{}", worst.reason);
            }
            format!("{} {noun} ({list}), worst wagon {wagon}: {wheelset}{}", wagons.len(), worst.reason)
        }
    }
}

/// Two wheelsets of a wagon that show the same.
pub(super) fn pair(places: &[AlertPlace], worst: &AlertPlace) -> Option<[u32; 2]> {
    let same = |place: &&AlertPlace| place.wagon == worst.wagon && place.reason == worst.reason;
    let numbers: Vec<u32> = places.iter().filter(same).filter_map(|place| place.wheelset).collect();
    <[u32; 2]>::try_from(numbers).ok()
}

/// The wagons of some places, front first, each once; places that are no wagon's do not count.
pub(super) fn wagons(places: &[AlertPlace]) -> Vec<u32> {
    let mut wagons: Vec<u32> = places.iter().map(|place| place.wagon).filter(|wagon| *wagon > 0).collect();
    wagons.sort_unstable();
    wagons.dedup();
    wagons
}

/// `1-4, 6`.
fn spans(wagons: &[u32]) -> String {
    let mut spans: Vec<(u32, u32)> = Vec::new();
    for wagon in wagons {
        match spans.last_mut() {
            Some((_, last)) if *last + 1 == *wagon => *last = *wagon,
            _ => spans.push((*wagon, *wagon)),
        }
    }
    let words = |(first, last): &(u32, u32)| {
        if first == last { first.to_string() } else { format!("{first}-{last}") }
    };
    spans.iter().map(words).collect::<Vec<_>>().join(", ")
}

/// What is well again needs no action any more; until it has been so for long enough it is worth a look.
pub(super) fn ease(place: &mut AlertPlace) {
    if place.well_since.is_some() {
        place.grade = place.grade.min(Grade::Watch);
    }
}

/// How bad it is now.
pub(super) fn grade(places: &[AlertPlace]) -> Grade {
    worst(places).map_or(Grade::Ok, |place| place.grade)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wagons_are_listed_as_spans() {
        assert_eq!(spans(&[1, 2, 3, 4, 6, 8, 9]), "1-4, 6, 8-9");
        assert_eq!(spans(&[5]), "5");
    }
}
