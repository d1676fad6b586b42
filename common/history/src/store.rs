//! The writing side of the history.

use crate::block::{Bucket, Buckets, Cell, Keep, decode, encode};
use crate::event::{self, Event, WAITING_EVENTS};
use crate::schema::{self, FormerName};
use crate::stored::{load, merge_into, newest_start, take_larger};
use crate::track_cell::{self, Cells};
use crate::{HistoryError, Tier, key};
use rusqlite::{Connection, params};
use std::collections::{BTreeMap, VecDeque};
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

/// What a flush did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flushed {
    /// Blocks written.
    pub blocks: u64,
    /// Bytes of blocks written.
    pub bytes: u64,
    /// Events written.
    pub events: u64,
}

/// A block in memory, complete or still growing.
#[derive(Debug, Default)]
struct Open {
    buckets: Buckets,
    dirty: bool,
}

/// Blocks that may wait in memory while the disk refuses them; beyond, the oldest are dropped and counted.
const WAITING_BLOCKS: usize = 1024;

/// The writing side: one per database.
#[derive(Debug)]
pub struct Store {
    connection: Connection,
    path: PathBuf,
    /// Place of each pushed value in a bucket: columns keep theirs for the life of the database, so that blocks of
    /// older versions of the program stay readable and can be continued.
    places: Vec<usize>,
    /// What is kept of each place.
    keep: Vec<Keep>,
    open: BTreeMap<(Tier, u32, i64), Open>,
    events: VecDeque<Event>,
    /// Changed cells of the track. There are no more of them than the map has, so none need be dropped.
    cells: Cells,
    /// Time of the last push, Unix s.
    newest_s: i64,
    dropped_blocks: u64,
    dropped_events: u64,
    set_aside: Option<PathBuf>,
    /// Keeps other writers away as long as this one lives.
    _lock: File,
}

impl Store {
    /// Opens or creates the database at `path` for values in the order of `columns`.
    ///
    /// A file that is not a database any more is set aside under another name (see [`Self::set_aside`]), so that a
    /// train with a damaged history still runs.
    ///
    /// # Errors
    /// The file cannot be opened or created, a newer program wrote it, or another process writes it.
    pub fn open(path: &Path, columns: &[(&str, Keep)]) -> Result<Self, HistoryError> {
        Self::open_renamed(path, columns, &[])
    }

