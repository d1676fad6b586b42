//! Recordings as they are into files that are fit for a diagnosis.

use crate::error::{Problem, RecordingError, Result};
use crate::mend::{Mended, Mending};
use crate::recording::Recording;
use crate::run_name::{RailClass, RunFile, runs_in};
use std::path::{Path, PathBuf};

/// What was made of one recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Prepared {
    /// The recording.
    pub from: PathBuf,
    /// The runs that came of it, each with its number of rows and its rate, Hz.
    pub runs: Vec<(PathBuf, usize, f64)>,
    /// What was done and assumed, in sentences.
    pub notes: Vec<String>,
}

/// Mends a recording, or each one of a folder, and writes what came of it into `folder` as `NAME.RAIL.csv`; parts of one that
/// was cut are `NAME_1.RAIL.csv` and so on. `rail` is the class of recordings whose names declare none.
///
/// # Errors
/// A recording that cannot be mended, see [`Recording::read_mended`]; a folder without recordings or that cannot be written,
/// a file that stands there already.
pub fn prepare(
    from: &Path,
    folder: &Path,
    mending: &Mending,
    rail: Option<RailClass>,
) -> Result<Vec<Prepared>> {
    let files = if from.is_dir() { runs_in(from)? } else { vec![RunFile::of(from)?] };
    let io = |e| RecordingError::new(folder, Problem::Io(e));
    std::fs::create_dir_all(folder).map_err(io)?;
    files
        .into_iter()
        .map(|file| {
            let Mended { parts, notes, .. } = Recording::read_mended(&file.path, mending)?;
            let several = parts.len() > 1;
            let write = |(number, part): (usize, &Recording)| {
                let path = folder.join(name(&file, several.then_some(number + 1), rail));
                if path.exists() {
                    let taken = std::io::Error::from(std::io::ErrorKind::AlreadyExists);
                    return Err(RecordingError::new(&path, Problem::Io(taken)));
                }
                part.write(&path)?;
                Ok((path, part.len(), part.sample_rate_hz()))
            };
            let runs = parts.iter().enumerate().map(write).collect::<Result<_>>()?;
            Ok(Prepared { from: file.path.clone(), runs, notes })
        })
        .collect()
}

/// Name of the file of a part.
fn name(file: &RunFile, part: Option<usize>, rail: Option<RailClass>) -> String {
    let bare = match file.rail {
        Some(rail) => file.name.strip_suffix(&format!(".{rail}")).unwrap_or(&file.name),
        None => &file.name,
    };
    let part = part.map_or(String::new(), |number| format!("_{number}"));
    let rail = file.rail.or(rail).map_or(String::new(), |rail| format!(".{rail}"));
    format!("{bare}{part}{rail}.csv")
}
