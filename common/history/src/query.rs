//! The reading side of the history.

use crate::block::{Buckets, Cell, decode};
use crate::schema::FormerName;
use crate::stored::{load, merge_into, newest_start, take_larger};
use crate::{Bucket, HistoryError, Tier, key};
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
    former: Vec<FormerName>,
}

/// The columns that a query reads, and where coarse tiers end.
struct Scope {
    places: Vec<Option<usize>>,
    /// Start of the newest block of each tier. Coarser blocks are written when they are complete, so from here on they
    /// are computed from the finer tier, as are those that were never written.
    newest_s: [Option<i64>; 3],
}

impl Reader {
    /// Opens the database at `path` for reading; also one on a read-only medium.
    ///
    /// # Errors
    /// There is no such database.
    pub fn open(path: &Path) -> Result<Self, HistoryError> {
        let fail = |source| HistoryError::Database { path: path.to_owned(), source };
        let open = |name: &Path, flags: OpenFlags| -> rusqlite::Result<Connection> {
            let connection = Connection::open_with_flags(name, flags | OpenFlags::SQLITE_OPEN_READ_ONLY)?;
            connection.busy_timeout(std::time::Duration::from_secs(5))?;
            // The file is looked at only now.
            connection.pragma_query_value(None, "user_version", |row| row.get::<_, i64>(0))?;
            Ok(connection)
        };
        let connection = open(path, OpenFlags::SQLITE_OPEN_NO_MUTEX).or_else(|error| {
            // Where nothing can be written, the file cannot change either, and SQLite must be told so.
            let uri = format!("file:{}?immutable=1", escaped(path));
            open(Path::new(&uri), OpenFlags::SQLITE_OPEN_NO_MUTEX | OpenFlags::SQLITE_OPEN_URI)
                .map_err(|_| error)
        });
        Ok(Self { connection: connection.map_err(fail)?, path: path.to_owned(), former: Vec::new() })
    }

    /// Reads columns of older versions under the names of today; what is written by this version needs no such help.
    #[must_use]
    pub fn with_names(self, former: &[FormerName]) -> Self {
        Self { former: former.to_vec(), ..self }
    }

    pub(crate) fn connection(&self) -> &Connection {
        &self.connection
    }

    pub(crate) fn fail(&self, source: rusqlite::Error) -> HistoryError {
        let path = self.path.clone();
        // A database of something else, one that was emptied, or one that lost its tables.
        match source.to_string().split_once("no such table: ") {
            Some((_, table)) => {
                let table = table.split_whitespace().next().unwrap_or_default().to_owned();
                HistoryError::NoHistory { path, table }
            }
            None => HistoryError::Database { path, source },
        }
    }

    /// The finest tier worth reading for this step.
    pub fn tier(step_s: i64) -> Tier {
        Tier::ALL.into_iter().rev().find(|tier| tier.bucket_s() <= step_s).unwrap_or(Tier::Second)
    }

    /// All that `read` reads is of one instant, whatever is written meanwhile.
    ///
    /// # Errors
    /// The database refuses, or `read` fails.
    pub fn at_one_instant<T, E: From<HistoryError>>(
        &self,
        read: impl FnOnce(&Self) -> Result<T, E>,
    ) -> Result<T, E> {
        if !self.connection.is_autocommit() {
            return read(self);
        }
        let run = |sql| self.connection.execute_batch(sql).map_err(|source| self.fail(source));
        run("BEGIN")?;
        let result = read(self);
        // Nothing was written: an end that fails changes nothing.
        let _ = run("COMMIT");
        result
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
        let mut points: Vec<Point> = Vec::new();
        self.at_one_instant(|reader| {
            reader.steps(wagon, columns, from_s, to_s, step_s, |point| {
                points.push(point);
                Ok::<_, HistoryError>(())
            })
        })?;
        Ok(points)
    }

