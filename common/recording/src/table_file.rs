//! Tables as files of either form.

use crate::atomic::AtomicFile;
use crate::csv_form::Missing;
use crate::error::{Problem, RecordingError, Result};
use crate::table::{ColumnChoice, HeaderCheck, Table};
use crate::{csv_form, parquet_form};
use bytes::Bytes;
use flate2::read::MultiGzDecoder;
use std::path::Path;

/// The two forms of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// Text, comma separated, one header line.
    Csv,
    /// Apache Parquet.
    Parquet,
}

impl Form {
    /// The form that a file's ending names.
    pub fn of(path: &Path) -> Result<Self> {
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("csv") => Ok(Self::Csv),
            Some("gz") if is_packed_csv(path) => Ok(Self::Csv),
            Some("parquet") => Ok(Self::Parquet),
            _ => Err(RecordingError::new(path, Problem::Extension)),
        }
    }

    /// The ending without its dot.
    pub const fn ending(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Parquet => "parquet",
        }
    }
}

/// `NAME.csv.gz`, which is read and never written.
fn is_packed_csv(path: &Path) -> bool {
    path.to_string_lossy().ends_with(".csv.gz")
}

impl Table {
    /// Reads a file of either form with any columns of numbers.
    pub fn read(path: &Path) -> Result<Self> {
        Self::read_checked(path, &|_| Ok(()))
    }

    /// Reads a file of either form; `check` sees the header first and names what is wrong with it.
    pub fn read_checked(path: &Path, check: HeaderCheck<'_>) -> Result<Self> {
        Self::read_chosen(path, &all(check), Missing::AnyText)
    }

    /// Reads the columns of a file of either form that `choose` wants; it sees the header first and names what is wrong
    /// with it.
    pub(crate) fn read_chosen(path: &Path, choose: ColumnChoice<'_>, missing: Missing) -> Result<Self> {
        let file = |e| RecordingError::new(path, Problem::Io(e));
        match Form::of(path)? {
            Form::Csv => {
                let source = std::fs::File::open(path).map_err(file)?;
                match is_packed_csv(path) {
                    true => csv_form::read(MultiGzDecoder::new(source), path, choose, missing),
                    false => csv_form::read(source, path, choose, missing),
                }
            }
            Form::Parquet => parquet_form::read(std::fs::File::open(path).map_err(file)?, path, choose),
        }
    }

    /// Reads CSV text from memory or a pipe; `label` stands for the file in messages.
    pub fn read_csv(source: impl std::io::Read, label: &Path, check: HeaderCheck<'_>) -> Result<Self> {
        csv_form::read(source, label, &all(check), Missing::AnyText)
    }

    /// Reads a Parquet file from memory; `label` stands for the file in messages.
    pub fn read_parquet(bytes: Vec<u8>, label: &Path, check: HeaderCheck<'_>) -> Result<Self> {
        parquet_form::read(Bytes::from(bytes), label, &all(check))
    }

    /// Writes the table in the form that the ending names; the file appears whole or not at all.
    pub fn write(&self, path: &Path) -> Result<()> {
        let form = Form::of(path)?;
        if is_packed_csv(path) {
            return Err(RecordingError::new(path, Problem::Extension));
        }
        let mut file = AtomicFile::create(path)?;
        match form {
            Form::Csv => {
                let names: Vec<String> =
                    self.names.iter().chain(self.words.iter().map(|words| &words.name)).cloned().collect();
                csv_form::write_header(&mut file, &names)
                    .and_then(|()| csv_form::write_rows(&mut file, &self.columns, &self.words))
                    .map_err(|e| RecordingError::new(path, Problem::Io(e)))?;
                file.commit()
            }
            Form::Parquet => {
                let mut writer = parquet_form::Writer::new(file, &self.names, &self.words)?;
                writer.write_group(&self.columns, &self.words)?;
                writer.finish()?.commit()
            }
        }
    }
}

/// Every column of a header that passes `check`.
fn all(check: HeaderCheck<'_>) -> impl Fn(&[String]) -> std::result::Result<Vec<bool>, (String, Problem)> {
    move |names| check(names).map(|()| vec![true; names.len()])
}