    /// The same where older versions of the program gave some columns other names: from now on they have those of today.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_renamed(
        path: &Path,
        columns: &[(&str, Keep)],
        former: &[FormerName],
    ) -> Result<Self, HistoryError> {
        let lock = claim(path)?;
        match Self::open_once(path, columns, former, &lock) {
            Err(error) if error.is_damage() => {
                let aside = free_name(path);
                if std::fs::rename(path, &aside).is_err() {
                    return Err(error);
                }
                for suffix in ["-wal", "-shm"] {
                    // They may not exist, and without their database they mean nothing to the new one.
                    let _ = std::fs::rename(with_suffix(path, suffix), with_suffix(&aside, suffix));
                }
                let mut store = Self::open_once(path, columns, former, &lock)?;
                store.set_aside = Some(aside);
                Ok(store)
            }
            other => other,
        }
    }

    fn open_once(
        path: &Path,
        columns: &[(&str, Keep)],
        former: &[FormerName],
        lock: &File,
    ) -> Result<Self, HistoryError> {
        let fail = |source| HistoryError::Database { path: path.to_owned(), source };
        let lock = lock.try_clone().map_err(|source| HistoryError::Lock { path: path.to_owned(), source })?;
        let connection = Connection::open(path).map_err(fail)?;
        schema::prepare(&connection).map_err(fail)?;
        schema::migrate(&connection, path)?;
        schema::rename_columns(&connection, former).map_err(fail)?;
        let (places, keep) = schema::register_columns(&connection, columns).map_err(fail)?;
        let mut store = Self {
            connection,
            path: path.to_owned(),
            places,
            keep,
            open: BTreeMap::new(),
            events: VecDeque::new(),
            cells: Cells::new(),
            newest_s: 0,
            dropped_blocks: 0,
            dropped_events: 0,
            set_aside: None,
            _lock: lock,
        };
        store.rebuild_coarse()?;
        Ok(store)
    }

    pub(crate) fn connection(&self) -> &Connection {
        &self.connection
    }

    pub(crate) fn fail(&self, source: rusqlite::Error) -> HistoryError {
        HistoryError::Database { path: self.path.clone(), source }
    }

    /// Where a damaged database was put when this one was opened in its place.
    pub fn set_aside(&self) -> Option<&Path> {
        self.set_aside.as_deref()
    }

    /// Blocks dropped because the disk refused them for too long.
    pub fn dropped_blocks(&self) -> u64 {
        self.dropped_blocks
    }

    /// Events dropped because the disk refused them for too long.
    pub fn dropped_events(&self) -> u64 {
        self.dropped_events
    }

    /// Start of the newest block in the database, Unix s.
    ///
    /// # Errors
    /// The database refuses.
    pub fn newest_block_s(&self) -> Result<Option<i64>, HistoryError> {
        newest_start(&self.connection, Tier::Second).map_err(|source| self.fail(source))
    }

    /// Takes in what is known of the cell of the track at `place` now, or that it is to be forgotten; the next flush
    /// writes it.
    pub fn push_cell(&mut self, place: i64, packed: Option<Vec<u8>>) {
        self.cells.insert(place, packed);
    }

    /// Takes an event in; the next flush writes it.
    pub fn push_event(&mut self, event: Event) {
        self.events.push_back(event);
        if self.events.len() > WAITING_EVENTS {
            self.events.pop_front();
            self.dropped_events += 1;
        }
    }

    /// Takes in one wagon's values at `unix_s`, in the order of the columns; NaN where nothing is known. Instants
    /// before 1970 and wagons beyond 4095 are not kept.
    ///
    /// # Errors
    /// The block that these values continue is in the database and cannot be read.
    pub fn push(&mut self, wagon: u32, unix_s: i64, values: &[f32]) -> Result<(), HistoryError> {
        if wagon >= key::MOST_WAGONS || !(0..key::LAST_START_S).contains(&unix_s) {
            return Ok(());
        }
        let mut cells = vec![Cell::EMPTY; self.keep.len()];
        for (&place, &value) in self.places.iter().zip(values) {
            cells[place] = Cell::of(value);
        }
        let bucket = Bucket { samples: 1, cells };
        for tier in Tier::ALL {
            let start_s = tier.block_start(unix_s);
            let place = (tier, wagon, start_s);
            if !self.open.contains_key(&place) {
                let buckets = self.stored(tier, wagon, start_s)?.unwrap_or_default();
                self.open.insert(place, Open { buckets, dirty: false });
            }
            if let Some(open) = self.open.get_mut(&place) {
                open.dirty = true;
                merge_into(&mut open.buckets, tier.bucket_start(unix_s), &bucket);
            }
        }
        self.newest_s = unix_s;
        Ok(())
    }

    /// Writes what is new: events, cells of the track, every changed block of seconds, and coarser blocks that are complete. With
    /// `everything` (at an orderly end) coarser ones too.
    ///
    /// # Errors
    /// The disk refuses. Nothing is lost: blocks and events stay in memory for the next flush, up to a limit.
    pub fn flush(&mut self, everything: bool) -> Result<Flushed, HistoryError> {
        let now_s = self.newest_s;
        let complete =
            |&(tier, _, start_s): &(Tier, u32, i64)| now_s >= start_s + tier.block_s() || now_s < start_s;
        let due: Vec<_> = self
            .open
            .iter()
            .filter(|(place, open)| open.dirty && (everything || place.0 == Tier::Second || complete(place)))
            .map(|(place, _)| *place)
            .collect();
        let done = self.write(&due);
        if done.is_ok() {
            for place in &due {
                if let Some(open) = self.open.get_mut(place) {
                    open.dirty = false;
                }
            }
            self.events.clear();
            self.cells.clear();
            self.open.retain(|place, open| open.dirty || !complete(place));
        }
        while self.open.len() > WAITING_BLOCKS {
            self.open.pop_first();
            self.dropped_blocks += 1;
        }
        done
    }

    fn write(&mut self, places: &[(Tier, u32, i64)]) -> Result<Flushed, HistoryError> {
        let path = self.path.clone();
        let fail = |source| HistoryError::Database { path: path.clone(), source };
        let mut flushed = Flushed::default();
        let events: &[Event] = self.events.make_contiguous();
        if places.is_empty() && events.is_empty() && self.cells.is_empty() {
            return Ok(flushed);
        }
        let transaction = self.connection.transaction().map_err(fail)?;
        event::insert(&transaction, events).map_err(fail)?;
        track_cell::write(&transaction, &self.cells).map_err(fail)?;
        flushed.events = events.len() as u64;
        for &(tier, wagon, start_s) in places {
            let Some(open) = self.open.get(&(tier, wagon, start_s)) else { continue };
            let packed = encode(tier, start_s, &open.buckets, &self.keep)
                .map_err(|source| HistoryError::Block { path: path.clone(), wagon, start_s, source })?;
            transaction
                .prepare_cached("INSERT OR REPLACE INTO packed_block (key, packed) VALUES (?1, ?2)")
                .and_then(|mut insert| insert.execute(params![key::of(tier, start_s, wagon), packed]))
                .map_err(fail)?;
            flushed.blocks += 1;
            flushed.bytes += packed.len() as u64;
        }
        transaction.commit().map_err(fail)?;
        Ok(flushed)
    }

    /// Size of what the database holds, bytes, without pages that are free again.
    ///
    /// # Errors
    /// The database refuses.
    pub fn size_bytes(&self) -> Result<u64, HistoryError> {
        let pragma = |name: &str| self.connection.pragma_query_value(None, name, |row| row.get::<_, i64>(0));
        let pages = |name| pragma(name).map_err(|source| self.fail(source));
        Ok(((pages("page_count")? - pages("freelist_count")?) * pages("page_size")?).max(0) as u64)
    }

    /// Limits the database to so many pages, as a full disk would (SQLite never goes below what it holds).
    ///
    /// # Errors
    /// The database refuses.
    pub fn limit_pages(&self, pages: u32) -> Result<(), HistoryError> {
        self.connection
            .query_row(&format!("PRAGMA max_page_count = {pages}"), [], |_| Ok(()))
            .map_err(|source| self.fail(source))
    }

    fn stored(&self, tier: Tier, wagon: u32, start_s: i64) -> Result<Option<Buckets>, HistoryError> {
        load(&self.connection, tier, wagon, start_s)
            .map_err(|source| self.fail(source))?
            .map(|packed| decode(tier, start_s, &packed, None))
            .transpose()
            .map_err(|source| HistoryError::Block { path: self.path.clone(), wagon, start_s, source })
    }

    /// Computes the newest coarse blocks anew from the finer ones: a crash takes the ones that were not complete.
    fn rebuild_coarse(&mut self) -> Result<(), HistoryError> {
        for (finer, coarser) in [(Tier::Second, Tier::Minute), (Tier::Minute, Tier::Hour)] {
            let fail = |source| HistoryError::Database { path: self.path.clone(), source };
            let Some(newest_s) = newest_start(&self.connection, finer).map_err(fail)? else { continue };
            let since_s = coarser.block_start(newest_s);
            let span = since_s - coarser.block_s()..newest_s + finer.block_s();
            let keys = key::range(finer, span);
            let mut wagons: Vec<u32> = Vec::new();
            let mut select = self
                .connection
                .prepare("SELECT DISTINCT key & 4095 FROM packed_block WHERE key >= ?1 AND key < ?2")
                .map_err(fail)?;
            let rows = select.query_map(params![keys.start, keys.end], |row| row.get(0)).map_err(fail)?;
            for wagon in rows {
                wagons.push(wagon.map_err(fail)?);
            }
            drop(select);
            for wagon in wagons {
                for block_s in [since_s - coarser.block_s(), since_s] {
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
        if take_larger(&mut buckets, fresh) {
            self.open.insert((coarser, wagon, block_s), Open { buckets, dirty: true });
        }
        Ok(())
    }
}

/// The kernel releases this lock however its owner dies.
fn claim(path: &Path) -> Result<File, HistoryError> {
    let lock = with_suffix(path, ".lock");
    let fail = |source| HistoryError::Lock { path: lock.clone(), source };
    let file = File::options().create(true).truncate(false).write(true).open(&lock).map_err(fail)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(HistoryError::Taken { path: path.to_owned() }),
        Err(TryLockError::Error(source)) => Err(fail(source)),
    }
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
