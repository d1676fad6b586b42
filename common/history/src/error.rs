//! Why the history failed.

use crate::block::BlockError;
use rusqlite::ErrorCode;
use std::path::PathBuf;

/// Why the history failed.
#[derive(Debug, thiserror::Error)]
pub enum HistoryError {
    /// The database refused; the disk may be full or read-only.
    #[error("history {}: {source}", path.display())]
    Database {
        /// The database file.
        path: PathBuf,
        /// What SQLite says.
        source: rusqlite::Error,
    },
    /// Another process writes this database.
    #[error("history {}: another process writes it", path.display())]
    Taken {
        /// The database file.
        path: PathBuf,
    },
    /// The lock that keeps other writers away cannot be had.
    #[error("history {}: {source}", path.display())]
    Lock {
        /// The lock file.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The database was written by a newer program.
    #[error("history {}: written by a newer version (tables of version {found}, this program knows {known})", path.display())]
    Newer {
        /// The database file.
        path: PathBuf,
        /// Its version.
        found: i64,
        /// The newest version that this program knows.
        known: i64,
    },
    /// A database of something else, or one that lost its tables.
    #[error("history {}: not the history of a train (table `{table}` is missing)", path.display())]
    NoHistory {
        /// The database file.
        path: PathBuf,
        /// The table.
        table: String,
    },
    /// A block in the database is damaged.
    #[error("history {}: wagon {wagon}, block at {start_s}: {source}", path.display())]
    Block {
        /// The database file.
        path: PathBuf,
        /// Whose block.
        wagon: u32,
        /// Start of the block, Unix s.
        start_s: i64,
        /// What is wrong.
        source: BlockError,
    },
}

impl HistoryError {
    /// Whether the disk is full or read-only: history pauses, and everything live goes on.
    pub fn is_storage(&self) -> bool {
        match self {
            Self::Database { source, .. } => matches!(
                source.sqlite_error_code(),
                Some(
                    ErrorCode::DiskFull
                        | ErrorCode::ReadOnly
                        | ErrorCode::SystemIoFailure
                        | ErrorCode::CannotOpen
                )
            ),
            Self::Lock { .. } => true,
            _ => false,
        }
    }

    /// Whether it lies in the file: no database, none of a train, of a newer program or damaged.
    pub fn is_of_the_file(&self) -> bool {
        self.is_damage() || matches!(self, Self::NoHistory { .. } | Self::Newer { .. } | Self::Block { .. })
    }

    /// Whether the file is no database any more.
    pub(crate) fn is_damage(&self) -> bool {
        matches!(self, Self::Database { source, .. } if matches!(
            source.sqlite_error_code(),
            Some(ErrorCode::NotADatabase | ErrorCode::DatabaseCorrupt)
        ))
    }
}
