//! Recordings of wagons as files, read and written with checks. Columns only: no physics, no clock.
//!
//! * [`Recording`]: one run of one wagon, column by column; [`Row`] is one sample of it; [`RunWriter`] writes rows as they come.
//!   [`Recording::read_mended`] takes recordings as they are, with jitter, gaps and columns of their own, and says what it did.
//! * [`Mapping`]: columns of other names and units, of recordings and live sources alike.
//! * [`prepare`]: the same for files, one or a folder of them.
//! * [`BogieRecording`]: one run of a bogie rig, with torque, link force and pulses; [`BogieRow`] is one sample of it.
//! * [`MotorRecording`]: one run of a driven rig, with motor currents and voltages; [`MotorRow`] is one sample of it.
//! * [`Truth`]: what no sensor sees, beside a simulated run.
//! * [`Table`]: named columns of numbers in CSV or Parquet, for every other file.
//! * [`read_text`]: texts that people write, no longer than such are.
//! * [`runs_in`], [`RunFile`]: the runs of a folder, named `NAME.RAIL.csv` or `NAME.RAIL.parquet`.
//! * [`RecordingError`]: file, line or row, column, what is wrong and what is allowed.
//!
//! Files are written beside their place and renamed into it, so that a reader never sees half a file.

mod arrow_schema;
mod atomic;
mod bogie;
mod checks;
mod columns;
mod csv_form;
mod error;
mod instant;
mod mapped_table;
mod mapping;
mod mend;
mod motor;
mod parquet_cells;
mod parquet_form;
mod parquet_pages;
mod prepare;
mod recording;
mod rig;
mod run_name;
mod small_text;
mod survey;
mod table;
mod table_file;
mod truth;
mod writer;

pub use bogie::{BogieRecording, BogieRow};
pub use checks::Strictness;
pub use columns::{MAX_WHEELSETS, Quantity, suffix};
pub use error::{Place, Problem, RecordingError, Result};
pub use instant::instant_s;
pub use mapping::{Combine, Flag, Mapping, Rule, quantity_of, unit};
pub use mend::{Mended, Mending, Renamed, Rows};
pub use motor::{MotorRecording, MotorRow};
pub use prepare::{Prepared, prepare};
pub use recording::{Optional, Recording, Row};
pub use rig::{RIG_VALUES, RigColumn, RigRecording, RigRow};
pub use run_name::{RailClass, RunFile, runs_in};
pub use small_text::{read_bytes, read_text};
pub use survey::{FirstMinute, Guess, Surveyed, first_minute, proposal, survey};
pub use table::{HeaderCheck, Table, expect_columns};
pub use table_file::Form;
pub use truth::{Truth, TruthRow};
pub use writer::{RigRunWriter, RunWriter};
