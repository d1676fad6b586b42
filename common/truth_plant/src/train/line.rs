//! The line: stations, speed limits, grades and what the map says of them, curves, and the texture of its rails.

use std::f64::consts::TAU;

use crate::random::Stream;

/// Length of a cell of the profile, m.
const CELL_M: f64 = 20.0;
/// Where the head of the train stands at the start, m; the longest train fits behind it.
pub(crate) const START_M: f64 = 1600.0;

/// What a line is drawn from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LinePlan {
    /// Distance of stations, m.
    pub station_m: (f64, f64),
    /// Top speed, m/s.
    pub top_m_s: f64,
    /// Steepest usual grade, rad.
    pub grade_rad: f64,
    /// Length to make, m.
    pub length_m: f64,
    /// Length of the train, m.
    pub train_m: f64,
}

/// A stretch where the rail is dirty in any weather.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowStretch {
    /// Where it begins and ends, m.
    pub from_m: f64,
    /// End, m.
    pub to_m: f64,
    /// Friction there.
    pub friction: f64,
}

/// A line.
#[derive(Debug, Clone)]
pub struct Line {
    grade_rad: Vec<f64>,
    map_rad: Vec<f64>,
    curve: Vec<f64>,
    texture: Vec<f64>,
    /// Stopping points, m.
    pub stations_m: Vec<f64>,
    /// From where on (m) which speed is allowed (m/s).
    pub(crate) limits: Vec<(f64, f64)>,
    /// Dirty stretches.
    pub low: Vec<LowStretch>,
}

impl Line {
    pub(crate) fn draw(stream: &mut Stream, plan: &LinePlan) -> Self {
        let cells = ((START_M + plan.length_m) / CELL_M) as usize + 2;
        let mut stations_m = vec![START_M];
        let mut at_m = START_M;
        while at_m < plan.length_m {
            at_m += stream.uniform(plan.station_m.0, plan.station_m.1);
            stations_m.push(at_m);
        }
        let raw = waves(stream, cells, plan.grade_rad, (900.0, 7000.0));
        let flat = flatness(&stations_m, cells, plan.train_m);
        let grade_rad: Vec<f64> = raw.iter().zip(&flat).map(|(grade, flat)| grade * flat).collect();
        let error_rad = stream.uniform(0.0001, 0.0005);
        let error = waves(stream, cells, error_rad, (400.0, 3000.0));
        let map_rad = grade_rad.iter().zip(&error).map(|(grade, error)| grade + error).collect();
        let texture = waves(stream, cells, 0.07, (60.0, 900.0)).iter().map(|wave| 1.0 + wave).collect();
        let mut limits = vec![(0.0, plan.top_m_s * stream.uniform(0.85, 1.0))];
        let mut from_m = START_M;
        while from_m < plan.length_m {
            from_m += stream.uniform(2500.0, 12_000.0);
            limits.push((from_m, plan.top_m_s * stream.uniform(0.7, 1.0)));
        }
        let curve = curves(stream, cells);
        Self { grade_rad, map_rad, curve, texture, stations_m, limits, low: Vec::new() }
    }

    /// Slope at a place, rad, uphill positive.
    pub(crate) fn grade_rad(&self, position_m: f64) -> f64 {
        between(&self.grade_rad, position_m)
    }

    /// Slope that the map gives, rad.
    pub(crate) fn map_rad(&self, position_m: f64) -> f64 {
        between(&self.map_rad, position_m)
    }

    /// Curve resistance, N per N of weight.
    pub(crate) fn curve(&self, position_m: f64) -> f64 {
        self.curve[cell(position_m, self.curve.len())]
    }

    /// Local factor on friction.
    pub(crate) fn texture(&self, position_m: f64) -> f64 {
        between(&self.texture, position_m)
    }

    /// Friction of the dirty stretch at a place, if there is one.
    pub(crate) fn dirt(&self, position_m: f64) -> Option<f64> {
        let here = self.low.iter().filter(|low| (low.from_m..low.to_m).contains(&position_m));
        here.map(|low| low.friction).reduce(f64::min)
    }

    /// Speed limit at a place, m/s.
    pub(crate) fn limit_m_s(&self, position_m: f64) -> f64 {
        let passed = self.limits.partition_point(|(from_m, _)| *from_m <= position_m);
        self.limits[passed.max(1) - 1].1
    }
}

fn cell(position_m: f64, cells: usize) -> usize {
    ((position_m / CELL_M).max(0.0) as usize).min(cells - 1)
}

fn between(values: &[f64], position_m: f64) -> f64 {
    let place = (position_m / CELL_M).clamp(0.0, (values.len() - 2) as f64);
    let first = place as usize;
    let share = place - first as f64;
    values[first] * (1.0 - share) + values[(first + 1).min(values.len() - 1)] * share
}

/// Three sine waves of random length whose sum rarely passes `amplitude`.
fn waves(stream: &mut Stream, cells: usize, amplitude: f64, length_m: (f64, f64)) -> Vec<f64> {
    let wave = |stream: &mut Stream| {
        let number = TAU * CELL_M / stream.uniform(length_m.0, length_m.1);
        (0.45 * amplitude * stream.uniform(0.5, 1.3), number, stream.uniform(0.0, TAU))
    };
    let set = [wave(stream), wave(stream), wave(stream)];
    let sum = |cell: usize| {
        set.iter().map(|(size, number, phase)| size * (number * cell as f64 + phase).sin()).sum()
    };
    (0..cells).map(sum).collect()
}

/// Stations are nearly level: the factor on the grade of each cell.
fn flatness(stations_m: &[f64], cells: usize, train_m: f64) -> Vec<f64> {
    let mut flat = vec![1.0f64; cells];
    let reach_m = train_m + 200.0;
    for station in stations_m {
        let first = cell(station - reach_m - 400.0, cells);
        let last = cell(station + 600.0, cells);
        for (index, factor) in flat.iter_mut().enumerate().take(last + 1).skip(first) {
            let at_m = index as f64 * CELL_M;
            let off_m = if at_m > *station { at_m - station - 200.0 } else { station - reach_m - at_m };
            *factor = factor.min(0.15 + 0.85 * (off_m / 400.0).clamp(0.0, 1.0));
        }
    }
    flat
}

/// Curves of 500 to 3000 m radius with the resistance of long bogie wagons in them, 4.4 mm of rolling friction a radius.
fn curves(stream: &mut Stream, cells: usize) -> Vec<f64> {
    let mut curve = vec![0.0; cells];
    let mut at = 0;
    while at < cells {
        at += (stream.uniform(800.0, 4000.0) / CELL_M) as usize;
        let length = (stream.uniform(150.0, 700.0) / CELL_M) as usize;
        let resistance = 0.55 / stream.uniform(500.0, 3000.0);
        curve.iter_mut().skip(at).take(length).for_each(|cell| *cell = resistance);
        at += length;
    }
    curve
}
