//! The library of tests from which a run is chosen.

use crate::data::case::Case;
use railgrip_vehicle::RailClass;
use serde::Serialize;

/// Within what a run may be planned.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// Highest speed, m/s; `None`: the highest of the recordings.
    pub v_max_m_s: Option<f64>,
    /// Rail on which may be run; empty: on what the recordings were made.
    pub rails: Vec<RailClass>,
    /// Length of the run, s.
    pub length_s: f64,
}

/// A stretch of the run; it lasts until the next begins.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Phase {
    /// End, s.
    pub until_s: f64,
    /// Share of full service braking, 0 to 1.
    pub brake_demand: f64,
    /// Share of full traction, 0 to 1.
    pub drive_demand: f64,
}

/// A run to be made.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlannedRun {
    /// Speed at its start, m/s.
    pub v0_m_s: f64,
    /// Rail: `dry`, `wet` or `low`.
    pub rail: String,
    /// What is asked of brake and motor.
    pub phases: Vec<Phase>,
    #[serde(skip)]
    pub(super) class: RailClass,
}

/// Shares of the highest speed from which is started.
const STARTS: [f64; 3] = [1.0, 0.7, 0.4];

/// Patterns: shares of the length, of full braking and of full traction.
const PATTERNS: [&[(f64, f64, f64)]; 7] = [
    // Coasting.
    &[(1.0, 0.0, 0.0)],
    // One full stop, one of a third.
    &[(0.1, 0.0, 0.0), (1.0, 1.0, 0.0)],
    &[(0.1, 0.0, 0.0), (1.0, 0.33, 0.0)],
    // Steps of pressure.
    &[(0.1, 0.0, 0.0), (0.3, 0.15, 0.0), (0.5, 0.4, 0.0), (0.7, 0.8, 0.0), (1.0, 0.2, 0.0)],
    // On and off, quickly.
    &[
        (0.1, 0.0, 0.0),
        (0.25, 0.6, 0.0),
        (0.4, 0.0, 0.0),
        (0.55, 0.6, 0.0),
        (0.7, 0.0, 0.0),
        (0.85, 0.6, 0.0),
        (1.0, 0.0, 0.0),
    ],
    // Traction, coasting, a gentle brake.
    &[(0.3, 0.0, 0.7), (0.6, 0.0, 0.0), (0.8, 0.3, 0.0), (1.0, 0.0, 0.0)],
    // Two stops in quick succession, with what traction gives between.
    &[(0.05, 0.0, 0.0), (0.35, 0.8, 0.0), (0.65, 0.0, 1.0), (1.0, 0.8, 0.0)],
];

/// All tests within the limits.
pub(super) fn library(case: &Case, limits: &Limits) -> Vec<PlannedRun> {
    let speeds = case.fit.iter().flat_map(|run| run.samples.iter().map(|sample| sample.outputs[0]));
    let v_max = limits.v_max_m_s.unwrap_or_else(|| speeds.fold(5.0, f64::max));
    let recorded = |class: &RailClass| case.fit.iter().any(|run| run.rail == *class);
    let rails: Vec<RailClass> = match limits.rails.as_slice() {
        [] => RailClass::ALL.into_iter().filter(recorded).collect(),
        some => some.to_vec(),
    };
    let rails = if rails.is_empty() { vec![RailClass::Dry] } else { rails };
    let motors = is_driven(case);
    let possible = |pattern: &&[(f64, f64, f64)]| motors || pattern.iter().all(|phase| phase.2 == 0.0);
    let mut tests = Vec::new();
    for class in rails {
        for start in STARTS {
            for pattern in PATTERNS.into_iter().filter(possible) {
                let phase = |&(until, brake_demand, drive_demand): &(f64, f64, f64)| Phase {
                    until_s: until * limits.length_s,
                    brake_demand,
                    drive_demand,
                };
                tests.push(PlannedRun {
                    v0_m_s: (start * v_max * 2.0).round() / 2.0,
                    rail: class.name().to_owned(),
                    phases: pattern.iter().map(phase).collect(),
                    class,
                });
            }
        }
    }
    tests
}

/// Whether motors worked in the recordings.
pub(super) fn is_driven(case: &Case) -> bool {
    let driven = |torque: &f64| torque.abs() > 1.0;
    case.fit.iter().flat_map(|run| &run.samples).any(|s| s.input.mid_drive_torque_nm.iter().any(driven))
}
