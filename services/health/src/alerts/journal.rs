//! Alerts on the disk, beside the notifications about them, in one SQLite database.
//!
//! An alert and the notifications about it are written in one transaction, synchronously: after a power cut there is either
//! neither, or both.

use super::model::Alert;
use super::moved::Numbers;
use super::nflog::{self, Envelope, Notification, Queued, Receiver};
use rusqlite::{Connection, ErrorCode, OptionalExtension, params};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Layout of the tables.
const VERSION: i64 = 1;

const TABLES: &str = "
    CREATE TABLE alert (id INTEGER PRIMARY KEY, body TEXT NOT NULL) STRICT;
    CREATE TABLE outbox (
        id INTEGER PRIMARY KEY AUTOINCREMENT, target TEXT NOT NULL, alert INTEGER NOT NULL, key TEXT NOT NULL,
        body TEXT NOT NULL, written_unix_s INTEGER NOT NULL, refused INTEGER NOT NULL DEFAULT 0
    ) STRICT;
    CREATE INDEX outbox_of_target ON outbox (target, id);
    CREATE TABLE fact (name TEXT PRIMARY KEY, value TEXT NOT NULL) STRICT, WITHOUT ROWID;
";

/// Why the journal failed.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// The folder cannot be made.
    #[error("{}: {source}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The database refuses.
    #[error("alerts {}: {source}", path.display())]
    Database {
        /// The database file.
        path: PathBuf,
        /// What SQLite says.
        source: rusqlite::Error,
    },
    /// It was written by a newer program.
    #[error("alerts {}: written by a newer version (tables of version {found}, this program knows {VERSION})", path.display())]
    Newer {
        /// The database file.
        path: PathBuf,
        /// Its version.
        found: i64,
    },
}

impl JournalError {
    /// The file is no database, or not one of ours: trying again would change nothing.
    fn is_damage(&self) -> bool {
        let Self::Database { source, .. } = self else { return false };
        matches!(source.sqlite_error_code(), Some(ErrorCode::NotADatabase | ErrorCode::DatabaseCorrupt))
    }
}

/// Renames a damaged database and what belongs to it; gives its new name.
fn set_aside(path: &Path) -> std::io::Result<PathBuf> {
    let with = |path: &Path, suffix: &str| PathBuf::from(format!("{}{suffix}", path.display()));
    let free = |number: &u32| !with(path, &format!(".damaged-{number}")).exists();
    let number = (1..).find(free).unwrap_or(u32::MAX);
    let aside = with(path, &format!(".damaged-{number}"));
    std::fs::rename(path, &aside)?;
    for suffix in ["-wal", "-shm"] {
        // They may not exist, and without their database they mean nothing to the new one.
        let _ = std::fs::rename(with(path, suffix), with(&aside, suffix));
    }
    Ok(aside)
}

/// One connection to the database.
#[derive(Debug)]
pub struct Journal {
    connection: Connection,
    path: PathBuf,
    train: String,
    installation: String,
    receivers: Vec<Receiver>,
    most_waiting: u32,
}

impl Journal {
    /// Opens or creates the database. A file that is not a database any more is set aside under another name, so that
    /// a train with a damaged memory of its alerts still tells new ones.
    ///
    /// # Errors
    /// A folder or database that cannot be used.
    pub fn open(
        path: &Path,
        train: &str,
        receivers: Vec<Receiver>,
        most_waiting: u32,
    ) -> Result<Self, JournalError> {
        match Self::open_once(path, train, receivers.clone(), most_waiting) {
            Err(error) if error.is_damage() => {
                let aside = set_aside(path).map_err(|_| error)?;
                tracing::error!(file = %aside.display(), "the alerts were damaged and have been set aside");
                Self::open_once(path, train, receivers, most_waiting)
            }
            opened => opened,
        }
    }

    fn open_once(
        path: &Path,
        train: &str,
        receivers: Vec<Receiver>,
        most_waiting: u32,
    ) -> Result<Self, JournalError> {
        if let Some(folder) = path.parent() {
            std::fs::create_dir_all(folder)
                .map_err(|source| JournalError::Folder { path: folder.to_owned(), source })?;
        }
        let fail = |source| JournalError::Database { path: path.to_owned(), source };
        let connection = Connection::open(path).map_err(fail)?;
        connection.busy_timeout(Duration::from_secs(5)).map_err(fail)?;
        connection
            .execute_batch(
                "PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA journal_size_limit = 1048576;",
            )
            .map_err(fail)?;
        let found: i64 =
            connection.pragma_query_value(None, "user_version", |row| row.get(0)).map_err(fail)?;
        match found {
            0 => connection
                .execute_batch(&format!("BEGIN IMMEDIATE; {TABLES} PRAGMA user_version = {VERSION}; COMMIT"))
                .map_err(fail)?,
            VERSION => {}
            _ => return Err(JournalError::Newer { path: path.to_owned(), found }),
        }
        // A file that is torn in the middle has a sound first page.
        let sound: String =
            connection.query_row("PRAGMA quick_check(1)", [], |row| row.get(0)).map_err(fail)?;
        if sound != "ok" {
            let code = rusqlite::ffi::Error::new(rusqlite::ffi::SQLITE_CORRUPT);
            return Err(fail(rusqlite::Error::SqliteFailure(code, Some(sound))));
        }
        let installation = installation(&connection).map_err(fail)?;
        let (path, train) = (path.to_owned(), train.to_owned());
        Ok(Self { connection, path, train, installation, receivers, most_waiting })
    }

