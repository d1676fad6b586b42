//! One stretch of rows at a regular rate.

use super::clock::{LONGEST_GAP_S, Stretch};
use crate::columns::{Quantity, columns_of_run};
use crate::recording::{Optional, Recording};
use crate::run_name::RunFile;
use crate::table::Table;
use std::ops::RangeInclusive;

/// The rows of a stretch as a recording: one row a place, all inputs that can be interpolated filled in. Thinned out to
/// `rate_hz` if that is given.
pub(super) fn resampled(
    table: &Table,
    stretch: &Stretch,
    run: &RunFile,
    wheelsets: usize,
    rate_hz: Option<f64>,
    notes: &mut Vec<String>,
) -> Recording {
    let has = |quantity: Quantity| table.column(&quantity.column(0, wheelsets)).is_some();
    let optional = Optional {
        grade: has(Quantity::Grade),
        sanding: has(Quantity::Sanding),
        position: has(Quantity::Position),
        wsp: has(Quantity::WspActive),
        load: has(Quantity::Load),
        brake_demand: has(Quantity::BrakeDemand),
    };
    let mut recording = Recording::empty(&run.name, run.rail, wheelsets, optional);
    say_clock(table, stretch, notes);
    let thinning = Thinning::new(stretch, rate_hz, notes);
    for (quantity, wheelset, name) in columns_of_run(wheelsets) {
        let Some(column) = recording.column_mut(quantity, wheelset) else { continue };
        let mut cells = match table.column(&name) {
            Some(cells) if quantity == Quantity::Time && !stretch.regular => {
                debug_assert_eq!(cells.len(), table.rows());
                (0..stretch.len()).map(|place| stretch.time_s(place)).collect()
            }
            Some(cells) => at_places(table, cells, stretch, quantity),
            // The torques of a trailer.
            None => vec![0.0; stretch.len()],
        };
        if quantity != Quantity::Time {
            say_empty(table, &name, stretch, notes);
        }
        if is_input(quantity) {
            fill(&mut cells, stretch.period_s, is_switch(quantity));
        }
        *column = thinning.of(&cells, quantity);
    }
    recording
}

/// What acts on the wagon and must be known at every place.
pub(super) fn is_input(quantity: Quantity) -> bool {
    matches!(quantity, Quantity::PressingForce | Quantity::DriveTorque | Quantity::Grade | Quantity::Sanding)
}

/// On or off: there is nothing between two values.
fn is_switch(quantity: Quantity) -> bool {
    matches!(quantity, Quantity::Sanding | Quantity::WspActive)
}

/// Cells at their places, NaN where there is none. A row beside its place is moved there along the line through its
/// neighbours; that leaves its noise as it is, which interpolation between two rows would halve.
fn at_places(table: &Table, cells: &[f64], stretch: &Stretch, quantity: Quantity) -> Vec<f64> {
    let rows = &stretch.rows;
    if stretch.regular {
        return cells[rows.clone()].to_vec();
    }
    let time_s = table.column(&Quantity::Time.column(0, 2)).unwrap_or_default();
    let mut placed = vec![f64::NAN; stretch.len()];
    for (row, place) in rows.clone().zip(&stretch.places) {
        let neighbours = row.checked_sub(1).filter(|before| rows.contains(before)).zip(Some(row + 1));
        let slope = |(before, after): (usize, usize)| {
            let (rise, run_s) = (cells[after] - cells[before], time_s[after] - time_s[before]);
            (rise.is_finite() && run_s < 3.5 * stretch.period_s).then_some(rise / run_s)
        };
        let slope = match quantity {
            _ if is_switch(quantity) => 0.0,
            _ => neighbours.filter(|(_, after)| rows.contains(after)).and_then(slope).unwrap_or(0.0),
        };
        placed[*place] = cells[row] + slope * (stretch.time_s(*place) - time_s[row]);
    }
    placed
}

/// Fills gaps of up to half a second between two values: by a straight line, a switch by the value before.
fn fill(cells: &mut [f64], period_s: f64, switch: bool) {
    let mut last: Option<usize> = None;
    for k in 0..cells.len() {
        if cells[k].is_nan() {
            continue;
        }
        if let Some(from) = last
            && (k - from) as f64 * period_s <= LONGEST_GAP_S + 1e-9
        {
            let (first, step) = (cells[from], (cells[k] - cells[from]) / (k - from) as f64);
            for j in from + 1..k {
                cells[j] = if switch { first } else { first + step * (j - from) as f64 };
            }
        }
        last = Some(k);
    }
}

fn say_clock(table: &Table, stretch: &Stretch, notes: &mut Vec<String>) {
    if stretch.regular {
        return;
    }
    let missing = stretch.len() - stretch.places.len();
    if missing > 0 {
        let after = stretch.places.windows(2).position(|pair| pair[1] > pair[0] + 1).unwrap_or(0);
        let (rows, verb) = if missing == 1 { ("row", "is") } else { ("rows", "are") };
        notes.push(format!(
            "{missing} {rows} {verb} missing, the first after {}: inputs are interpolated there, outputs count as not measured",
            table.place(stretch.rows.start + after)
        ));
    }
    if stretch.jitter > 0.05 {
        notes.push(format!(
            "times jitter by up to {:.0} % of a period: moved to a regular rate of {:.2} Hz",
            100.0 * stretch.jitter,
            1.0 / stretch.period_s
        ));
    }
}

fn say_empty(table: &Table, name: &str, stretch: &Stretch, notes: &mut Vec<String>) {
    let Some(cells) = table.column(name) else { return };
    let empty = |row: &usize| cells[*row].is_nan();
    let count = stretch.rows.clone().filter(empty).count();
    if let Some(first) = stretch.rows.clone().find(empty) {
        let cells = if count == 1 { "cell is" } else { "cells are" };
        notes.push(format!("{count} {cells} empty in {name}, the first in {}", table.place(first)));
    }
}

/// Which places are kept at a lower rate.
struct Thinning {
    /// The kept places, and around each the places nearer to it than to another.
    kept: Option<Vec<(usize, RangeInclusive<usize>)>>,
}

impl Thinning {
    fn new(stretch: &Stretch, rate_hz: Option<f64>, notes: &mut Vec<String>) -> Self {
        let recorded_hz = 1.0 / stretch.period_s;
        let ratio = rate_hz.map_or(1.0, |wanted| (recorded_hz / wanted).round().max(1.0));
        if ratio < 1.5 {
            return Self { kept: None };
        }
        let step = ratio as usize;
        notes.push(format!(
            "one row in {step} is kept, at {:.2} Hz: speeds as they are, forces and torques as means around",
            recorded_hz / ratio
        ));
        let last = stretch.len().saturating_sub(1);
        let around = |k: usize| (k, k.saturating_sub(step / 2)..=(k + (step - 1) / 2).min(last));
        Self { kept: Some((0..stretch.len()).step_by(step).map(around).collect()) }
    }

    fn of(&self, cells: &[f64], quantity: Quantity) -> Vec<f64> {
        let Some(kept) = &self.kept else { return cells.to_vec() };
        let averaged = is_input(quantity) && !is_switch(quantity);
        let value = |(k, around): &(usize, RangeInclusive<usize>)| match averaged {
            true => cells[around.clone()].iter().sum::<f64>() / around.clone().count() as f64,
            false => cells[*k],
        };
        kept.iter().map(value).collect()
    }
}
