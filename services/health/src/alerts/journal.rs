//! Alerts on the disk, and the outbox of what is yet to be delivered, in one SQLite database.
//!
//! An alert and the letters about it are written in one transaction, synchronously: after a power cut there is either
//! neither, or both. A letter leaves the outbox only when its receiver has confirmed it; it may therefore arrive twice,
//! and carries a key by which the receiver can tell.

use super::model::{Alert, Change};
use crate::api::grade::Grade;
use crate::time::rfc3339;
use rusqlite::{Connection, OptionalExtension, params};
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

/// Something to be delivered.
#[derive(Debug, Clone)]
pub struct Letter {
    /// The alert as it was then.
    pub alert: Alert,
    /// What happened to it.
    pub change: Change,
    /// When, Unix ns.
    pub at_unix_ns: i64,
}

/// A receiver of letters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Target {
    /// Its name in the outbox.
    pub name: String,
    /// True if it only wants to hear of what needs action.
    pub act_only: bool,
}

/// A letter in the outbox.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Waiting {
    /// Its place.
    pub id: i64,
    /// The alert's number.
    pub alert: u64,
    /// The same for the same letter, however often it is sent.
    pub key: String,
    /// JSON.
    pub body: String,
    /// How often the receiver has refused it for good.
    pub refused: u32,
}

/// One connection to the database.
#[derive(Debug)]
pub struct Journal {
    connection: Connection,
    path: PathBuf,
    train: String,
    installation: String,
    targets: Vec<Target>,
    most_waiting: u32,
}

impl Journal {
    /// Opens or creates the database.
    ///
    /// # Errors
    /// A folder or database that cannot be used.
    pub fn open(
        path: &Path,
        train: &str,
        targets: Vec<Target>,
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
        let installation = installation(&connection).map_err(fail)?;
        let (path, train) = (path.to_owned(), train.to_owned());
        Ok(Self { connection, path, train, installation, targets, most_waiting })
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

    /// Keeps alerts, forgets others, and puts letters into the outbox: all or nothing.
    ///
    /// # Errors
    /// The database refuses; nothing has changed then.
    pub fn save(&mut self, kept: &[&Alert], gone: &[u64], letters: &[Letter]) -> Result<(), JournalError> {
        let letters: Vec<(String, i64, String, String, i64)> =
            letters.iter().flat_map(|letter| self.addressed(letter)).collect();
        let most = self.most_waiting;
        let targets: Vec<&str> = self.targets.iter().map(|target| target.name.as_str()).collect();
        let write = || -> rusqlite::Result<()> {
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
            for (target, alert, key, body, unix_s) in &letters {
                transaction.execute(
                    "INSERT INTO outbox (target, alert, key, body, written_unix_s) VALUES (?1, ?2, ?3, ?4, ?5)",
                    params![target, alert, key, body, unix_s],
                )?;
            }
            for target in targets {
                let dropped = transaction.execute(
                    "DELETE FROM outbox WHERE target = ?1 AND id <= (
                         SELECT id FROM outbox WHERE target = ?1 ORDER BY id DESC LIMIT 1 OFFSET ?2)",
                    params![target, most],
                )?;
                if dropped > 0 {
                    tracing::warn!(target, dropped, "the outbox is full: its oldest letters are lost");
                    add_to_fact(&transaction, &format!("dropped:{target}"), dropped)?;
                }
            }
            transaction.commit()
        };
        write().map_err(|source| JournalError::Database { path: self.path.clone(), source })
    }

    /// One letter a target that wants it.
    fn addressed(&self, letter: &Letter) -> Vec<(String, i64, String, String, i64)> {
        let alert = &letter.alert;
        let key = format!("{}-{}-{}", self.installation, alert.id, alert.changes);
        let body = serde_json::json!({
            "key": key,
            "train": self.train,
            "change": letter.change,
            "at": rfc3339(letter.at_unix_ns),
            "alert": alert,
        });
        let unix_s = letter.at_unix_ns.div_euclid(1_000_000_000);
        let wants = |target: &&Target| !target.act_only || alert.grade == Grade::Act;
        let of =
            |target: &Target| (target.name.clone(), alert.id as i64, key.clone(), body.to_string(), unix_s);
        self.targets.iter().filter(wants).map(of).collect()
    }

