//! Under which number a wagon's history is kept: the place in the train of a wagon that nobody has named, and a number of its own
//! for each vehicle that has one, wherever it runs.

use crate::{HistoryError, Reader, Store, key};
use rusqlite::{OptionalExtension, params};

/// Numbers from here on belong to vehicles; those below are places in a train.
pub const FIRST_VEHICLE: u32 = 256;

/// A vehicle with a history of its own.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Vehicle {
    /// Under which its history is kept.
    pub id: u32,
    /// Its number, letters and digits alone.
    pub key: String,
    /// Its number as it is written.
    pub number: String,
}

impl Store {
    /// Under which the history of a vehicle is kept; a new vehicle gets the next number. `None` once all are given away.
    ///
    /// # Errors
    /// The database refuses.
    pub fn vehicle(&self, vehicle: &str, number: &str) -> Result<Option<u32>, HistoryError> {
        let run = || -> rusqlite::Result<Option<u32>> {
            let known = "SELECT id FROM vehicle WHERE key = ?1";
            let find = || self.connection().query_row(known, [vehicle], |row| row.get(0)).optional();
            if let Some(id) = find()? {
                return Ok(Some(id));
            }
            self.connection().execute(
                "INSERT INTO vehicle (id, key, number)
                 SELECT coalesce(max(id), ?3 - 1) + 1, ?1, ?2 FROM vehicle HAVING coalesce(max(id), 0) < ?4 - 1",
                params![vehicle, number, FIRST_VEHICLE, key::MOST_WAGONS],
            )?;
            find()
        };
        run().map_err(|source| self.fail(source))
    }
}

impl Reader {
    /// All vehicles that have a history of their own; none in a database of an older version.
    ///
    /// # Errors
    /// The database refuses.
    pub fn vehicles(&self) -> Result<Vec<Vehicle>, HistoryError> {
        let run = || -> rusqlite::Result<Vec<Vehicle>> {
            let there = "SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name = 'vehicle'";
            if self.connection().query_row(there, [], |row| row.get::<_, i64>(0))? == 0 {
                return Ok(Vec::new());
            }
            let mut select = self.connection().prepare("SELECT id, key, number FROM vehicle ORDER BY id")?;
            let vehicle = |row: &rusqlite::Row<'_>| {
                Ok(Vehicle { id: row.get(0)?, key: row.get(1)?, number: row.get(2)? })
            };
            select.query_map([], vehicle)?.collect()
        };
        run().map_err(|source| self.fail(source))
    }
}
