//! What can be wrong with the files that access rests on.

use std::path::PathBuf;

/// Why access cannot be set up, or a token file not be changed.
#[derive(Debug, thiserror::Error)]
pub enum AccessError {
    /// A file cannot be read or written.
    #[error("{}: {source}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A PEM file does not hold what it should.
    #[error("{}: {problem}", file.display())]
    Pem {
        /// The file.
        file: PathBuf,
        /// What is wrong, and what is expected.
        problem: String,
    },
    /// A token file is wrong.
    #[error("{}: {problem}", file.display())]
    Tokens {
        /// The file.
        file: PathBuf,
        /// Line or token, and what is allowed.
        problem: String,
    },
    /// Nobody could come in.
    #[error(
        "{}: holds no token that is valid, so nobody could come in; make one: railgrip token add NAME --role read|acknowledge|admin",
        file.display()
    )]
    NoToken {
        /// The file.
        file: PathBuf,
    },
}
