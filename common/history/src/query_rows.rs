//! The reading side of what is kept row by row: events, and stretches of track.

use crate::HistoryError;
use crate::event::{Event, EventFilter, NumberedEvent};
use crate::query::Reader;
use crate::schema;
use rusqlite::params;

impl Reader {
    /// The latest events that the filter lets through, newest first.
    ///
    /// # Errors
    /// The database refuses.
    pub fn events(&self, filter: &EventFilter, limit: usize) -> Result<Vec<NumberedEvent>, HistoryError> {
        let rows = || -> rusqlite::Result<Vec<NumberedEvent>> {
            let mut select = self.connection().prepare_cached(
                "SELECT id, unix_ms, kind, wagon, wheelset, grade, cause, text FROM event
                 WHERE id < ?1 AND unix_ms >= ?2 AND unix_ms < ?3 AND (?4 IS NULL OR wagon = ?4)
                     AND (?5 IS NULL OR kind = ?5)
                 ORDER BY id DESC LIMIT ?6",
            )?;
            let values = params![
                filter.before_id.unwrap_or(i64::MAX),
                filter.from_ms.unwrap_or(i64::MIN),
                filter.to_ms.unwrap_or(i64::MAX),
                filter.wagon,
                filter.kind,
                limit as i64
            ];
            let rows = select.query_map(values, |row| {
                let event = Event {
                    unix_ms: row.get(1)?,
                    kind: row.get(2)?,
                    wagon: row.get(3)?,
                    wheelset: row.get(4)?,
                    grade: row.get(5)?,
                    cause: row.get(6)?,
                    text: row.get(7)?,
                };
                Ok(NumberedEvent { id: row.get(0)?, event })
            })?;
            rows.collect()
        };
        rows().map_err(|source| self.fail(source))
    }

    /// All cells with their places; none in a database that has just begun, or that a version before them wrote.
    ///
    /// # Errors
    /// The database refuses.
    pub fn cells(&self) -> Result<Vec<(i64, Vec<u8>)>, HistoryError> {
        let rows = || -> rusqlite::Result<Vec<(i64, Vec<u8>)>> {
            let version: i64 =
                self.connection().pragma_query_value(None, "user_version", |row| row.get(0))?;
            if version < schema::FIRST_WITH_CELLS {
                return Ok(Vec::new());
            }
            let mut select =
                self.connection().prepare_cached("SELECT place, packed FROM track_cell ORDER BY place")?;
            let rows = select.query_map([], |row| Ok((row.get(0)?, row.get(1)?)))?;
            rows.collect()
        };
        rows().map_err(|source| self.fail(source))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rusqlite::Connection;

    #[test]
    fn a_database_that_has_just_begun_has_no_cells_and_a_damaged_one_is_a_fault() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("history.db");
        // As a reader finds it while its writer begins, and as a version without cells left it.
        for version in 0..schema::FIRST_WITH_CELLS {
            let begun = Connection::open(&path).expect("a database");
            begun.pragma_update(None, "user_version", version).expect("a version");
            drop(begun);
            assert_eq!(Reader::open(&path).expect("a reader").cells().expect("no fault"), []);
        }
        let torn = Connection::open(&path).expect("a database");
        torn.pragma_update(None, "user_version", schema::FIRST_WITH_CELLS).expect("a version");
        drop(torn);
        assert!(Reader::open(&path).expect("a reader").cells().is_err(), "its table is gone");
        std::fs::write(&path, "no database at all, and longer than nothing").expect("written");
        assert!(Reader::open(&path).and_then(|reader| reader.cells()).is_err());
    }
}
