//! Named columns of numbers, as a file of either form holds them. Knows nothing of trains: runs, truth, estimates and bench
//! measurements are all tables.
//!
//! A missing cell (empty in CSV, null in Parquet) and a NaN are both NaN here; what they mean is decided by who checks.

use crate::error::{Place, Problem, RecordingError, Result};
use std::path::{Path, PathBuf};

/// Looks at the column names of a file before its cells are read.
pub type HeaderCheck<'a> = &'a dyn Fn(&[String]) -> std::result::Result<(), (String, Problem)>;

/// Looks at the column names of a file before its cells are read, and says of each whether it is wanted.
pub(crate) type ColumnChoice<'a> = &'a dyn Fn(&[String]) -> std::result::Result<Vec<bool>, (String, Problem)>;

/// Most memory that the columns of a file may fill: 512 MiB, which a computer on board has to spare. Twelve hours of 15 columns
/// at 100 Hz.
pub(crate) const MOST_BYTES: u64 = 512 << 20;

/// Columns of equal length.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    file: PathBuf,
    pub(crate) names: Vec<String>,
    pub(crate) columns: Vec<Vec<f64>>,
    lines: Option<Vec<u64>>,
    pub(crate) words: Vec<Words>,
}

/// A column of words; only a program makes one, files with words are not read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Words {
    pub(crate) name: String,
    pub(crate) cells: Vec<&'static str>,
}

impl Table {
    /// A table made by a program. Fails when columns differ in length.
    pub fn new(columns: Vec<(String, Vec<f64>)>) -> Result<Self> {
        let (names, columns) = columns.into_iter().unzip();
        Self::assemble(Path::new("table"), names, columns, None)
    }

    /// Adds a column of words behind the numbers. Fails when its length differs.
    pub fn with_words(mut self, name: &str, cells: Vec<&'static str>) -> Result<Self> {
        if cells.len() != self.rows() {
            let text = format!("{name} has {} rows, the first column {}", cells.len(), self.rows());
            return Err(RecordingError::new(&self.file, Problem::Shape(text)));
        }
        self.words.push(Words { name: name.to_owned(), cells });
        Ok(self)
    }

    pub(crate) fn assemble(
        file: &Path,
        names: Vec<String>,
        columns: Vec<Vec<f64>>,
        lines: Option<Vec<u64>>,
    ) -> Result<Self> {
        let rows = columns.first().map_or(0, Vec::len);
        if let Some(odd) = columns.iter().position(|column| column.len() != rows) {
            let text = format!("{} has {} rows, the first column {rows}", names[odd], columns[odd].len());
            return Err(RecordingError::new(file, Problem::Shape(text)));
        }
        Ok(Self { file: file.to_owned(), names, columns, lines, words: Vec::new() })
    }

    /// A table of the columns that are wanted.
    pub(crate) fn chosen(
        file: &Path,
        names: Vec<String>,
        columns: Vec<Vec<f64>>,
        wanted: &[bool],
        lines: Option<Vec<u64>>,
    ) -> Result<Self> {
        let kept = names.into_iter().zip(columns).zip(wanted);
        let (names, columns) = kept.filter_map(|(column, wanted)| wanted.then_some(column)).unzip();
        Self::assemble(file, names, columns, lines)
    }

    /// Other columns in place of those read, row by row from the same places of the file.
    pub(crate) fn replaced(self, names: Vec<String>, columns: Vec<Vec<f64>>) -> Result<Self> {
        Self::assemble(&self.file, names, columns, self.lines)
    }

    /// The file this came from.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Column names in the order of the file.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Gives columns other names.
    pub(crate) fn rename(&mut self, other: impl Fn(&str) -> String) {
        self.names.iter_mut().for_each(|name| *name = other(name));
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// A column by name.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.index(name).map(|index| self.columns[index].as_slice())
    }

    /// Moves a column out, leaving it empty.
    pub(crate) fn take(&mut self, name: &str) -> Option<Vec<f64>> {
        self.index(name).map(|index| std::mem::take(&mut self.columns[index]))
    }

    /// Multiplies a column.
    pub(crate) fn scale(&mut self, name: &str, factor: f64) {
        if let Some(index) = self.index(name) {
            self.columns[index].iter_mut().for_each(|cell| *cell *= factor);
        }
    }

    /// Removes a column.
    pub(crate) fn remove(&mut self, name: &str) {
        if let Some(index) = self.index(name) {
            self.names.remove(index);
            self.columns.remove(index);
        }
    }

    fn index(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    /// Where row `row` (from 0) stands in the file.
    pub fn place(&self, row: usize) -> Place {
        match &self.lines {
            Some(lines) => Place::Line(lines.get(row).copied().unwrap_or_default()),
            None => Place::Row(row as u64 + 1),
        }
    }

    /// An error about one cell of this table.
    pub fn cell_error(&self, row: usize, column: &str, problem: Problem) -> RecordingError {
        RecordingError::new(&self.file, problem).at(self.place(row)).column(column)
    }

    /// Fails unless every cell of `column` is finite.
    pub fn require_finite(&self, column: &str) -> Result<()> {
        let cells = self.column(column).unwrap_or_default();
        match cells.iter().position(|value| !value.is_finite()) {
            Some(row) => Err(self.cell_error(row, column, Problem::NotFinite)),
            None => Ok(()),
        }
    }
}

/// A header check for exactly these required and optional names.
pub fn expect_columns<'a>(
    required: &'a [&'a str],
    optional: &'a [&'a str],
) -> impl Fn(&[String]) -> std::result::Result<(), (String, Problem)> + 'a {
    move |names| {
        let allowed = || [required, optional].concat().join(", ");
        for name in names {
            if !required.contains(&name.as_str()) && !optional.contains(&name.as_str()) {
                return Err((name.clone(), Problem::UnknownColumn { allowed: allowed() }));
            }
        }
        match required.iter().find(|name| !names.iter().any(|found| found == *name)) {
            Some(name) => Err(((*name).to_owned(), Problem::missing_column(names))),
            None => Ok(()),
        }
    }
}

/// Whether so many rows of the columns that are wanted fit into memory.
pub(crate) fn fits(rows: u64, columns: usize, most_bytes: u64) -> std::result::Result<(), Problem> {
    let bytes = rows.saturating_mul(columns as u64).saturating_mul(size_of::<f64>() as u64);
    let mib = |bytes: u64| bytes.div_ceil(1 << 20);
    match bytes <= most_bytes {
        true => Ok(()),
        false => Err(Problem::TooManyCells { rows, columns, mib: mib(bytes), most_mib: mib(most_bytes) }),
    }
}