    /// The oldest letter for a target.
    ///
    /// # Errors
    /// The database refuses.
    pub fn next(&self, target: &str) -> Result<Option<Waiting>, JournalError> {
        let read = || {
            self.connection
                .prepare_cached(
                    "SELECT id, alert, key, body, refused FROM outbox WHERE target = ?1 ORDER BY id LIMIT 1",
                )?
                .query_row([target], |row| {
                    Ok(Waiting {
                        id: row.get(0)?,
                        alert: row.get::<_, i64>(1)?.unsigned_abs(),
                        key: row.get(2)?,
                        body: row.get(3)?,
                        refused: row.get(4)?,
                    })
                })
                .optional()
        };
        read().map_err(|source| self.failed(source))
    }

    /// Its receiver has confirmed a letter, or will never take it.
    ///
    /// # Errors
    /// The database refuses.
    pub fn done(&self, target: &str, id: i64, delivered: bool) -> Result<(), JournalError> {
        let fact = format!("{}:{target}", if delivered { "delivered" } else { "refused" });
        let write = || -> rusqlite::Result<()> {
            let transaction = self.connection.unchecked_transaction()?;
            transaction.execute("DELETE FROM outbox WHERE id = ?1", [id])?;
            add_to_fact(&transaction, &fact, 1)?;
            transaction.commit()
        };
        write().map_err(|source| self.failed(source))
    }

    /// Its receiver has said that it will not take a letter.
    ///
    /// # Errors
    /// The database refuses.
    pub fn refused(&self, id: i64) -> Result<(), JournalError> {
        self.connection
            .execute("UPDATE outbox SET refused = refused + 1 WHERE id = ?1", [id])
            .map(|_| ())
            .map_err(|source| self.failed(source))
    }

    /// Letters that wait for a target, and those ever delivered, refused and dropped.
    ///
    /// # Errors
    /// The database refuses.
    pub fn counts(&self, target: &str) -> Result<[u64; 4], JournalError> {
        let read = || -> rusqlite::Result<[u64; 4]> {
            let number = |row: &rusqlite::Row<'_>| row.get::<_, i64>(0).map(i64::unsigned_abs);
            let count = "SELECT count(*) FROM outbox WHERE target = ?1";
            let waiting = self.connection.query_row(count, [target], number)?;
            let fact = |name: &str| {
                let of = "SELECT CAST(value AS INTEGER) FROM fact WHERE name = ?1";
                let found = self.connection.query_row(of, [format!("{name}:{target}")], number).optional();
                found.map(Option::unwrap_or_default)
            };
            Ok([waiting, fact("delivered")?, fact("refused")?, fact("dropped")?])
        };
        read().map_err(|source| self.failed(source))
    }

    fn failed(&self, source: rusqlite::Error) -> JournalError {
        JournalError::Database { path: self.path.clone(), source }
    }
}

fn add_to_fact(connection: &Connection, name: &str, count: usize) -> rusqlite::Result<()> {
    connection.execute(
        "INSERT INTO fact (name, value) VALUES (?1, ?2)
         ON CONFLICT (name) DO UPDATE SET value = CAST(value AS INTEGER) + ?2",
        params![name, count.to_string()],
    )?;
    Ok(())
}

/// A name of this database that no other has, made when it is created.
fn installation(connection: &Connection) -> rusqlite::Result<String> {
    connection.execute(
        "INSERT OR IGNORE INTO fact (name, value) VALUES ('installation', lower(hex(randomblob(8))))",
        [],
    )?;
    connection.query_row("SELECT value FROM fact WHERE name = 'installation'", [], |row| row.get(0))
}
