//! The writing side of the history.

use crate::Tier;
use crate::block::{BlockError, Bucket, Buckets, Cell, decode, encode};
use rusqlite::{Connection, ErrorCode, OptionalExtension, params};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Version of the database's tables; older ones are migrated when opened.
const SCHEMA_VERSION: i64 = 1;

/// What brings a database from each version to the next.
const MIGRATIONS: [&str; SCHEMA_VERSION as usize] = ["
    CREATE TABLE column (place INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE) STRICT;
    CREATE TABLE block (
        tier INTEGER NOT NULL, wagon INTEGER NOT NULL, start_s INTEGER NOT NULL, packed BLOB NOT NULL,
        PRIMARY KEY (tier, wagon, start_s)
    ) STRICT, WITHOUT ROWID;
"];

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
    /// The database was written by a newer program.
    #[error("history {}: written by a newer version (tables of version {found}, this program knows {SCHEMA_VERSION})", path.display())]
    Newer {
        /// The database file.
        path: PathBuf,
        /// Its version.
        found: i64,
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
        matches!(self, Self::Database { source, .. } if matches!(
            source.sqlite_error_code(),
            Some(ErrorCode::DiskFull | ErrorCode::ReadOnly | ErrorCode::SystemIoFailure | ErrorCode::CannotOpen)
        ))
    }
}

/// How long and how much is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Retention {
    /// Age at which buckets of a second go, s.
    pub second_s: i64,
    /// Age at which buckets of a minute go, s.
    pub minute_s: i64,
    /// Age at which buckets of an hour go, s.
    pub hour_s: i64,
    /// Size of the database above which the oldest seconds go early, bytes.
    pub size_bytes: u64,
}

impl Default for Retention {
    /// A week of seconds, a quarter of minutes, ten years of hours, 2 GiB.
    fn default() -> Self {
        const DAY: i64 = 86_400;
        Self { second_s: 7 * DAY, minute_s: 92 * DAY, hour_s: 3653 * DAY, size_bytes: 2 << 30 }
    }
}

/// What a flush did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flushed {
    /// Blocks written.
    pub blocks: u64,
    /// Bytes of blocks written.
    pub bytes: u64,
}

/// A block in memory, complete or still growing.
#[derive(Debug, Default)]
struct Open {
    buckets: Buckets,
    dirty: bool,
}

/// Blocks that may wait in memory while the disk refuses them; beyond, the oldest are dropped and counted.
const WAITING_BLOCKS: usize = 4096;

/// The writing side: one per database.
#[derive(Debug)]
pub struct Store {
    connection: Connection,
    path: PathBuf,
    /// Place of each pushed value in a bucket: columns keep theirs for the life of the database, so that blocks of
    /// older versions of the program stay readable and can be continued.
    places: Vec<usize>,
    open: BTreeMap<(Tier, u32, i64), Open>,
    newest: BTreeMap<u32, i64>,
    dropped_blocks: u64,
    set_aside: Option<PathBuf>,
}

impl Store {
    /// Opens or creates the database at `path` for values in the order of `columns`.
    ///
    /// A file that is not a database any more is set aside under another name (see [`Self::set_aside`]), so that a
    /// train with a damaged history still runs.
    ///
    /// # Errors
    /// The file cannot be opened or created, or a newer program wrote it.
    pub fn open(path: &Path, columns: &[&str]) -> Result<Self, HistoryError> {
        match Self::open_once(path, columns) {
            Err(HistoryError::Database { source, .. })
                if matches!(
                    source.sqlite_error_code(),
                    Some(ErrorCode::NotADatabase | ErrorCode::DatabaseCorrupt)
                ) =>
            {
                let aside = free_name(path);
                let moved = std::fs::rename(path, &aside);
                for suffix in ["-wal", "-shm"] {
                    // They may not exist, and without their database they mean nothing.
                    let _ = std::fs::remove_file(with_suffix(path, suffix));
                }
                if moved.is_err() {
                    return Err(HistoryError::Database { path: path.to_owned(), source });
                }
                let mut store = Self::open_once(path, columns)?;
                store.set_aside = Some(aside);
                Ok(store)
            }
            other => other,
        }
    }

