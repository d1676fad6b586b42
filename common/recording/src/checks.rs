//! What makes a table a run: header, cells, time.

use crate::columns::{MAX_WHEELSETS, Quantity, columns_of_run, described, usual_name, wheelsets_of_header};
use crate::error::{Problem, RecordingError, Result};
use crate::table::Table;
use std::collections::BTreeSet;

/// How much dirt a reader takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Strictness {
    /// Every cell present, finite and plausible, time regular, at least one second: for fitting models.
    Strict,
    /// As recordings are: an empty, NaN or infinite cell means not measured, times may repeat, come late or leave gaps, values may
    /// spike; whoever consumes the rows deals with it. Header, text in cells and the presence of a time stay errors.
    Tolerant,
}

/// Allowed deviation of a time step from the run's median step.
const STEP_TOLERANCE: f64 = 0.05;
/// Rows of which more go back in time are in no order at all.
const MOST_BACKWARDS: f64 = 0.1;
/// Fewer steps say nothing about a clock.
const LEAST_STEPS: usize = 10;
/// Rates between which the sensors of a wagon or rig are sampled, Hz: beyond, the time is not in seconds.
const CLOCK_RATES_HZ: [f64; 2] = [5.0, 20_000.0];
/// Shortest run that a gap window fits in (seconds).
const MINIMUM_DURATION_S: f64 = 1.0;

/// Fails for a header that is not that of a run, or names a column that no run has.
pub(crate) fn check_header(names: &[String]) -> std::result::Result<(), (String, Problem)> {
    let wheelsets = wheelsets_of_header(names);
    let columns = columns_of_run(wheelsets);
    let known = |name: &&String| {
        let usual = usual_name(name, wheelsets);
        columns.iter().any(|(_, _, column)| *column == usual)
    };
    match names.iter().find(|name| !known(name)) {
        Some(unknown) => Err((unknown.clone(), Problem::UnknownColumn { allowed: described(&columns) })),
        None => check_required(names),
    }
}

/// Fails for a header that lacks a column of a run or has one twice; it may name others beside them.
pub(crate) fn check_required(names: &[String]) -> std::result::Result<(), (String, Problem)> {
    let wheelsets = wheelsets_of_header(names);
    let names = &names.iter().map(|name| usual_name(name, wheelsets)).collect::<Vec<_>>();
    let columns = columns_of_run(wheelsets);
    let mut seen = BTreeSet::new();
    if let Some(twice) = names.iter().find(|name| !seen.insert(*name)) {
        return Err((twice.clone(), Problem::DuplicateColumn));
    }
    let absent = |(quantity, _, name): &&(Quantity, usize, String)| {
        let wanted = quantity.required() || some_wheelset(names, &columns, *quantity);
        wanted && !names.contains(name)
    };
    match columns.iter().find(absent) {
        Some((_, _, name)) => Err((name.clone(), Problem::missing_column(names))),
        None => Ok(()),
    }
}

/// An optional quantity of the wheelsets is there for all of them or for none.
fn some_wheelset(names: &[String], columns: &[(Quantity, usize, String)], quantity: Quantity) -> bool {
    columns
        .iter()
        .any(|(other, _, name)| *other == quantity && quantity.per_wheelset() && names.contains(name))
}

/// Fails for a table without rows or without a time in one of them.
pub(crate) fn check_time_present(table: &Table, wheelsets: usize) -> Result<()> {
    if table.rows() == 0 {
        return Err(RecordingError::new(table.file(), Problem::EmptyRun));
    }
    table.require_finite(&Quantity::Time.column(0, wheelsets))
}

pub(crate) fn check_columns(table: &Table, wheelsets: usize, strictness: Strictness) -> Result<()> {
    debug_assert!((1..=MAX_WHEELSETS).contains(&wheelsets));
    check_time_present(table, wheelsets)?;
    if strictness == Strictness::Tolerant {
        return check_clock(table, &Quantity::Time.column(0, wheelsets));
    }
    for (quantity, _, name) in columns_of_run(wheelsets) {
        check_cells(table, quantity, &name)?;
    }
    check_time(table, &Quantity::Time.column(0, wheelsets))
}

/// Late and repeated rows happen; rows in no order, or a clock that counts something else than seconds, are an error that no
/// consumer can mend.
pub(crate) fn check_clock(table: &Table, name: &str) -> Result<()> {
    let time_s = table.column(name).unwrap_or_default();
    let mut steps: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if steps.len() < LEAST_STEPS {
        return Ok(());
    }
    let share = steps.iter().filter(|step| **step < 0.0).count() as f64 / steps.len() as f64;
    if share > MOST_BACKWARDS
        && let Some(first) = steps.iter().position(|step| *step < 0.0)
    {
        let problem = Problem::RowsOutOfOrder { percent: 100.0 * share };
        return Err(table.cell_error(first + 1, name, problem));
    }
    steps.retain(|step| *step > 0.0);
    if steps.is_empty() {
        return Err(RecordingError::new(table.file(), Problem::TimeStands { time_s: time_s[0] }).column(name));
    }
    let middle = steps.len() / 2;
    let (_, &mut period_s, _) = steps.select_nth_unstable_by(middle, f64::total_cmp);
    let [low_hz, high_hz] = CLOCK_RATES_HZ;
    if (low_hz..=high_hz).contains(&(1.0 / period_s)) {
        return Ok(());
    }
    let problem = Problem::Clock { found_hz: 1.0 / period_s, low_hz, high_hz };
    Err(RecordingError::new(table.file(), problem).column(name))
}

fn check_cells(table: &Table, quantity: Quantity, name: &str) -> Result<()> {
    let Some(cells) = table.column(name) else { return Ok(()) };
    table.require_finite(name)?;
    let allowed = quantity.allowed();
    match cells.iter().position(|value| !allowed.contains(value)) {
        Some(row) => {
            let (low, high, unit) = (*allowed.start(), *allowed.end(), quantity.unit());
            let problem = Problem::OutOfRange { value: cells[row], low, high, unit };
            Err(table.cell_error(row, name, problem))
        }
        None => Ok(()),
    }
}

pub(crate) fn check_time(table: &Table, name: &str) -> Result<()> {
    let time_s = table.column(name).unwrap_or_default();
    let steps: Vec<f64> = time_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if let Some(back) = steps.iter().position(|step| *step <= 0.0) {
        let problem = Problem::TimeNotIncreasing { value: time_s[back + 1], previous: time_s[back] };
        return Err(table.cell_error(back + 1, name, problem));
    }
    let duration_s = time_s.last().zip(time_s.first()).map_or(0.0, |(last, first)| last - first);
    if duration_s < MINIMUM_DURATION_S * (1.0 - STEP_TOLERANCE) {
        let problem = Problem::TooShort { duration_s, minimum_s: MINIMUM_DURATION_S };
        return Err(RecordingError::new(table.file(), problem));
    }
    let mut sorted = steps.clone();
    let middle = sorted.len() / 2;
    let (_, &mut period_s, _) = sorted.select_nth_unstable_by(middle, f64::total_cmp);
    match steps.iter().position(|step| (step - period_s).abs() > STEP_TOLERANCE * period_s) {
        Some(odd) => {
            let tolerance_percent = 100.0 * STEP_TOLERANCE;
            let problem = Problem::TimeIrregular { step_s: steps[odd], period_s, tolerance_percent };
            Err(table.cell_error(odd + 1, name, problem))
        }
        None => Ok(()),
    }
}
