//! Stored indicators as one table, for pandas, DuckDB, spreadsheets: CSV or Parquet, one row a wagon and step.
//!
//! Columns: `time` (begin of the step, UTC), `wagon`, `samples`, then for each indicator its mean under its own name, its
//! extremes as `NAME_min` and `NAME_max`, and where an interval is remembered its ends as `NAME_low` and `NAME_high`. Dots
//! in names become `_`, so that no query language asks for quotes: `wheelset_1.slides` is `wheelset_1_slides`. Steps
//! without samples have no row; what was not known then is empty (CSV) or null (Parquet).
//!
//! Rows are written as they are read, so that an export of any length takes the same memory, and in many short reads, so
//! that it never holds up the writer of the history.

mod csv;
mod parquet;
pub(crate) mod route;
mod table;
pub(crate) mod turn;
mod write;

pub use table::{ExportError, Form, Wanted};
pub use write::write;
