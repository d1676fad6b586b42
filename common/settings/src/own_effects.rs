//! Files of own effects: `effects.toml` into the effects that the process knows.

use crate::place::in_words;
use crate::vehicle::line_of;
use railgrip_vehicle::effects::own::{self, OwnEffectError, OwnEffects};
use std::path::{Path, PathBuf};

/// Why a file of own effects was refused.
#[derive(Debug, thiserror::Error)]
pub enum OwnEffectsFileError {
    /// The file cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is not TOML of the expected form.
    #[error("{}:{line}: {message}", path.display())]
    Form {
        /// The file.
        path: PathBuf,
        /// Line, counted from 1.
        line: usize,
        /// Key and what is expected there.
        message: String,
    },
    /// An effect makes no sense.
    #[error("{}:{line}: {source}", path.display())]
    Effect {
        /// The file.
        path: PathBuf,
        /// Line of the effect's key, counted from 1.
        line: usize,
        /// Effect, key and what is wrong.
        source: OwnEffectError,
    },
}

/// Reads a file of own effects and makes them known to the process.
///
/// # Errors
/// A file that cannot be read, an unknown or missing key, an expression that names what does not exist, an id that is taken.
pub fn load(path: &Path) -> Result<OwnEffects, OwnEffectsFileError> {
    let text = railgrip_recording::read_text(path)
        .map_err(|source| OwnEffectsFileError::Read { path: path.to_owned(), source })?;
    let effects: OwnEffects = toml::from_str(&text).map_err(|error| OwnEffectsFileError::Form {
        path: path.to_owned(),
        line: error.span().map_or(1, |span| line_of(&text, span.start)),
        message: in_words(&error),
    })?;
    own::register(&effects).map_err(|source| OwnEffectsFileError::Effect {
        path: path.to_owned(),
        line: line_of_effect(&text, &source),
        source,
    })?;
    Ok(effects)
}

/// The line of the key that an error names, in its effect; that of the effect where the key is not found.
fn line_of_effect(text: &str, error: &OwnEffectError) -> usize {
    let Some((id, key)) = error.place() else { return 1 };
    let short = key.rsplit('.').next().unwrap_or(key);
    let is = |line: &str, name: &str| line.split('=').next().is_some_and(|found| found.trim() == name);
    let lines: Vec<&str> = text.lines().collect();
    let named = |line: &&str| is(line, "id") && line.contains(&format!("\"{id}\""));
    let at = lines.iter().position(named).unwrap_or(0);
    let end = (at + 1..lines.len()).find(|k| lines[*k].trim() == "[[effect]]").unwrap_or(lines.len());
    (at..end).find(|k| is(lines[*k], key) || is(lines[*k], short)).unwrap_or(at) + 1
}
