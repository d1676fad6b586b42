//! What can be wrong with a model.

use std::path::PathBuf;

/// A model that cannot be made, read or written.
#[derive(Debug, thiserror::Error)]
pub enum ModelError {
    /// The file cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is no model, or one of another version.
    #[error("{place}: {problem}; allowed is a model that railgrip trained and saved, format {format}", format = crate::file::FORMAT)]
    Form {
        /// The file, or "built-in model".
        place: String,
        /// What is wrong.
        problem: String,
    },
    /// Its content is not what was written.
    #[error("{place}: the checksum does not fit, the file is damaged (found {found}, noted {noted})")]
    Checksum {
        /// The file, or "built-in model".
        place: String,
        /// Computed from the content.
        found: String,
        /// Written in the file.
        noted: String,
    },
    /// Too few clips to learn from.
    #[error("{clips} clips; allowed is {least} or more")]
    TooFew {
        /// Given.
        clips: usize,
        /// Needed.
        least: usize,
    },
}
