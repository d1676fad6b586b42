//! Recordings as they are, made fit for a diagnosis: jitter, missing rows, empty cells, pauses and columns that no run has.
//! All that was done is said, in sentences.
//!
//! * *place* – a point in time of a regular rate; a row that jitters belongs to the nearest one.
//! * *output* – vehicle and wheelset speeds. Where one was not measured it stays empty: nothing is made up.
//! * *input* – what acts on the wagon (forces, torques, slope, sand). A simulation needs it at every place: interpolated over
//!   up to half a second; where it is missing for longer, the run is cut in two.

mod clock;
mod parts;
mod stretch;

use crate::checks::{check_required, check_time_present};
use crate::columns::{Quantity, columns_of_run, usual_name, wheelsets_of_header};
use crate::csv_form::Missing;
use crate::error::{Place, Problem, RecordingError, Result};
use crate::recording::Recording;
use crate::run_name::RunFile;
use crate::table::Table;
use std::path::Path;

/// Rates at which a run can be diagnosed, Hz.
const RATES_HZ: [f64; 2] = [20.0, 200.0];
/// Least part of a run that is kept, s.
const LEAST_PART_S: f64 = 0.95;

/// A column of a file that is a column of a run under another name or in another unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Renamed {
    /// Name in the file.
    pub from: String,
    /// What its values are multiplied by.
    pub factor: f64,
    /// Name in a run.
    pub to: String,
}

/// What a reader is told about a file beside its name.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mending {
    /// Columns under other names.
    pub renamed: Vec<Renamed>,
    /// Columns of the file, after renaming, that are left out.
    pub dropped: Vec<String>,
    /// Rate to which rows are thinned out, Hz; absent: that of the file.
    pub rate_hz: Option<f64>,
}

/// A run made fit for a diagnosis.
#[derive(Clone, Debug, PartialEq)]
pub struct Mended {
    /// Regular stretches in order, each with the run's name. Outputs that were not measured are NaN; inputs are all there.
    pub parts: Vec<Recording>,
    /// What was done and assumed, in sentences; empty for a recording that needed nothing.
    pub notes: Vec<String>,
    /// Where the rows stood.
    pub rows: Rows,
}

/// The rows of a file by their times.
#[derive(Clone, Debug, PartialEq)]
pub struct Rows(Vec<(f64, Place)>);

impl Rows {
    /// Where the row of a time, s, stands in the file: the last one that was not taken later.
    pub fn place(&self, t_s: f64) -> Place {
        let later = self.0.partition_point(|(time_s, _)| *time_s <= t_s + 1e-6);
        self.0.get(later.saturating_sub(1)).map_or(Place::Row(1), |(_, place)| *place)
    }
}

impl Recording {
    /// Reads a run as it was recorded and mends what can be mended.
    ///
    /// # Errors
    /// A missing or doubled column, text or `NaN` in a cell, a value out of its range, time that does not increase, more
    /// jitter than a fifth of a period, a rate beyond 20 to 200 Hz, less than a second that can be used.
    pub fn read_mended(path: &Path, mending: &Mending) -> Result<Mended> {
        let run = RunFile::of(path)?;
        let mut notes = Vec::new();
        let table = read(path, mending, &mut notes)?;
        let wheelsets = wheelsets_of_header(table.names());
        check_values(&table, wheelsets, path)?;
        let stretches = clock::stretches(&table, &Quantity::Time.column(0, wheelsets))?;
        check_rate(path, &stretches, mending)?;
        pauses(&table, &stretches, &mut notes);
        let mut parts = Vec::new();
        for stretch in &stretches {
            let whole = stretch::resampled(&table, stretch, &run, wheelsets, mending.rate_hz, &mut notes);
            parts.extend(parts::cut(whole, &mut notes));
        }
        parts::keep_long(&mut parts, LEAST_PART_S, &mut notes);
        if parts.is_empty() {
            let time_s = table.column(&Quantity::Time.column(0, wheelsets)).unwrap_or_default();
            let duration_s = time_s.last().zip(time_s.first()).map_or(0.0, |(last, first)| last - first);
            return Err(RecordingError::new(path, Problem::TooShort { duration_s, minimum_s: 1.0 }));
        }
        let time_s = table.column(&Quantity::Time.column(0, wheelsets)).unwrap_or_default();
        let rows = Rows(time_s.iter().enumerate().map(|(row, t_s)| (*t_s, table.place(row))).collect());
        Ok(Mended { parts, notes, rows })
    }
}

