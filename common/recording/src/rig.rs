//! Recordings of rigs with sensors of their own: one row type a rig, read, checked and written alike.

use crate::checks::{Strictness, check_clock, check_time};
use crate::error::{Problem, RecordingError, Result};
use crate::table::{Table, expect_columns};
use std::ops::RangeInclusive;
use std::path::Path;

/// Values in a row beside its time.
pub const RIG_VALUES: usize = 7;

/// A column: its name, what its sensor can give, and the unit.
pub struct RigColumn {
    /// Name in the header.
    pub name: &'static str,
    /// What the sensor can give.
    pub allowed: RangeInclusive<f64>,
    /// Unit for people.
    pub unit: &'static str,
    /// Empty cells are part of a sound recording: the sensor is read less often than the others.
    pub sparse: bool,
}

impl RigColumn {
    pub(crate) const fn new(name: &'static str, allowed: RangeInclusive<f64>, unit: &'static str) -> Self {
        Self { name, allowed, unit, sparse: false }
    }
}

/// One sample of a rig; NaN is not measured.
pub trait RigRow: Copy {
    /// The columns in the order of a file, the time first.
    const COLUMNS: [RigColumn; 1 + RIG_VALUES];

    /// A row from the values of a file's columns.
    fn of(t_s: f64, values: [f64; RIG_VALUES]) -> Self;

    /// Time on the recorder's base, s.
    fn t_s(&self) -> f64;

    /// The values in the order of a file's columns.
    fn values(&self) -> [f64; RIG_VALUES];

    /// Whether a value, counted as in [`RigRow::values`], is one that its sensor can give.
    #[must_use]
    fn is_plausible(&self, index: usize) -> bool {
        Self::COLUMNS[1 + index].allowed.contains(&self.values()[index])
    }
}

/// One run of a rig.
#[derive(Debug, Clone, PartialEq)]
pub struct RigRecording<R> {
    /// Name: the file's without its ending.
    pub name: String,
    /// Its samples.
    pub rows: Vec<R>,
}

impl<R> Default for RigRecording<R> {
    fn default() -> Self {
        Self { name: String::new(), rows: Vec::new() }
    }
}

impl<R: RigRow> RigRecording<R> {
    /// Names of the columns in the order of a file.
    #[must_use]
    pub fn columns() -> [&'static str; 1 + RIG_VALUES] {
        R::COLUMNS.map(|column| column.name)
    }

    /// Reads a run of either form.
    ///
    /// # Errors
    /// What is wrong, with file, line and column; see [`Strictness`] for what counts as wrong.
    pub fn read(path: &Path, strictness: Strictness) -> Result<Self> {
        let names = Self::columns();
        let table = Table::read_checked(path, &expect_columns(&names, &[]))?;
        if table.rows() == 0 {
            return Err(RecordingError::new(path, Problem::EmptyRun));
        }
        table.require_finite(names[0])?;
        if strictness == Strictness::Strict {
            for column in &R::COLUMNS {
                check(&table, column)?;
            }
            check_time(&table, names[0])?;
        } else {
            check_clock(&table, names[0])?;
        }
        let cell =
            |index: usize, row: usize| table.column(names[index]).map_or(f64::NAN, |column| column[row]);
        let rows = (0..table.rows())
            .map(|row| R::of(cell(0, row), std::array::from_fn(|index| cell(1 + index, row))))
            .collect();
        let name = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        Ok(Self { name, rows })
    }

    /// Writes the run atomically; the ending of `path` names the form.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<()> {
        let names = Self::columns().into_iter().map(str::to_owned);
        Table::new(names.zip(cells(&self.rows)).collect())?.write(path)
    }
}

/// The rows column by column.
pub(crate) fn cells<R: RigRow>(rows: &[R]) -> Vec<Vec<f64>> {
    let mut columns = vec![rows.iter().map(R::t_s).collect::<Vec<_>>()];
    columns.extend((0..RIG_VALUES).map(|index| rows.iter().map(|row| row.values()[index]).collect()));
    columns
}

/// Every cell holds a value that the sensor can give.
fn check(table: &Table, column: &RigColumn) -> Result<()> {
    if !column.sparse {
        table.require_finite(column.name)?;
    }
    let cells = table.column(column.name).unwrap_or_default();
    let sound = |value: &f64| column.allowed.contains(value) || column.sparse && value.is_nan();
    match cells.iter().position(|value| !sound(value)) {
        None => Ok(()),
        Some(row) => {
            let (low, high) = (*column.allowed.start(), *column.allowed.end());
            let problem = Problem::OutOfRange { value: cells[row], low, high, unit: column.unit };
            Err(table.cell_error(row, column.name, problem))
        }
    }
}
