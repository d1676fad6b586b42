//! Files of the acoustics tools: models and recordings.

use std::path::{Path, PathBuf};

use railgrip_classifier::Model;

use crate::CliError;

/// The model of a file, or the one that is part of the program. A file that is missing or damaged is bad input.
pub(super) fn model(file: Option<&Path>) -> Result<Model, CliError> {
    match file {
        Some(file) => Model::load(file).map_err(|error| {
            CliError::bad_input(format!(
                "{error}; `railgrip acoustics train --out {}` makes a new one, without --model the built-in one is used",
                file.display()
            ))
        }),
        None => Model::built_in().map_err(CliError::failed),
    }
}

/// WAV files of a folder, or the file itself, in the order of their names.
pub(super) fn wav_files(path: &Path) -> Result<Vec<PathBuf>, CliError> {
    if !path.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let entries = std::fs::read_dir(path)
        .map_err(|error| CliError::bad_input(format!("{}: {error}", path.display())))?;
    let is_wav = |path: &PathBuf| path.extension().is_some_and(|end| end.eq_ignore_ascii_case("wav"));
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(is_wav).collect();
    files.sort();
    if files.is_empty() {
        return Err(CliError::bad_input(format!("{}: no WAV files in it", path.display())));
    }
    Ok(files)
}
