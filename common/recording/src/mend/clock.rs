//! The clock of a recording: which place of a regular rate each row has.

use crate::error::{Problem, Result};
use crate::table::Table;
use std::ops::Range;

/// Rows may stand beside their place by this share of a period.
const JITTER: f64 = 0.2;
/// Rows that keep to this share of a period are regular as they are.
const REGULAR: f64 = 0.05;
/// A longer pause ends a stretch of rows, s.
pub(super) const LONGEST_GAP_S: f64 = 0.5;

/// Rows without a long pause between them, and their places in a regular rate.
#[derive(Debug)]
pub(super) struct Stretch {
    /// The rows, by their index in the table.
    pub(super) rows: Range<usize>,
    /// Time of place 0, s.
    pub(super) start_s: f64,
    /// Period of the rate, s.
    pub(super) period_s: f64,
    /// Place of each row, from 0.
    pub(super) places: Vec<usize>,
    /// Most that a row stands beside its place, as a share of the period.
    pub(super) jitter: f64,
    /// Whether the rows can stay as they are: none is missing, none stands beside its place.
    pub(super) regular: bool,
}

impl Stretch {
    /// Number of places.
    pub(super) fn len(&self) -> usize {
        self.places.last().map_or(0, |last| last + 1)
    }

    /// Time of a place, s.
    pub(super) fn time_s(&self, place: usize) -> f64 {
        self.start_s + self.period_s * place as f64
    }
}

/// Splits rows at long pauses and finds their places. Fails where time does not increase, and for a row that stands beside
/// every place.
pub(super) fn stretches(table: &Table, time: &str) -> Result<Vec<Stretch>> {
    let time_s = table.column(time).unwrap_or_default();
    let steps: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if let Some(back) = steps.iter().position(|step| *step <= 0.0) {
        let problem = Problem::TimeNotIncreasing { value: time_s[back + 1], previous: time_s[back] };
        return Err(table.cell_error(back + 1, time, problem));
    }
    let Some(period_s) = typical(&steps) else { return Ok(Vec::new()) };
    let mut stretches = Vec::new();
    let mut from = 0;
    for to in 1..=time_s.len() {
        if to == time_s.len() || steps[to - 1] > LONGEST_GAP_S.max(1.5 * period_s) {
            stretches.push(place(table, time, from..to, period_s)?);
            from = to;
        }
    }
    Ok(stretches)
}

/// The usual step: the mean of those near the median, so that neither jitter nor pauses move it.
fn typical(steps: &[f64]) -> Option<f64> {
    let mut sorted = steps.to_vec();
    sorted.sort_by(f64::total_cmp);
    let median = *sorted.get(sorted.len() / 2)?;
    let near: Vec<f64> = sorted.into_iter().filter(|step| (0.5..1.5).contains(&(step / median))).collect();
    Some(near.iter().sum::<f64>() / near.len() as f64)
}

/// Finds the places of rows: steps in whole periods, then start and period by least squares.
fn place(table: &Table, name: &str, rows: Range<usize>, typical_s: f64) -> Result<Stretch> {
    let time_s = &table.column(name).unwrap_or_default()[rows.clone()];
    let mut places = vec![0; time_s.len()];
    for k in 1..time_s.len() {
        places[k] = places[k - 1] + ((time_s[k] - time_s[k - 1]) / typical_s).round() as usize;
    }
    let n = time_s.len() as f64;
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / n;
    let centre = mean(&mut places.iter().map(|place| *place as f64));
    let middle_s = mean(&mut time_s.iter().copied());
    let each = || places.iter().zip(time_s).map(|(place, t)| (*place as f64 - centre, t - middle_s));
    let spread: f64 = each().map(|(x, _)| x * x).sum();
    let period_s = if spread > 0.0 { each().map(|(x, t)| x * t).sum::<f64>() / spread } else { typical_s };
    let start_s = middle_s - period_s * centre;
    let beside = |k: usize| time_s[k] - (start_s + period_s * places[k] as f64);
    let steps = || places.windows(2).map(|pair| pair[1] - pair[0]);
    let doubled = steps().position(|step| step == 0).map(|k| k + 1);
    let off = (0..time_s.len()).find(|k| beside(*k).abs() > JITTER * period_s);
    if let Some(row) = doubled.into_iter().chain(off).min() {
        let problem =
            Problem::TimeJitter { deviation_s: beside(row), period_s, tolerance_percent: 100.0 * JITTER };
        return Err(table.cell_error(rows.start + row, name, problem));
    }
    let jitter = (0..time_s.len()).map(|k| beside(k).abs() / period_s).fold(0.0, f64::max);
    let regular = steps().all(|step| step == 1)
        && time_s.windows(2).all(|pair| ((pair[1] - pair[0]) / period_s - 1.0).abs() <= REGULAR);
    Ok(Stretch { rows, start_s, period_s, places, jitter, regular })
}