    /// Addresses what comes to these receivers from now on, of whom each may have so many waiting.
    pub fn address(&mut self, receivers: Vec<Receiver>, most_waiting: u32) {
        (self.receivers, self.most_waiting) = (receivers, most_waiting);
    }

    /// All alerts that are kept; one that cannot be read (of another version) is left out.
    ///
    /// # Errors
    /// The database refuses.
    pub fn alerts(&self) -> Result<Vec<Alert>, JournalError> {
        let read = || -> rusqlite::Result<Vec<String>> {
            let mut select = self.connection.prepare("SELECT body FROM alert ORDER BY id")?;
            select.query_map([], |row| row.get(0))?.collect()
        };
        let bodies = read().map_err(|source| self.failed(source))?;
        let parse = |body: String| match serde_json::from_str(&body) {
            Ok(alert) => Some(alert),
            Err(error) => {
                tracing::warn!(%error, "an alert of another version is left out");
                None
            }
        };
        Ok(bodies.into_iter().filter_map(parse).collect())
    }

    /// Keeps alerts, forgets others, and puts notifications into the outbox: all or nothing.
    ///
    /// # Errors
    /// The database refuses; nothing has changed then.
    pub fn save(
        &mut self,
        kept: &[&Alert],
        gone: &[u64],
        notifications: &[Notification],
    ) -> Result<(), JournalError> {
        let envelope = Envelope { installation: &self.installation, train: &self.train };
        let (receivers, most) = (&self.receivers, self.most_waiting);
        let mut write = || -> rusqlite::Result<()> {
            let transaction = self.connection.transaction()?;
            for alert in kept {
                let body = serde_json::to_string(alert).unwrap_or_default();
                transaction.execute(
                    "INSERT OR REPLACE INTO alert (id, body) VALUES (?1, ?2)",
                    params![alert.id as i64, body],
                )?;
            }
            for id in gone {
                transaction.execute("DELETE FROM alert WHERE id = ?1", [*id as i64])?;
            }
            nflog::enqueue(&transaction, &envelope, notifications, receivers, most)?;
            transaction.commit()
        };
        write().map_err(|source| JournalError::Database { path: self.path.clone(), source })
    }

    /// The vehicle numbers of the train when the alerts were kept; `None` where no version has written them yet.
    ///
    /// # Errors
    /// The database refuses.
    pub fn consist(&self) -> Result<Option<Numbers>, JournalError> {
        let select = "SELECT value FROM fact WHERE name = 'consist'";
        let text: Option<String> = self
            .connection
            .query_row(select, [], |row| row.get(0))
            .optional()
            .map_err(|source| self.failed(source))?;
        Ok(text.and_then(|text| serde_json::from_str(&text).ok()))
    }

    /// Keeps the vehicle numbers of the train.
    ///
    /// # Errors
    /// The database refuses.
    pub fn set_consist(&self, numbers: &Numbers) -> Result<(), JournalError> {
        let text = serde_json::to_string(numbers).unwrap_or_default();
        let insert = "INSERT OR REPLACE INTO fact (name, value) VALUES ('consist', ?1)";
        self.connection.execute(insert, [text]).map(|_| ()).map_err(|source| self.failed(source))
    }

    /// The oldest notification for a receiver.
    ///
    /// # Errors
    /// The database refuses.
    pub fn next(&self, receiver: &str) -> Result<Option<Queued>, JournalError> {
        nflog::next(&self.connection, receiver).map_err(|source| self.failed(source))
    }

    /// Its receiver has confirmed a notification, or will never take it.
    ///
    /// # Errors
    /// The database refuses.
    pub fn done(&self, receiver: &str, id: i64, confirmed: bool) -> Result<(), JournalError> {
        nflog::done(&self.connection, receiver, id, confirmed).map_err(|source| self.failed(source))
    }

    /// Its receiver has said that it will not take a notification.
    ///
    /// # Errors
    /// The database refuses.
    pub fn refused(&self, id: i64) -> Result<(), JournalError> {
        nflog::refused(&self.connection, id).map_err(|source| self.failed(source))
    }

    /// Notifications that wait for a receiver, and those ever delivered, refused and dropped.
    ///
    /// # Errors
    /// The database refuses.
    pub fn counts(&self, receiver: &str) -> Result<[u64; 4], JournalError> {
        nflog::counts(&self.connection, receiver).map_err(|source| self.failed(source))
    }

    fn failed(&self, source: rusqlite::Error) -> JournalError {
        JournalError::Database { path: self.path.clone(), source }
    }
}

/// A name of this database that no other has, made when it is created.
fn installation(connection: &Connection) -> rusqlite::Result<String> {
    connection.execute(
        "INSERT OR IGNORE INTO fact (name, value) VALUES ('installation', lower(hex(randomblob(8))))",
        [],
    )?;
    connection.query_row("SELECT value FROM fact WHERE name = 'installation'", [], |row| row.get(0))
}
