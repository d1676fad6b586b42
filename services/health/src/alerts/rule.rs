//! Alert rules: which there are, how long each must be broken, which cause it points to, and what to do about that.

use super::model::Scope;
use crate::api::grade::Grade;

/// All rules, by the names that a journal may hold.
pub(super) const RULES: &[&str] = &[
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

/// The cause that a rule points to: its symptoms make one alert.
pub(super) fn cause_of(rule: &'static str) -> &'static str {
    match rule {
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

/// How much longer than others a rule must be broken until its symptom fires. A share of refused values and a filter that disagrees
/// come with every slide and go with it; a sensor that is dead does not.
pub(super) fn patience(rule: &str, grade: Grade) -> f64 {
    match (rule, grade) {
        ("filter", Grade::Watch) => 60.0,
        ("filter", _) | ("sensors", Grade::Watch) => 15.0,
        _ => 1.0,
    }
}

/// True for causes that lie in the rail, the data path or this service, never in one wagon.
pub(super) fn is_of_the_train(cause: &str) -> bool {
    matches!(cause, "rail" | "silent" | "storage" | "capability")
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
