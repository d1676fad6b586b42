//! A run written row by row, for recorders that run for hours: memory stays bounded, and the file appears under its name when it is
//! finished.

use crate::atomic::AtomicFile;
use crate::columns::columns_of_run;
use crate::error::{Problem, RecordingError, Result};
use crate::recording::{Optional, Recording, Row};
use crate::rig::{RigRecording, RigRow, cells};
use crate::table_file::Form;
use crate::{csv_form, parquet_form};
use std::path::Path;

/// Rows that are held before they are written.
const GROUP_ROWS: usize = 65_536;

enum Sink {
    Csv(AtomicFile),
    Parquet(Box<parquet_form::Writer<AtomicFile>>),
}

impl Sink {
    /// A file with these columns; the ending of `path` names the form.
    fn create(path: &Path, names: &[String]) -> Result<Self> {
        let form = Form::of(path)?;
        let mut file = AtomicFile::create(path)?;
        Ok(match form {
            Form::Csv => {
                csv_form::write_header(&mut file, names)
                    .map_err(|e| RecordingError::new(path, Problem::Io(e)))?;
                Self::Csv(file)
            }
            Form::Parquet => Self::Parquet(Box::new(parquet_form::Writer::new(file, names, &[])?)),
        })
    }

    fn write(&mut self, columns: &[Vec<f64>]) -> Result<()> {
        match self {
            Self::Csv(file) => csv_form::write_rows(file, columns, &[])
                .map_err(|e| RecordingError::new(file.target(), Problem::Io(e))),
            Self::Parquet(writer) => writer.write_group(columns, &[]),
        }
    }

    fn commit(self) -> Result<()> {
        match self {
            Self::Csv(file) => file.commit(),
            Self::Parquet(writer) => writer.finish()?.commit(),
        }
    }
}

/// Writes rows to a file that appears when [`RunWriter::finish`] is called; dropped before, it leaves nothing.
pub struct RunWriter {
    sink: Sink,
    pending: Recording,
    rows: u64,
}

impl RunWriter {
    /// Starts a run; the ending of `path` names the form.
    pub fn create(path: &Path, wheelsets: usize, optional: Optional) -> Result<Self> {
        let names: Vec<String> = columns_of_run(wheelsets)
            .into_iter()
            .filter_map(|(quantity, _, name)| optional.has(quantity).then_some(name))
            .collect();
        let sink = Sink::create(path, &names)?;
        Ok(Self { sink, pending: Recording::empty("", None, wheelsets, optional), rows: 0 })
    }

    /// Adds a row.
    pub fn push(&mut self, row: &Row) -> Result<()> {
        self.pending.push(row);
        self.rows += 1;
        if self.pending.len() >= GROUP_ROWS { self.flush() } else { Ok(()) }
    }

    /// Rows so far.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    fn flush(&mut self) -> Result<()> {
        self.sink.write(&self.pending.take_columns())
    }

    /// Writes what is left and gives the file its name.
    pub fn finish(mut self) -> Result<()> {
        if !self.pending.is_empty() {
            self.flush()?;
        }
        self.sink.commit()
    }
}

/// The same for the rows of a rig.
pub struct RigRunWriter<R> {
    sink: Sink,
    pending: Vec<R>,
}

impl<R: RigRow> RigRunWriter<R> {
    /// Starts a run; the ending of `path` names the form.
    pub fn create(path: &Path) -> Result<Self> {
        let names = RigRecording::<R>::columns().map(str::to_owned);
        Ok(Self { sink: Sink::create(path, &names)?, pending: Vec::new() })
    }

    /// Adds a row.
    pub fn push(&mut self, row: &R) -> Result<()> {
        self.pending.push(*row);
        if self.pending.len() >= GROUP_ROWS { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<()> {
        self.sink.write(&cells(&std::mem::take(&mut self.pending)))
    }

    /// Writes what is left and gives the file its name.
    pub fn finish(mut self) -> Result<()> {
        if !self.pending.is_empty() {
            self.flush()?;
        }
        self.sink.commit()
    }
}
