//! The reading side of the history.

use crate::block::{Buckets, Cell, decode};
use crate::store::HistoryError;
use crate::{Bucket, Tier};
use rusqlite::{Connection, OpenFlags, params};
use std::path::{Path, PathBuf};

/// What one step of a query holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Start of the step, Unix s.
    pub unix_s: i64,
    /// Samples that went in.
    pub samples: u32,
    /// Mean, smallest and largest value of each column asked for.
    pub cells: Vec<Cell>,
}

/// A reader; it sees what the writer has flushed, and any number may read at once.
#[derive(Debug)]
pub struct Reader {
    connection: Connection,
    path: PathBuf,
}

impl Reader {
    /// Opens the database at `path` for reading.
    ///
    /// # Errors
    /// There is no such database.
    pub fn open(path: &Path) -> Result<Self, HistoryError> {
        let fail = |source| HistoryError::Database { path: path.to_owned(), source };
        let connection = Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_ONLY).map_err(fail)?;
        connection.busy_timeout(std::time::Duration::from_secs(5)).map_err(fail)?;
        Ok(Self { connection, path: path.to_owned() })
    }

    /// The finest tier worth reading for this step.
    pub fn tier(step_s: i64) -> Tier {
        Tier::ALL.into_iter().rev().find(|tier| tier.bucket_s() <= step_s).unwrap_or(Tier::Second)
    }

    /// The values of `columns` of one wagon from `from_s` (inclusive) to `to_s` (exclusive) in steps of `step_s`;
    /// steps without samples are left out, and each step keeps its extremes. A column that the database never had is
    /// empty.
    ///
    /// # Errors
    /// The database refuses or holds a damaged block.
    pub fn query(
        &self,
        wagon: u32,
        columns: &[&str],
        from_s: i64,
        to_s: i64,
        step_s: i64,
    ) -> Result<Vec<Point>, HistoryError> {
        let step_s = step_s.max(1);
        let tier = Self::tier(step_s);
        let mut points: Vec<Point> = Vec::new();
        let places = self.places(columns)?;
        for buckets in self.blocks(tier, wagon, from_s, to_s)? {
            for (at, bucket) in buckets.range(from_s..to_s) {
                let unix_s = from_s + (at - from_s).div_euclid(step_s) * step_s;
                let cells = places
                    .iter()
                    .map(|place| place.and_then(|i| bucket.cells.get(i)).copied().unwrap_or(Cell::EMPTY))
                    .collect();
                let part = Bucket { samples: bucket.samples, cells };
                match points.last_mut() {
                    Some(last) if last.unix_s == unix_s => {
                        let mut whole =
                            Bucket { samples: last.samples, cells: std::mem::take(&mut last.cells) };
                        whole.merge(&part);
                        (last.samples, last.cells) = (whole.samples, whole.cells);
                    }
                    _ => points.push(Point { unix_s, samples: part.samples, cells: part.cells }),
                }
            }
        }
        Ok(points)
    }

    /// Names of all columns that the database ever had, in the order of their places.
    ///
    /// # Errors
    /// The database refuses.
    pub fn columns(&self) -> Result<Vec<String>, HistoryError> {
        let names = || -> rusqlite::Result<Vec<String>> {
            let mut select = self.connection.prepare("SELECT name FROM column ORDER BY place")?;
            select.query_map([], |row| row.get(0))?.collect()
        };
        names().map_err(|source| HistoryError::Database { path: self.path.clone(), source })
    }

    fn places(&self, columns: &[&str]) -> Result<Vec<Option<usize>>, HistoryError> {
        let known = self.columns()?;
        Ok(columns.iter().map(|column| known.iter().position(|name| name == column)).collect())
    }

    fn blocks(&self, tier: Tier, wagon: u32, from_s: i64, to_s: i64) -> Result<Vec<Buckets>, HistoryError> {
        let rows = || -> rusqlite::Result<Vec<(i64, Vec<u8>)>> {
            let mut select = self.connection.prepare(
                "SELECT start_s, packed FROM block
                 WHERE tier = ?1 AND wagon = ?2 AND start_s > ?3 AND start_s < ?4 ORDER BY start_s",
            )?;
            let rows = select
                .query_map(params![tier.code(), wagon, from_s - tier.block_s(), to_s], |row| {
                    Ok((row.get(0)?, row.get(1)?))
                })?;
            rows.collect()
        };
        let rows = rows().map_err(|source| HistoryError::Database { path: self.path.clone(), source })?;
        let unpack = |(start_s, packed): (i64, Vec<u8>)| {
            decode(tier, start_s, &packed, None).map_err(|source| HistoryError::Block {
                path: self.path.clone(),
                wagon,
                start_s,
                source,
            })
        };
        rows.into_iter().map(unpack).collect()
    }
}