/// Reads the columns of a run, under their usual names and in their units.
fn read(path: &Path, mending: &Mending, notes: &mut Vec<String>) -> Result<Table> {
    let new_name = |name: &str| {
        let renamed = mending.renamed.iter().find(|renamed| renamed.from == name);
        renamed.map_or(name, |renamed| renamed.to.as_str()).to_owned()
    };
    let header = std::cell::RefCell::new(Vec::new());
    let choose = |names: &[String]| {
        header.replace(names.to_vec());
        if let Some(absent) = mending.renamed.iter().find(|renamed| !names.contains(&renamed.from)) {
            return Err((absent.from.clone(), Problem::MissingColumn { found: names.join(", ") }));
        }
        let left = |name: &String| !mending.dropped.contains(name);
        let renamed: Vec<String> = names.iter().map(|name| new_name(name)).collect();
        if let Some(absent) = mending.dropped.iter().find(|name| !renamed.contains(name)) {
            return Err((absent.clone(), Problem::nothing_to_drop(names)));
        }
        let kept: Vec<String> = renamed.iter().filter(|name| left(name)).cloned().collect();
        check_required(&kept)?;
        let wheelsets = wheelsets_of_header(&kept);
        let columns = columns_of_run(wheelsets);
        let known = |name: &String| {
            let usual = usual_name(name, wheelsets);
            left(name) && columns.iter().any(|(_, _, column)| *column == usual)
        };
        Ok(renamed.iter().map(known).collect())
    };
    let mut table = Table::read_chosen(path, &choose, Missing::Empty)?;
    for renamed in mending.renamed.iter().filter(|renamed| renamed.factor != 1.0) {
        table.scale(&renamed.from, renamed.factor);
    }
    let header = header.into_inner();
    let unknown: Vec<&str> =
        header.iter().filter(|name| table.column(name).is_none()).map(String::as_str).collect();
    for renamed in &mending.renamed {
        let Renamed { from, factor, to } = renamed;
        notes.push(match *factor == 1.0 {
            true => format!("{from} is read as {to}"),
            false => format!("{from} times {factor} is read as {to}"),
        });
    }
    if !unknown.is_empty() {
        notes.push(format!("left out, as no column of a run: {}", unknown.join(", ")));
    }
    let wheelsets = wheelsets_of_header(&table.names().iter().map(|name| new_name(name)).collect::<Vec<_>>());
    table.rename(|name| usual_name(&new_name(name), wheelsets));
    absent(&mut table, wheelsets, notes);
    Ok(table)
}

/// Says which columns of consequence a run has not; a column without any value counts as absent.
fn absent(table: &mut Table, wheelsets: usize, notes: &mut Vec<String>) {
    for (quantity, wheelset, name) in columns_of_run(wheelsets) {
        if quantity.required() {
            continue;
        }
        if table.column(&name).is_some_and(|cells| cells.iter().all(|cell| !cell.is_finite())) {
            table.remove(&name);
            notes.push(format!("every cell of {name} is empty; taken as absent"));
        }
        let missing = table.column(&name).is_none() && wheelset == 0;
        match quantity {
            Quantity::DriveTorque if missing => {
                notes.push("no drive torques (m_w_*): taken as a trailer".to_owned());
            }
            Quantity::Grade if missing => notes.push("no grade_rad: taken as level track".to_owned()),
            _ => {}
        }
    }
}

/// Every time is there, every value that is there is one that a sensor gives, and no output or pressing force is without any.
fn check_values(table: &Table, wheelsets: usize, path: &Path) -> Result<()> {
    check_time_present(table, wheelsets)?;
    for (quantity, _, name) in columns_of_run(wheelsets) {
        let Some(cells) = table.column(&name) else { continue };
        if quantity.required() && cells.iter().all(|cell| cell.is_nan()) {
            return Err(RecordingError::new(path, Problem::NoValue).column(&name));
        }
        let allowed = quantity.allowed();
        if let Some(row) = cells.iter().position(|cell| !cell.is_nan() && !allowed.contains(cell)) {
            let (low, high, unit) = (*allowed.start(), *allowed.end(), quantity.unit());
            let problem = Problem::OutOfRange { value: cells[row], low, high, unit };
            return Err(table.cell_error(row, &name, problem));
        }
    }
    Ok(())
}

fn check_rate(path: &Path, stretches: &[clock::Stretch], mending: &Mending) -> Result<()> {
    let Some(longest) = stretches.iter().max_by_key(|stretch| stretch.len()) else { return Ok(()) };
    let recorded_hz = 1.0 / longest.period_s;
    let [low_hz, high_hz] = RATES_HZ;
    let within = |rate_hz: f64, high_hz: f64| (0.99 * low_hz..=1.01 * high_hz).contains(&rate_hz);
    if !within(recorded_hz, high_hz) {
        let problem = Problem::RateRange { found_hz: recorded_hz, low_hz, high_hz };
        return Err(RecordingError::new(path, problem));
    }
    match mending.rate_hz {
        Some(wanted_hz) if !within(wanted_hz, recorded_hz) => {
            let problem = Problem::WantedRate { wanted_hz, low_hz, high_hz: recorded_hz };
            Err(RecordingError::new(path, problem))
        }
        _ => Ok(()),
    }
}

/// Says where a recording pauses.
fn pauses(table: &Table, stretches: &[clock::Stretch], notes: &mut Vec<String>) {
    let time_s = table.column(&Quantity::Time.column(0, 2)).unwrap_or_default();
    for pair in stretches.windows(2) {
        let (before, after) = (pair[0].rows.end - 1, pair[1].rows.start);
        let pause_s = time_s[after] - time_s[before];
        notes.push(format!("no row for {pause_s:.2} s before {}: cut in two there", table.place(after)));
    }
}