    fn open_once(path: &Path, columns: &[&str]) -> Result<Self, HistoryError> {
        let fail = |source| HistoryError::Database { path: path.to_owned(), source };
        let connection = Connection::open(path).map_err(fail)?;
        prepare(&connection).map_err(fail)?;
        migrate(&connection, path)?;
        let places = register_columns(&connection, columns).map_err(fail)?;
        let mut store = Self {
            connection,
            path: path.to_owned(),
            places,
            open: BTreeMap::new(),
            newest: BTreeMap::new(),
            dropped_blocks: 0,
            set_aside: None,
        };
        store.rebuild_coarse()?;
        Ok(store)
    }

    /// Where a damaged database was put when this one was opened in its place.
    pub fn set_aside(&self) -> Option<&Path> {
        self.set_aside.as_deref()
    }

    /// Blocks dropped because the disk refused them for too long.
    pub fn dropped_blocks(&self) -> u64 {
        self.dropped_blocks
    }

    /// Takes in one wagon's values at `unix_s`, in the order of the columns; NaN where nothing is known.
    ///
    /// # Errors
    /// The block that these values continue is in the database and cannot be read.
    pub fn push(&mut self, wagon: u32, unix_s: i64, values: &[f32]) -> Result<(), HistoryError> {
        let width = self.places.iter().max().map_or(0, |last| last + 1);
        let mut cells = vec![Cell::EMPTY; width];
        for (&place, &value) in self.places.iter().zip(values) {
            cells[place] = Cell::of(value);
        }
        let bucket = Bucket { samples: 1, cells };
        for tier in Tier::ALL {
            let start_s = tier.block_start(unix_s);
            let key = (tier, wagon, start_s);
            if !self.open.contains_key(&key) {
                let buckets = self.stored(tier, wagon, start_s)?.unwrap_or_default();
                self.open.insert(key, Open { buckets, dirty: false });
            }
            if let Some(open) = self.open.get_mut(&key) {
                open.dirty = true;
                merge_into(&mut open.buckets, tier.bucket_start(unix_s), &bucket);
            }
        }
        self.newest.insert(wagon, unix_s);
        Ok(())
    }

    /// Writes what is new: every changed block of seconds, and coarser blocks that are complete. With `everything`
    /// (at an orderly end) coarser ones too.
    ///
    /// # Errors
    /// The disk refuses. Nothing is lost: the blocks stay in memory for the next flush, up to a limit.
    pub fn flush(&mut self, everything: bool) -> Result<Flushed, HistoryError> {
        let newest = self.newest.clone();
        let complete = |&(tier, wagon, start_s): &(Tier, u32, i64)| {
            newest.get(&wagon).is_none_or(|&now| now >= start_s + tier.block_s() || now < start_s)
        };
        let due: Vec<_> = self
            .open
            .iter()
            .filter(|(key, open)| open.dirty && (everything || key.0 == Tier::Second || complete(key)))
            .map(|(key, _)| *key)
            .collect();
        let done = self.write(&due);
        if done.is_ok() {
            for key in &due {
                self.open.entry(*key).or_default().dirty = false;
            }
            let finished: Vec<_> = self.open.keys().filter(|key| complete(key)).copied().collect();
            for key in finished {
                if self.open.get(&key).is_some_and(|open| !open.dirty) {
                    self.open.remove(&key);
                }
            }
        }
        while self.open.len() > WAITING_BLOCKS {
            self.open.pop_first();
            self.dropped_blocks += 1;
        }
        done
    }

    fn write(&mut self, keys: &[(Tier, u32, i64)]) -> Result<Flushed, HistoryError> {
        let path = self.path.clone();
        let fail = |source| HistoryError::Database { path: path.clone(), source };
        let mut flushed = Flushed::default();
        if keys.is_empty() {
            return Ok(flushed);
        }
        let transaction = self.connection.transaction().map_err(fail)?;
        for &(tier, wagon, start_s) in keys {
            let Some(open) = self.open.get(&(tier, wagon, start_s)) else { continue };
            let packed = encode(tier, start_s, &open.buckets, &[]).map_err(|source| HistoryError::Block {
                path: path.clone(),
                wagon,
                start_s,
                source,
            })?;
            transaction
                .prepare(
                    "INSERT OR REPLACE INTO block (tier, wagon, start_s, packed) VALUES (?1, ?2, ?3, ?4)",
                )
                .and_then(|mut insert| insert.execute(params![tier.code(), wagon, start_s, packed]))
                .map_err(fail)?;
            flushed.blocks += 1;
            flushed.bytes += packed.len() as u64;
        }
        transaction.commit().map_err(fail)?;
        Ok(flushed)
    }

