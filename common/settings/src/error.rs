//! What can be wrong with a config file; every message names the file and, where there is one, line, key and what is
//! allowed.

use std::path::PathBuf;

impl SettingsError {
    /// The line of the config that is to blame, where it is one.
    #[must_use]
    pub const fn line(&self) -> Option<usize> {
        match self {
            Self::Form { line, .. } | Self::Value { line, .. } | Self::Named { line, .. } => Some(*line),
            Self::Read { .. } | Self::Option { .. } => None,
        }
    }
}

/// Why the settings were refused.
#[derive(Debug, thiserror::Error)]
pub enum SettingsError {
    /// The file cannot be read.
    #[error("{}: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is not TOML of the expected form, for example an unknown key.
    #[error("{}:{line}:{column}: {message}", file.display())]
    Form {
        /// The file.
        file: PathBuf,
        /// Line, counted from 1.
        line: usize,
        /// Column, counted from 1.
        column: usize,
        /// What is wrong, and what is expected there.
        message: String,
    },
    /// A value is not allowed.
    #[error("{}:{line}: `{key}` is {value}, allowed is {allowed}", file.display())]
    Value {
        /// The file.
        file: PathBuf,
        /// Line of the key, or of its table where the key is absent; counted from 1.
        line: usize,
        /// Dotted key.
        key: String,
        /// What stands there.
        value: String,
        /// What may stand there.
        allowed: String,
    },
    /// A file that a key names is missing or wrong.
    #[error("{}:{line}: `{key}` names what cannot be used: {problem}", file.display())]
    Named {
        /// The file.
        file: PathBuf,
        /// Line of the key, or of its table where the key is absent; counted from 1.
        line: usize,
        /// Dotted key.
        key: String,
        /// What is wrong, with the name of the file that is.
        problem: String,
    },
    /// A value that was given on the command line is not allowed.
    #[error("{option} {value}: {problem}")]
    Option {
        /// The option.
        option: &'static str,
        /// What was given.
        value: String,
        /// What is wrong with it.
        problem: String,
    },
}
