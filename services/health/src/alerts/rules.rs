//! Which symptoms share a cause, what explains what, and what to do.

use super::model::{AlertPlace, Scope};
use crate::api::grade::Grade;

/// All symptoms: what a journal may hold.
pub(super) const SYMPTOMS: &[&str] = &[
    "asymmetry",
    "brake_friction",
    "brake_friction_standard",
    "capability",
    "dragging",
    "filter",
    "history",
    "isolated",
    "late",
    "model",
    "no_pressure",
    "rail",
    "response",
    "sanding",
    "sensors",
    "silent",
    "slides",
    "storage",
    "wsp_share",
];

/// The cause behind a symptom.
pub(super) fn cause_of(symptom: &'static str) -> &'static str {
    match symptom {
        "brake_friction" | "brake_friction_standard" | "asymmetry" => "brake_friction",
        "no_pressure" | "isolated" => "isolated",
        "late" | "response" => "response",
        // A disk that is full or read-only takes neither indicators nor alerts.
        "history" | "storage" => "storage",
        // What the filter shows within seconds, the watch over minutes shows with the term to suspect.
        "model" | "filter" => "filter",
        other => other,
    }
}

/// How much longer than others a symptom must last before it counts. A share of refused values and a filter that disagrees
/// come with every slide and go with it; a sensor that is dead does not.
pub(super) fn patience(symptom: &str, grade: Grade) -> f64 {
    match (symptom, grade) {
        ("filter", Grade::Watch) => 60.0,
        ("filter", _) | ("sensors", Grade::Watch) => 15.0,
        _ => 1.0,
    }
}

/// True for causes that lie in the rail, the data path or this service, never in one wagon.
pub(super) fn is_of_the_train(cause: &str) -> bool {
    matches!(cause, "rail" | "silent" | "storage" | "capability")
}

/// True if `cause` on a wagon follows from `other` on the same wagon, which needs action.
pub(super) fn is_explained_by(cause: &str, other: &str) -> bool {
    match other {
        "isolated" => matches!(cause, "brake_friction" | "response"),
        "sensors" => matches!(cause, "filter" | "brake_friction" | "slides" | "wsp_share" | "dragging"),
        _ => false,
    }
}

/// What to do about a cause.
pub(super) fn advice(cause: &str, scope: Scope) -> &'static str {
    match (cause, scope) {
        ("brake_friction", Scope::Train) => {
            "Most wagons at once: suspect water, ice or snow on the discs, or the loads that the train was given, before \
             any single pad. Brake early until it has gone."
        }
        ("brake_friction", _) => "Check pads, discs and rigging of this wagon: wear, glazing, water or oil.",
        ("isolated", _) => {
            "Check the isolating cock, the brake cylinder and the rigging here; count this brake as missing until then."
        }
        ("response", Scope::Train) => {
            "The whole train brakes late: check brake pipe, driver's valve and settings (G/P)."
        }
        ("response", _) => {
            "Check distributor, chokes and brake cylinder of this wagon, and its G/P changeover."
        }
        ("dragging", Scope::Train) => {
            "Most wagons run hard: suspect an applied brake, a wrong gradient or a headwind before any single wagon."
        }
        ("dragging", _) => "Look for a brake that does not release: hot discs, handbrake, release valve.",
        ("rail", _) => "Expect long braking distances here; sand or reduce speed, and tell those who follow.",
        ("sanding", _) => "Check sand level, nozzles and heating: sand does not raise adhesion.",
        ("slides", Scope::Train) => {
            "The train slid hard: inspect the treads of all listed wheelsets for flats."
        }
        ("slides", _) => "Listen for wheel flats and inspect the treads of this wagon.",
        ("wsp_share", _) => {
            "If other wagons do not slide here, check slide protection and pad friction of this wagon."
        }
        ("sensors", Scope::Train) => {
            "Many sensors at once: check what they share, supply and data bus, first."
        }
        ("sensors", _) => "Check the named sensors and their wiring on this wagon.",
        ("filter", Scope::Train) => {
            "The model explains no wagon: check vehicle file, loads and gradient of the train, then diagnose the gap."
        }
        ("filter", _) => {
            "The model does not explain this wagon: run `railgrip gap diagnose` on the recording that was kept."
        }
        ("silent", _) => "Check the data connection and the processes of these wagons.",
        ("storage", _) => {
            "Free space on the disk, make it writable or replace it; live figures go on, what is remembered has a gap."
        }
        ("capability", _) => "Reduce speed: the train needs more than its nominal braking distance.",
        (_, Scope::Train) => "Have a look at these wagons.",
        _ => "Have a look at this wagon.",
    }
}

/// The worst place; among equals the first.
pub(super) fn worst(places: &[AlertPlace]) -> Option<&AlertPlace> {
    places.iter().rev().max_by_key(|place| place.grade)
}

/// What happens, in words.
pub(super) fn reason(scope: Scope, places: &[AlertPlace]) -> String {
    let Some(worst) = worst(places) else { return String::new() };
    let wheelset = worst.wheelset.map_or_else(String::new, |number| format!("wheelset {number}: "));
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