    /// Hands the steps of a query to `take` one by one, in the order of time.
    ///
    /// # Errors
    /// The database refuses or holds a damaged block, or `take` fails.
    pub fn steps<E: From<HistoryError>>(
        &self,
        wagon: u32,
        columns: &[&str],
        from_s: i64,
        to_s: i64,
        step_s: i64,
        mut take: impl FnMut(Point) -> Result<(), E>,
    ) -> Result<(), E> {
        let step_s = step_s.max(1);
        let mut open: Option<Point> = None;
        self.each(Self::tier(step_s), wagon, columns, from_s, to_s, |at, bucket| {
            let unix_s = from_s + (at - from_s).div_euclid(step_s) * step_s;
            match &mut open {
                Some(last) if last.unix_s == unix_s => {
                    let cells = std::mem::take(&mut last.cells);
                    let mut whole = Bucket { samples: last.samples, cells };
                    whole.merge(&bucket);
                    (last.samples, last.cells) = (whole.samples, whole.cells);
                }
                _ => {
                    let next = Point { unix_s, samples: bucket.samples, cells: bucket.cells };
                    if let Some(done) = open.replace(next) {
                        take(done)?;
                    }
                }
            }
            Ok::<_, E>(())
        })?;
        open.map_or(Ok(()), take)
    }

    /// Hands the buckets of one wagon and tier from `from_s` to before `to_s` to `take`, in the order of time.
    ///
    /// # Errors
    /// The database refuses or holds a damaged block, or `take` fails.
    pub fn each<E: From<HistoryError>>(
        &self,
        tier: Tier,
        wagon: u32,
        columns: &[&str],
        from_s: i64,
        to_s: i64,
        mut take: impl FnMut(i64, Bucket) -> Result<(), E>,
    ) -> Result<(), E> {
        let scope = self.scope(columns)?;
        let mut at_s = tier.block_start(from_s.clamp(0, key::LAST_START_S - 1));
        while let Some(start_s) = self.next_start(tier, at_s)?.filter(|start_s| *start_s < to_s) {
            let mut buckets = self.block(&scope, tier, wagon, start_s)?;
            let past = buckets.split_off(&to_s);
            drop(past);
            for (at, bucket) in buckets.split_off(&from_s) {
                take(at, bucket)?;
            }
            at_s = start_s + tier.block_s();
        }
        Ok(())
    }

    /// Names of all columns that the database ever had, in the order of their places.
    ///
    /// # Errors
    /// The database refuses.
    pub fn columns(&self) -> Result<Vec<String>, HistoryError> {
        let names = || -> rusqlite::Result<Vec<String>> {
            let mut select = self.connection.prepare_cached("SELECT name FROM column ORDER BY place")?;
            select.query_map([], |row| row.get(0))?.collect()
        };
        let mut names = names().map_err(|source| self.fail(source))?;
        for FormerName { then, now } in &self.former {
            if let Some(place) = names.iter().position(|name| name == then)
                && !names.contains(now)
            {
                names[place].clone_from(now);
            }
        }
        Ok(names)
    }

    /// Start of the oldest block that can answer in steps of this tier, Unix s; data begin within that block. `None` while
    /// nothing is stored. A coarser tier is computed from the finer ones where it was not written yet.
    ///
    /// # Errors
    /// The database refuses.
    pub fn stored_from(&self, tier: Tier) -> Result<Option<i64>, HistoryError> {
        let mut oldest_s: Option<i64> = None;
        for finer in Tier::ALL.into_iter().filter(|finer| finer.code() <= tier.code()) {
            let keys = key::all(finer);
            let first = || -> rusqlite::Result<Option<i64>> {
                let mut select = self
                    .connection
                    .prepare_cached("SELECT min(key) FROM packed_block WHERE key >= ?1 AND key < ?2")?;
                select.query_row(params![keys.start, keys.end], |row| row.get(0))
            };
            let start_s = first().map_err(|source| self.fail(source))?.map(key::start_s);
            oldest_s = oldest_s.into_iter().chain(start_s).min();
        }
        Ok(oldest_s)
    }

