//! What can be wrong with a recording, said with file, line (CSV) or row (Parquet), column, and what is allowed.

use std::fmt;
use std::path::{Path, PathBuf};

/// Result of this crate.
pub type Result<T> = std::result::Result<T, RecordingError>;

/// A problem with a file of measured columns, and where it lies.
#[derive(Debug, thiserror::Error)]
#[error("{}{}{}: {problem}", .file.display(), Shown(", ", .place), Shown(", column ", .column))]
pub struct RecordingError {
    /// The file as it was named by the caller.
    pub file: PathBuf,
    /// Line or row, where one is to blame.
    pub place: Option<Place>,
    /// Column name, where one is to blame.
    pub column: Option<String>,
    /// What is wrong, and what is allowed.
    pub problem: Problem,
}

impl RecordingError {
    pub(crate) fn new(file: &Path, problem: Problem) -> Self {
        Self { file: file.to_owned(), place: None, column: None, problem }
    }

    pub(crate) fn at(mut self, place: Place) -> Self {
        self.place = Some(place);
        self
    }

    pub(crate) fn column(mut self, column: &str) -> Self {
        self.column = Some(column.to_owned());
        self
    }
}

/// Where in the file: text has lines, Parquet has rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Line of a text file, the header being line 1.
    Line(u64),
    /// Data row of a Parquet file, the first being row 1.
    Row(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(number) => write!(f, "line {number}"),
            Self::Row(number) => write!(f, "row {number}"),
        }
    }
}

