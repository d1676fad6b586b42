//! What can be wrong with a config file; every message names the file and, where there is one, line, key and what is
//! allowed.

use crate::vehicle::VehicleFileError;
use std::path::PathBuf;

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
    /// A vehicle file is wrong.
    #[error(transparent)]
    Vehicle(#[from] VehicleFileError),
    /// A scenario file is wrong.
    #[error(transparent)]
    Scenario(#[from] railgrip_simulation::ScenarioError),
}
