//! The tables, and what brings a database of an older version to this one.

use crate::{HistoryError, Keep};
use rusqlite::Connection;
use std::path::Path;

/// Version of the database's tables; older ones are migrated when opened.
pub const SCHEMA_VERSION: i64 = 4;
/// The first version that knows stretches of track.
pub(crate) const FIRST_WITH_CELLS: i64 = 3;

/// What brings a database from each version to the next.
const MIGRATIONS: [&str; SCHEMA_VERSION as usize] = [
    "CREATE TABLE column (place INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE) STRICT;
     CREATE TABLE block (
         tier INTEGER NOT NULL, wagon INTEGER NOT NULL, start_s INTEGER NOT NULL, packed BLOB NOT NULL,
         PRIMARY KEY (tier, wagon, start_s)
     ) STRICT, WITHOUT ROWID;",
    // One number as the key (see `key`), so that blocks written together are neighbours; and events.
    "CREATE TABLE packed_block (key INTEGER PRIMARY KEY, packed BLOB NOT NULL) STRICT;
     INSERT OR REPLACE INTO packed_block (key, packed)
         SELECT (tier << 56) + (max(start_s, 0) << 12) + wagon, packed FROM block WHERE wagon < 4096;
     DROP TABLE block;
     CREATE TABLE event (
         id INTEGER PRIMARY KEY AUTOINCREMENT, unix_ms INTEGER NOT NULL, kind TEXT NOT NULL, wagon INTEGER,
         wheelset INTEGER, grade TEXT, cause TEXT NOT NULL, text TEXT NOT NULL
     ) STRICT;
     CREATE INDEX event_time ON event (unix_ms);",
    "CREATE TABLE track_cell (place INTEGER PRIMARY KEY, packed BLOB NOT NULL) STRICT;",
    // What is remembered belongs to a vehicle, wherever it runs; places in the train have the numbers below.
    "CREATE TABLE vehicle (id INTEGER PRIMARY KEY, key TEXT NOT NULL UNIQUE, number TEXT NOT NULL) STRICT;",
];

/// Settings of a connection that writes.
pub(crate) fn prepare(connection: &Connection) -> rusqlite::Result<()> {
    connection.busy_timeout(std::time::Duration::from_secs(5))?;
    connection.execute_batch(
        "PRAGMA auto_vacuum = INCREMENTAL; PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL;
         PRAGMA wal_autocheckpoint = 1000; PRAGMA journal_size_limit = 8388608;",
    )
}

/// Brings the database to this version, each step in a transaction.
pub(crate) fn migrate(connection: &Connection, path: &Path) -> Result<(), HistoryError> {
    let fail = |source| HistoryError::Database { path: path.to_owned(), source };
    let version: i64 = connection.pragma_query_value(None, "user_version", |row| row.get(0)).map_err(fail)?;
    let from = usize::try_from(version).unwrap_or(usize::MAX);
    let Some(steps) = MIGRATIONS.get(from..) else {
        return Err(HistoryError::Newer { path: path.to_owned(), found: version, known: SCHEMA_VERSION });
    };
    for (offset, step) in steps.iter().enumerate() {
        let to = from + offset + 1;
        connection
            .execute_batch(&format!("BEGIN IMMEDIATE; {step}; PRAGMA user_version = {to}; COMMIT"))
            .map_err(fail)?;
    }
    Ok(())
}

/// A column that older versions of the program knew by another name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FormerName {
    /// Its name then.
    pub then: String,
    /// Its name now.
    pub now: String,
}

/// Gives columns of older versions the names of today; one that is there under both names stays as it is.
pub(crate) fn rename_columns(connection: &Connection, former: &[FormerName]) -> rusqlite::Result<()> {
    let mut rename = connection.prepare("UPDATE OR IGNORE column SET name = ?2 WHERE name = ?1")?;
    connection.execute_batch("BEGIN")?;
    for FormerName { then, now } in former {
        rename.execute([then, now])?;
    }
    connection.execute_batch("COMMIT")
}

/// Gives each column its place, new ones behind those that are there. Also says what is kept of each place.
pub(crate) fn register_columns(
    connection: &Connection,
    columns: &[(&str, Keep)],
) -> rusqlite::Result<(Vec<usize>, Vec<Keep>)> {
    let known: i64 = connection.query_row("SELECT count(*) FROM column", [], |row| row.get(0))?;
    let mut insert = connection.prepare(
        "INSERT OR IGNORE INTO column (place, name) SELECT coalesce(max(place) + 1, 0), ?1 FROM column",
    )?;
    let mut select = connection.prepare("SELECT place FROM column WHERE name = ?1")?;
    let mut places = Vec::with_capacity(columns.len());
    // One transaction: a start writes one page once, not once a column.
    connection.execute_batch("BEGIN")?;
    for (name, _) in columns {
        insert.execute([name])?;
        places.push(select.query_row([name], |row| row.get::<_, u32>(0))? as usize);
    }
    connection.execute_batch("COMMIT")?;
    let width = places.iter().max().map_or(0, |last| last + 1).max(known.max(0) as usize);
    let mut keep = vec![Keep::Extremes; width];
    for (&place, &(_, kept)) in places.iter().zip(columns) {
        keep[place] = kept;
    }
    Ok((places, keep))
}
