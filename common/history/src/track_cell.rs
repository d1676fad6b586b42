//! Stretches of track and what is known of them: one row each, renewed in place. What a row holds is its owner's business.

use crate::query::Reader;
use crate::{HistoryError, Store};
use rusqlite::{Connection, params};
use std::collections::BTreeMap;

/// Changed cells by place; `None` for those that are forgotten.
pub(crate) type Cells = BTreeMap<i64, Option<Vec<u8>>>;

pub(crate) fn write(connection: &Connection, cells: &Cells) -> rusqlite::Result<()> {
    for (place, packed) in cells {
        match packed {
            Some(packed) => connection
                .prepare_cached("INSERT OR REPLACE INTO track_cell (place, packed) VALUES (?1, ?2)")?
                .execute(params![place, packed])?,
            None => connection.prepare_cached("DELETE FROM track_cell WHERE place = ?1")?.execute([place])?,
        };
    }
    Ok(())
}

impl Store {
    /// Takes in what is known of the cell at `place` now, or that it is to be forgotten; the next flush writes it.
    pub fn push_cell(&mut self, place: i64, packed: Option<Vec<u8>>) {
        self.waiting_cells().insert(place, packed);
    }
}

impl Reader {
    /// All cells with their places.
    ///
    /// # Errors
    /// The database refuses.
    pub fn cells(&self) -> Result<Vec<(i64, Vec<u8>)>, HistoryError> {
        let rows = || -> rusqlite::Result<Vec<(i64, Vec<u8>)>> {
            let mut select =
                self.connection().prepare_cached("SELECT place, packed FROM track_cell ORDER BY place")?;
            let rows = select.query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?;
            rows.collect()
        };
        rows().map_err(|source| self.fail(source))
    }
}
