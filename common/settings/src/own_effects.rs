//! Files of own effects: `effects.toml` into the effects that the process knows.

use crate::place::in_words;
use crate::vehicle::{line_of, line_of_effect};
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
        line: line_of_wrong(&text, &source),
        source,
    })?;
    Ok(effects)
}

/// The line of the key that an error names, in its effect.
fn line_of_wrong(text: &str, error: &OwnEffectError) -> usize {
    error.place().map_or(1, |(id, key)| line_of_effect(text, id, key))
}
