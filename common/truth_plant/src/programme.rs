//! The programme of one case: seven runs to fit on, three to predict, and who drives them.

use std::f64::consts::TAU;

use crate::{
    random::Stream,
    sheet::{Rail, Sheet},
};

/// A run as it is ordered, before the wagon runs it.
#[derive(Debug, Clone)]
pub struct Order {
    /// Name without rail class.
    pub name: &'static str,
    /// Rail class.
    pub rail: Rail,
    /// Whether the run may only be predicted.
    pub holdout: bool,
    /// Speed at the start, m/s.
    pub start_m_s: f64,
    /// From when on (s) which share of full pressing force is demanded.
    pub demand: Vec<(f64, f64)>,
    /// Traction torque of one wheelset (N m) and when it acts (s).
    pub traction: Option<(f64, f64, f64)>,
    /// The line.
    pub line: Line,
}

/// Longest run, s.
pub const LONGEST_S: f64 = 75.0;
/// A run ends below this speed, m/s.
pub const END_SPEED_M_S: f64 = 2.0;

/// The height profile of a line: a mean slope and two waves.
#[derive(Debug, Clone, Copy)]
pub struct Line {
    mean_rad: f64,
    waves: [(f64, f64, f64); 2],
}

impl Line {
    fn draw(stream: &mut Stream) -> Self {
        let mut wave = |amplitude_rad: f64, low_m: f64, high_m: f64| {
            (amplitude_rad, TAU / stream.uniform(low_m, high_m), stream.uniform(0.0, TAU))
        };
        let waves = [wave(0.0017, 450.0, 1100.0), wave(0.0004, 180.0, 320.0)];
        Self { mean_rad: stream.uniform(-0.004, 0.004), waves }
    }

    /// Slope at a place, rad.
    #[must_use]
    pub fn grade_rad(&self, position_m: f64) -> f64 {
        let waves = self
            .waves
            .iter()
            .map(|(amplitude, number, phase)| amplitude * (number * position_m + phase).sin());
        self.mean_rad + waves.sum::<f64>()
    }
}

impl Order {
    /// Demanded share of full pressing force at a time.
    #[must_use]
    pub fn demand(&self, time_s: f64) -> f64 {
        self.demand.iter().take_while(|(from_s, _)| *from_s <= time_s).last().map_or(0.0, |(_, share)| *share)
    }

    /// Traction torque of one wheelset at a time, N m.
    #[must_use]
    pub fn traction_nm(&self, time_s: f64) -> f64 {
        match self.traction {
            Some((torque_nm, from_s, to_s)) if (from_s..to_s).contains(&time_s) => torque_nm,
            _ => 0.0,
        }
    }
}

/// The ten runs of a case.
#[must_use]
pub fn orders(sheet: &Sheet, seed: u64) -> Vec<Order> {
    let plan: [(&'static str, Rail, bool); 10] = [
        ("dry_steps", Rail::Dry, false),
        ("dry_stop", Rail::Dry, false),
        ("low_hold", Rail::Low, false),
        ("low_stop", Rail::Low, false),
        ("mixed", Rail::Dry, false),
        ("wet_steps", Rail::Wet, false),
        ("wet_stop", Rail::Wet, false),
        ("dry_partial", Rail::Dry, true),
        ("low_partial", Rail::Low, true),
        ("wet_stop", Rail::Wet, true),
    ];
    let draw = |(index, (name, rail, holdout))| {
        let mut stream = Stream::new(seed, "order", index as u64);
        order(name, rail, holdout, sheet, &mut stream)
    };
    plan.into_iter().enumerate().map(draw).collect()
}

fn order(name: &'static str, rail: Rail, holdout: bool, sheet: &Sheet, stream: &mut Stream) -> Order {
    let top = sheet.top_speed_m_s;
    let start_m_s = match (name, rail) {
        ("mixed", _) if sheet.traction_nm > 0.0 => stream.uniform(4.0, 8.0),
        (_, Rail::Dry) => top * stream.uniform(0.8, 1.0),
        ("wet_steps", _) => stream.uniform(0.7, 0.95) * top.min(32.0),
        (_, Rail::Wet) => stream.uniform(0.75, 1.0) * top.min(33.0),
        (_, Rail::Low) => stream.uniform(16.0, 24.0),
    };
    let onset_s = stream.uniform(3.0, 6.0);
    let constant = |share: f64| vec![(onset_s, share)];
    let demand = match name {
        "dry_steps" => steps(stream, 0.3, 0.95),
        "wet_steps" => steps(stream, 0.22, 0.95),
        "low_hold" => constant(stream.uniform(0.52, 0.75)),
        "low_stop" => constant(stream.uniform(0.72, 1.0)),
        "dry_partial" => constant(stream.uniform(0.5, 0.7)),
        "low_partial" => constant(stream.uniform(0.5, 0.75)),
        "mixed" => vec![(if sheet.traction_nm > 0.0 { 32.0 } else { 30.0 }, stream.uniform(0.8, 0.92))],
        _ => constant(1.0),
    };
    let traction = (name == "mixed" && sheet.traction_nm > 0.0)
        .then(|| (sheet.traction_nm, 3.0, stream.uniform(17.0, 21.0)));
    Order { name, rail, holdout, start_m_s, demand, traction, line: Line::draw(stream) }
}

/// On and off at changing levels, then one last level until the end.
fn steps(stream: &mut Stream, low: f64, high: f64) -> Vec<(f64, f64)> {
    let mut demand = Vec::new();
    let mut time_s = 4.0;
    while time_s < 56.0 {
        demand.push((time_s, stream.uniform(low, high)));
        time_s += stream.uniform(4.0, 8.0);
        demand.push((time_s, 0.0));
        time_s += stream.uniform(3.0, 5.5);
    }
    demand.push((time_s, stream.uniform(0.7, 0.85)));
    demand
}