    /// Drops what is older than `retention` allows at `now_unix_s`, and the oldest seconds while the database is too
    /// large.
    ///
    /// # Errors
    /// The database refuses.
    pub fn prune(&mut self, retention: &Retention, now_unix_s: i64) -> Result<u64, HistoryError> {
        let fail = |source| HistoryError::Database { path: self.path.clone(), source };
        let mut gone = 0;
        for (tier, age_s) in [
            (Tier::Second, retention.second_s),
            (Tier::Minute, retention.minute_s),
            (Tier::Hour, retention.hour_s),
        ] {
            gone += self
                .connection
                .execute(
                    "DELETE FROM block WHERE tier = ?1 AND start_s < ?2",
                    params![tier.code(), now_unix_s - age_s - tier.block_s()],
                )
                .map_err(fail)?;
        }
        for tier in [Tier::Second, Tier::Minute] {
            while self.size_bytes()? > retention.size_bytes {
                let batch = self
                    .connection
                    .execute(
                        "DELETE FROM block WHERE tier = ?1 AND start_s <= (SELECT min(start_s) + ?2 FROM block WHERE tier = ?1)",
                        params![tier.code(), 60 * tier.block_s()],
                    )
                    .map_err(fail)?;
                gone += batch;
                if batch == 0 {
                    break;
                }
            }
        }
        self.connection.execute_batch("PRAGMA incremental_vacuum(1000)").map_err(fail)?;
        Ok(gone as u64)
    }

    /// Size of what the database holds, bytes, without pages that are free again.
    ///
    /// # Errors
    /// The database refuses.
    pub fn size_bytes(&self) -> Result<u64, HistoryError> {
        let pragma = |name: &str| self.connection.pragma_query_value(None, name, |row| row.get::<_, i64>(0));
        let pages =
            |name| pragma(name).map_err(|source| HistoryError::Database { path: self.path.clone(), source });
        Ok(((pages("page_count")? - pages("freelist_count")?) * pages("page_size")?).max(0) as u64)
    }

    /// Limits the database to so many pages, as a full disk would (SQLite never goes below what it holds).
    ///
    /// # Errors
    /// The database refuses.
    pub fn limit_pages(&self, pages: u32) -> Result<(), HistoryError> {
        self.connection
            .query_row(&format!("PRAGMA max_page_count = {pages}"), [], |_| Ok(()))
            .map_err(|source| HistoryError::Database { path: self.path.clone(), source })
    }

    fn stored(&self, tier: Tier, wagon: u32, start_s: i64) -> Result<Option<Buckets>, HistoryError> {
        let fail = |source| HistoryError::Database { path: self.path.clone(), source };
        let packed: Option<Vec<u8>> = self
            .connection
            .prepare("SELECT packed FROM block WHERE tier = ?1 AND wagon = ?2 AND start_s = ?3")
            .and_then(|mut select| {
                select
                    .query_row(params![tier.code(), wagon, start_s], |row| row.get::<_, Vec<u8>>(0))
                    .optional()
            })
            .map_err(fail)?;
        packed
            .map(|packed| decode(tier, start_s, &packed, None))
            .transpose()
            .map_err(|source| HistoryError::Block { path: self.path.clone(), wagon, start_s, source })
    }

    /// Computes the coarser blocks of each wagon's last day anew from the finer ones.
    fn rebuild_coarse(&mut self) -> Result<(), HistoryError> {
        for (finer, coarser) in [(Tier::Second, Tier::Minute), (Tier::Minute, Tier::Hour)] {
            for (wagon, newest) in self.newest_blocks(finer)? {
                let since = coarser.block_start(newest);
                for block_s in [since - coarser.block_s(), since] {
                    self.rebuild_block(finer, coarser, wagon, block_s)?;
                }
            }
        }
        Ok(())
    }