/// What is wrong. The texts say what is allowed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The operating system refused.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// The file is not what its ending says.
    #[error("not a readable Parquet file: {0}")]
    Parquet(String),
    /// Pages of a column are packed in a way that is not read.
    #[error("packed with {0}; allowed are none, snappy and zstd: write the file anew with one of them")]
    Packed(String),
    /// A decimal point where other cells have decimal commas.
    #[error(
        "`{0}` has a point where other cells of the file have decimal commas: a decimal point, or thousands?"
    )]
    TwoDecimalSigns(String),
    /// The file ends in neither `.csv` nor `.parquet`.
    #[error("a recording ends in .csv or .parquet")]
    Extension,
    /// A run of a case needs its rail class in its name.
    #[error("the name of a run is NAME.RAIL.csv or NAME.RAIL.parquet with RAIL = dry, wet or low")]
    RailClass,
    /// The same run twice in a folder.
    #[error("this run stands twice in the folder, as .csv and as .parquet; keep one")]
    RunTwice,
    /// A folder without runs.
    #[error("no .csv or .parquet file in this folder")]
    NoRuns,
    /// Bytes that are no text.
    #[error("not UTF-8 text")]
    NotText,
    /// No header line.
    #[error("the file is empty; its first line must name the columns")]
    NoHeader,
    /// A required column is absent.
    #[error("required column is missing; found {found}")]
    MissingColumn {
        /// The header that was found.
        found: String,
    },
    /// A column nobody knows.
    #[error("unknown column; allowed are {allowed}")]
    UnknownColumn {
        /// The names that are allowed.
        allowed: String,
    },
    /// A column name that stands twice in the header.
    #[error("this column stands twice in the header")]
    DuplicateColumn,
    /// The header line stands again among the data.
    #[error("the header stands again among the data (two files joined?); one run a file")]
    HeaderAgain,
    /// A row with too many or too few cells.
    #[error("{found} cells where the header names {expected} columns")]
    Ragged {
        /// Number of columns of the header.
        expected: usize,
        /// Number of cells of the row.
        found: usize,
    },
    /// Text where a number belongs.
    #[error("`{0}` is not a number")]
    NotANumber(String),
    /// A Parquet column that holds no plain numbers.
    #[error("holds {0}; allowed are numbers, decimals, instants and durations, not nested")]
    ColumnType(String),
    /// An empty cell, NaN or infinity where a value is required.
    #[error("empty, NaN or infinite; every cell needs a finite number here")]
    NotFinite,
    /// A word that stands for no number where an empty cell would do.
    #[error("`{0}` is no measurement; leave the cell empty where nothing was measured")]
    NotMeasured(String),
    /// A column of which every cell is empty.
    #[error("every cell is empty; this column needs measurements")]
    NoValue,
    /// A value that no sensor of this kind gives in this unit.
    #[error("{value} is out of range; allowed is {low} to {high} {unit}")]
    OutOfRange {
        /// The value found.
        value: f64,
        /// Smallest allowed value.
        low: f64,
        /// Largest allowed value.
        high: f64,
        /// Unit of the three.
        unit: &'static str,
    },
    /// Time that stands still or runs backwards.
    #[error("time {value} s does not follow {previous} s; time must increase from row to row")]
    TimeNotIncreasing {
        /// Time of the row.
        value: f64,
        /// Time of the row before.
        previous: f64,
    },
    /// A gap or a doubled rate.
    #[error(
        "a step of {step_s:.6} s where the run's step is {period_s:.6} s; allowed is ±{tolerance_percent} %"
    )]
    TimeIrregular {
        /// Step from the row before.
        step_s: f64,
        /// Median step of the run.
        period_s: f64,
        /// Allowed deviation in percent.
        tolerance_percent: f64,
    },
    /// A row beside the regular rate, by more than can be mended.
    #[error(
        "{deviation_s:.6} s beside the regular rate of one row every {period_s:.6} s; mended are up to {tolerance_percent} % \
         of that, and whole rows that are missing"
    )]
    TimeJitter {
        /// Time of the row minus that of its place in the regular rate.
        deviation_s: f64,
        /// Period of the regular rate.
        period_s: f64,
        /// What can be mended, in percent of the period.
        tolerance_percent: f64,
    },
    /// A rate at which no recording is diagnosed.
    #[error("sampled at {found_hz:.3} Hz; allowed are {low_hz} to {high_hz} Hz")]
    RateRange {
        /// Rate of the run.
        found_hz: f64,
        /// Lowest allowed rate.
        low_hz: f64,
        /// Highest allowed rate.
        high_hz: f64,
    },
    /// A rate that nobody can make of a recording.
    #[error("{wanted_hz} Hz were asked for; allowed are {low_hz} Hz to the {high_hz:.2} Hz of the recording")]
    WantedRate {
        /// The rate that was asked for.
        wanted_hz: f64,
        /// Lowest allowed rate.
        low_hz: f64,
        /// Rate of the recording.
        high_hz: f64,
    },
    /// More than is read into memory.
    #[error(
        "{rows} rows of {columns} columns fill {mib} MiB of memory; at most {most_mib} MiB are read at once: cut the file, or \
         name fewer columns"
    )]
    TooManyCells {
        /// Rows that the metadata names.
        rows: u64,
        /// Columns that are wanted.
        columns: usize,
        /// What both would fill, 8 bytes a cell.
        mib: u64,
        /// Most that is read.
        most_mib: u64,
    },
    /// More columns than anybody looks at.
    #[error("{found} columns; at most {most} are looked at: keep those of the sensors")]
    TooManyColumns {
        /// Columns of the file.
        found: usize,
        /// Most that are looked at.
        most: usize,
    },
    /// A row that would fill the memory by itself.
    #[error(
        "a row of more than {most_mib} MiB, or as much without any row: this is no table of measurements"
    )]
    RowTooLong {
        /// Longest row that is read.
        most_mib: u64,
    },
    /// Metadata and data that do not belong together.
    #[error("{found} values where the metadata says {claimed} rows: the file is damaged or forged")]
    RowCount {
        /// Rows by the metadata.
        claimed: u64,
        /// What there is.
        found: u64,
    },
    /// A page that would fill the memory by itself.
    #[error(
        "a page or dictionary of {mib} MiB; at most {most_mib} MiB are unpacked at once: write the file with smaller pages"
    )]
    PageSize {
        /// Bytes of the page, stored, unpacked or as a dictionary.
        mib: u64,
        /// Most that is unpacked.
        most_mib: u64,
    },
    /// A clock that does not count seconds.
    #[error(
        "one row every {:.6} by the clock of the recording, {found_hz:.3} Hz if it counts seconds; expected is s, not ms or µs, at \
         {low_hz} to {high_hz} Hz", 1.0 / found_hz
    )]
    Clock {
        /// Median rate.
        found_hz: f64,
        /// Lowest plausible rate.
        low_hz: f64,
        /// Highest plausible rate.
        high_hz: f64,
    },
    /// A clock that does not move.
    #[error("the time is {time_s} s in every row: nothing says when each was measured")]
    TimeStands {
        /// The time of all rows, s.
        time_s: f64,
    },
    /// Rows that are in no order of time.
    #[error(
        "the time goes back in {percent:.0} % of the rows, first here: the rows are not in the order in which they were \
         measured"
    )]
    RowsOutOfOrder {
        /// Share of the rows whose time is not after that of the row before, percent.
        percent: f64,
    },
    /// Header, but no data.
    #[error("an empty run: there is a header but no row")]
    EmptyRun,
    /// Less than a usable run.
    #[error("the run lasts {duration_s:.3} s; at least {minimum_s} s are needed")]
    TooShort {
        /// Length of the run.
        duration_s: f64,
        /// Shortest allowed run.
        minimum_s: f64,
    },
    /// Another sample rate than the vehicle file declares.
    #[error("sampled at {found_hz:.3} Hz where the vehicle file declares {expected_hz} Hz")]
    Rate {
        /// Mean rate of the run.
        found_hz: f64,
        /// Rate that is needed.
        expected_hz: f64,
    },
    /// A run that would be written stands there.
    #[error("stands there already, and nothing is overwritten: remove it, or name another folder")]
    Taken,
    /// A column that shall be left out and is not there.
    #[error("no such column, which shall be left out; found {found}")]
    NothingToDrop {
        /// The header that was found.
        found: String,
    },
    /// Columns that do not belong together in a value made by a program.
    #[error("columns of different length or number: {0}")]
    Shape(String),
}

impl Problem {
    /// A column is missing among these.
    pub(crate) fn missing_column<T: AsRef<str>>(names: &[T]) -> Self {
        let names: Vec<&str> = names.iter().map(AsRef::as_ref).collect();
        Self::MissingColumn { found: shortened(&names.join(", "), 400) }
    }

    /// Nothing of these is called so.
    pub(crate) fn nothing_to_drop(names: &[String]) -> Self {
        Self::NothingToDrop { found: shortened(&names.join(", "), 400) }
    }
}

/// What a file says, for a message: on one line, and cut off after so many characters. A quotation mark too many makes a whole file one
/// name.
fn shortened(text: &str, most: usize) -> String {
    let mut characters = text.chars().map(|c| if c.is_control() { ' ' } else { c });
    let mut short: String = characters.by_ref().take(most).collect();
    if characters.next().is_some() {
        short.push('…');
    }
    short
}

/// Shows `Some(x)` with a text before it and `None` as nothing.
struct Shown<'a, T>(&'static str, &'a Option<T>);

impl<T: fmt::Display> fmt::Display for Shown<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.1 {
            Some(value) => write!(f, "{}{}", self.0, shortened(&value.to_string(), 80)),
            None => Ok(()),
        }
    }
}
