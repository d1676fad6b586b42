//! Stretches of track and what is known of them: one row each, renewed in place. What a row holds is its owner's business.

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
