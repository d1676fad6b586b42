//! What can be wrong with a scenario.

use std::path::PathBuf;

/// Why a scenario was refused; the message names file, line, key and what is allowed.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// The file cannot be read.
    #[error("{}: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Neither a built-in scenario nor a file.
    #[error("`{name}` is neither a file nor one of the built-in scenarios {built_in}")]
    Unknown {
        /// What was asked for.
        name: String,
        /// The names there are.
        built_in: String,
    },
    /// The file is not TOML of the expected form, for example an unknown key.
    #[error("{}:{line}: {message}", file.display())]
    Form {
        /// The file.
        file: PathBuf,
        /// Line, counted from 1.
        line: usize,
        /// What is wrong, and what is expected there.
        message: String,
    },
    /// A value is not allowed.
    #[error("{}:{line}: `{key}` is {value}, allowed is {allowed}", file.display())]
    Value {
        /// The file.
        file: PathBuf,
        /// Line of the key or of its table, counted from 1.
        line: usize,
        /// Dotted key; tables of a list are counted from 1.
        key: String,
        /// What stands there.
        value: String,
        /// What may stand there.
        allowed: String,
    },
    /// Vehicle, sample rate or number of wagons do not fit the scenario.
    #[error("{0}")]
    Train(String),
    /// A vehicle's effects cannot be built.
    #[error(transparent)]
    Model(#[from] railgrip_vehicle::ModelError),
}