    /// Numbers of all wagons of which something is stored, ascending.
    ///
    /// # Errors
    /// The database refuses.
    pub fn wagons(&self) -> Result<Vec<u32>, HistoryError> {
        let mut wagons: Vec<u32> = Vec::new();
        // What a finer tier has before the newest block of the coarser one is in the coarser one too.
        let mut since_s = 0;
        for tier in Tier::ALL.into_iter().rev() {
            let keys = key::of(tier, since_s, 0)..key::all(tier).end;
            let newest = newest_start(&self.connection, tier).map_err(|source| self.fail(source))?;
            since_s = newest.map_or(since_s, |newest_s| since_s.max(newest_s));
            let rows = || -> rusqlite::Result<Vec<u32>> {
                let mut select = self
                    .connection
                    .prepare_cached("SELECT key FROM packed_block WHERE key >= ?1 AND key < ?2")?;
                let mut found = std::collections::BTreeSet::new();
                let mut rows = select.query(params![keys.start, keys.end])?;
                while let Some(row) = rows.next()? {
                    found.insert(key::wagon(row.get(0)?));
                }
                Ok(found.into_iter().collect())
            };
            wagons.extend(rows().map_err(|source| self.fail(source))?);
        }
        wagons.sort_unstable();
        wagons.dedup();
        Ok(wagons)
    }

    fn scope(&self, columns: &[&str]) -> Result<Scope, HistoryError> {
        let known = self.columns()?;
        let places = columns.iter().map(|column| known.iter().position(|name| name == column)).collect();
        let mut newest_s = [None; 3];
        for tier in Tier::ALL {
            newest_s[tier as usize] =
                newest_start(&self.connection, tier).map_err(|source| self.fail(source))?;
        }
        Ok(Scope { places, newest_s })
    }

    /// Start of the first block at or after `at_s` of which any wagon may have something.
    fn next_start(&self, tier: Tier, at_s: i64) -> Result<Option<i64>, HistoryError> {
        if at_s >= key::LAST_START_S {
            return Ok(None);
        }
        let keys = key::of(tier, at_s, 0)..key::all(tier).end;
        let stored = || -> rusqlite::Result<Option<i64>> {
            self.connection
                .prepare_cached("SELECT min(key) FROM packed_block WHERE key >= ?1 AND key < ?2")?
                .query_row(params![keys.start, keys.end], |row| row.get::<_, Option<i64>>(0))
        };
        let stored = stored().map_err(|source| self.fail(source))?.map(key::start_s);
        let Some(finer) = tier.finer() else { return Ok(stored) };
        let computed = self.next_start(finer, at_s)?.map(|start_s| tier.block_start(start_s));
        Ok(match (stored, computed) {
            (Some(stored), Some(computed)) => Some(stored.min(computed)),
            (stored, computed) => stored.or(computed),
        })
    }

    /// The block with only the columns asked for.
    fn block(&self, scope: &Scope, tier: Tier, wagon: u32, start_s: i64) -> Result<Buckets, HistoryError> {
        let packed = load(&self.connection, tier, wagon, start_s).map_err(|source| self.fail(source))?;
        let damaged = |source| HistoryError::Block { path: self.path.clone(), wagon, start_s, source };
        let stored = packed.is_some();
        let mut buckets = match packed {
            Some(packed) => decode(tier, start_s, &packed, Some(&scope.places)).map_err(damaged)?,
            None => Buckets::new(),
        };
        let open = !stored || scope.newest_s[tier as usize].is_none_or(|newest_s| start_s >= newest_s);
        if let Some(finer) = tier.finer().filter(|_| open) {
            let mut fresh = Buckets::new();
            let end_s = start_s + tier.block_s();
            let mut at_s = start_s;
            while let Some(fine_s) = self.next_start(finer, at_s)?.filter(|fine_s| *fine_s < end_s) {
                for (at, bucket) in self.block(scope, finer, wagon, fine_s)? {
                    merge_into(&mut fresh, tier.bucket_start(at), &bucket);
                }
                at_s = fine_s + finer.block_s();
            }
            take_larger(&mut buckets, fresh);
        }
        Ok(buckets)
    }
}

/// A path in a URI.
fn escaped(path: &Path) -> String {
    path.to_string_lossy().replace('%', "%25").replace('?', "%3f").replace('#', "%23")
}
