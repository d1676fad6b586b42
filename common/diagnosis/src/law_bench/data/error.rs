//! What can be wrong with a law-level case; every message names the file and what is allowed there.

use railgrip_recording::RecordingError;
use std::path::PathBuf;

/// Why a law-level case was refused. All of it is bad input.
#[derive(Debug, thiserror::Error)]
pub enum LawCaseError {
    /// A file cannot be read or written.
    #[error("{}: {source}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// `bench.toml` is not of the expected form.
    #[error("{}:{line}:{column}: {message}", file.display())]
    Form {
        /// The file.
        file: PathBuf,
        /// Line, counted from 1.
        line: usize,
        /// Column, counted from 1.
        column: usize,
        /// What is wrong, and what is expected.
        message: String,
    },
    /// A value of `bench.toml` is not allowed.
    #[error("{}:{line}: `{key}` is {value}, allowed is {allowed}", file.display())]
    Value {
        /// The file.
        file: PathBuf,
        /// Line of the value.
        line: usize,
        /// Dotted key.
        key: &'static str,
        /// What stands there.
        value: String,
        /// What may stand there.
        allowed: String,
    },
    /// A measured file is wrong, or a prediction file cannot be written.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// Too little to fit anything on.
    #[error("{}: {found} points in all files; at least {needed} are needed", folder.display())]
    TooFew {
        /// The folder.
        folder: PathBuf,
        /// Points found.
        found: usize,
        /// Points needed.
        needed: usize,
    },
    /// An id to leave out that is not in the library.
    #[error("--without {id}: no such candidate for this bench; allowed are {allowed}")]
    UnknownCandidate {
        /// The id given.
        id: String,
        /// Ids of the library.
        allowed: String,
    },
}