    fn rebuild_block(
        &mut self,
        finer: Tier,
        coarser: Tier,
        wagon: u32,
        block_s: i64,
    ) -> Result<(), HistoryError> {
        let mut buckets = self.stored(coarser, wagon, block_s)?.unwrap_or_default();
        let mut fresh = Buckets::new();
        for start_s in (block_s..block_s + coarser.block_s()).step_by(finer.block_s() as usize) {
            let open = self.open.get(&(finer, wagon, start_s)).map(|open| open.buckets.clone());
            let fine = match open {
                Some(buckets) => buckets,
                None => self.stored(finer, wagon, start_s)?.unwrap_or_default(),
            };
            for (at, bucket) in &fine {
                merge_into(&mut fresh, coarser.bucket_start(*at), bucket);
            }
        }
        let mut dirty = false;
        for (at, bucket) in fresh {
            if buckets.get(&at).is_none_or(|known| known.samples < bucket.samples) {
                buckets.insert(at, bucket);
                dirty = true;
            }
        }
        if dirty {
            self.open.insert((coarser, wagon, block_s), Open { buckets, dirty });
        }
        Ok(())
    }

    fn newest_blocks(&self, tier: Tier) -> Result<Vec<(u32, i64)>, HistoryError> {
        let query = || -> rusqlite::Result<Vec<(u32, i64)>> {
            let mut select = self
                .connection
                .prepare("SELECT wagon, max(start_s) FROM block WHERE tier = ?1 GROUP BY wagon")?;
            let rows = select.query_map([tier.code()], |row| Ok((row.get(0)?, row.get(1)?)))?;
            rows.collect()
        };
        query().map_err(|source| HistoryError::Database { path: self.path.clone(), source })
    }
}

fn merge_into(buckets: &mut Buckets, at: i64, bucket: &Bucket) {
    match buckets.get_mut(&at) {
        Some(known) => known.merge(bucket),
        None => {
            buckets.insert(at, bucket.clone());
        }
    }
}

fn prepare(connection: &Connection) -> rusqlite::Result<()> {
    connection.busy_timeout(std::time::Duration::from_secs(5))?;
    connection.execute_batch(
        "PRAGMA auto_vacuum = INCREMENTAL; PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL;
         PRAGMA wal_autocheckpoint = 1000; PRAGMA journal_size_limit = 8388608;",
    )
}

fn migrate(connection: &Connection, path: &Path) -> Result<(), HistoryError> {
    let fail = |source| HistoryError::Database { path: path.to_owned(), source };
    let version: i64 = connection.pragma_query_value(None, "user_version", |row| row.get(0)).map_err(fail)?;
    let from = usize::try_from(version).unwrap_or(usize::MAX);
    let Some(steps) = MIGRATIONS.get(from..) else {
        return Err(HistoryError::Newer { path: path.to_owned(), found: version });
    };
    for (offset, step) in steps.iter().enumerate() {
        let to = from + offset + 1;
        connection
            .execute_batch(&format!("BEGIN IMMEDIATE; {step}; PRAGMA user_version = {to}; COMMIT"))
            .map_err(fail)?;
    }
    Ok(())
}

/// Gives each column its place, new ones behind those that are there.
fn register_columns(connection: &Connection, columns: &[&str]) -> rusqlite::Result<Vec<usize>> {
    for name in columns {
        connection.execute(
            "INSERT OR IGNORE INTO column (place, name) SELECT coalesce(max(place) + 1, 0), ?1 FROM column",
            [name],
        )?;
    }
    let mut select = connection.prepare("SELECT place FROM column WHERE name = ?1")?;
    columns
        .iter()
        .map(|name| select.query_row([name], |row| row.get::<_, u32>(0)).map(|place| place as usize))
        .collect()
}

fn with_suffix(path: &Path, suffix: &str) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(suffix);
    name.into()
}

/// A name beside `path` that nothing has yet.
fn free_name(path: &Path) -> PathBuf {
    let candidates = (1..).map(|number| with_suffix(path, &format!(".damaged-{number}")));
    candidates.into_iter().find(|name| !name.exists()).unwrap_or_else(|| with_suffix(path, ".damaged"))
}
