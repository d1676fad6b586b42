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
/// a file that stands there already. Nothing is written before all of them were found good.
pub fn prepare(
    from: &Path,
    folder: &Path,
    mending: &Mending,
    rail: Option<RailClass>,
) -> Result<Vec<Prepared>> {
    let files = if from.is_dir() { runs_in(from)? } else { vec![RunFile::of(from)?] };
    let io = |e| RecordingError::new(folder, Problem::Io(e));
    let path_of = |file: &RunFile, parts: usize, number: usize| {
        folder.join(name(file, (parts > 1).then_some(number + 1), rail))
    };
    // Read twice: all of them at once may be more than the memory holds.
    let several = files.len() > 1;
    for file in files.iter().filter(|_| several) {
        let parts = Recording::read_mended(&file.path, mending)?.parts.len();
        (0..parts).try_for_each(|number| free(&path_of(file, parts, number)))?;
    }
    std::fs::create_dir_all(folder).map_err(io)?;
    let one = |file: RunFile| {
        let Mended { parts, notes, .. } = Recording::read_mended(&file.path, mending)?;
        let paths: Vec<PathBuf> =
            (0..parts.len()).map(|number| path_of(&file, parts.len(), number)).collect();
        paths.iter().try_for_each(|path| free(path))?;
        let write = |(path, part): (PathBuf, &Recording)| {
            part.write(&path)?;
            Ok((path, part.len(), part.sample_rate_hz()))
        };
        let runs = paths.into_iter().zip(&parts).map(write).collect::<Result<_>>()?;
        Ok(Prepared { from: file.path.clone(), runs, notes })
    };
    files.into_iter().map(one).collect()
}

/// Fails where a file stands.
fn free(path: &Path) -> Result<()> {
    match path.exists() {
        true => Err(RecordingError::new(path, Problem::Taken)),
        false => Ok(()),
    }
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
