//! The thread that writes the history.

use super::History;
use super::columns::{self, Column};
use super::consist::Consist;
use railgrip_bus::now;
use railgrip_history::{Event, HistoryError, Limits, Retention, Store};
use railgrip_indicators::train::track::KeptCell;
use railgrip_messages::Health;
use railgrip_settings::HistorySettings;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::{Duration, Instant};

/// Records that may wait while the disk is slow; beyond, they are dropped and counted.
const WAITING_RECORDS: usize = 16_384;
/// Time between two tries to open a database that refuses.
const REOPEN: Duration = Duration::from_secs(2);
/// A service that has just begun writes sooner: at first so often, then at a quarter of its age until that is longer than
/// the set time. What people ask for first is there, and one that is restarted again and again loses little.
const FIRST: Duration = Duration::from_secs(1);
/// Time between two looks at age and size.
const PRUNE: Duration = Duration::from_secs(600);
/// A clock that jumps ahead by more while this process runs is not trusted, s.
const JUMP_S: i64 = 3600;
/// Nor is one that, at the start, is further ahead of what is stored, s.
const PAUSE_S: i64 = 60 * 86_400;

struct Figures {
    wagon: u32,
    unix_s: i64,
    values: Vec<f32>,
}

enum Record {
    Figures(Figures),
    Event(Event),
    Cells(Vec<KeptCell>),
}

/// Takes what shall be remembered.
#[derive(Debug)]
pub struct Recorder {
    columns: Vec<Column>,
    records: SyncSender<Record>,
    dropped: Arc<AtomicU64>,
}

impl Recorder {
    /// Takes a wagon's indicators; never waits.
    pub fn take(&self, health: &Health) {
        self.send(Record::Figures(Figures {
            wagon: health.wagon,
            unix_s: health.acquired.unix_ns.div_euclid(1_000_000_000),
            values: columns::values(&self.columns, health),
        }));
    }

    /// Takes something that happened; never waits.
    pub fn take_event(&self, event: Event) {
        self.send(Record::Event(event));
    }

    /// Takes what changed on the map of the track; never waits.
    pub fn take_cells(&self, cells: Vec<KeptCell>) {
        if !cells.is_empty() {
            self.send(Record::Cells(cells));
        }
    }

    fn send(&self, record: Record) {
        if self.records.try_send(record).is_err() {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// Starts the writer. It writes what is left and ends when the recorder is dropped.
#[must_use]
pub fn start(settings: &HistorySettings, history: Arc<History>) -> (Recorder, std::thread::JoinHandle<()>) {
    let (sender, receiver) = sync_channel(WAITING_RECORDS);
    let dropped = Arc::new(AtomicU64::new(0));
    let recorder =
        Recorder { columns: history.columns().to_vec(), records: sender, dropped: Arc::clone(&dropped) };
    let writer = Writer {
        settings: settings.clone(),
        history,
        receiver,
        refused: dropped,
        store: None,
        consist: Consist::default(),
        clock: Clock::default(),
        opened: None,
        lost: 0,
    };
    (recorder, std::thread::spawn(move || writer.run()))
}

/// Whether the wall clock may be trusted to say how old something is. A clock that is set years ahead, if only for a
/// minute, must not delete everything.
#[derive(Default)]
struct Clock {
    /// Wall minus monotonic clock at the start, ns.
    offset_ns: Option<i64>,
    distrusted: bool,
}

impl Clock {
    /// Unix s, unless the clock has jumped ahead since the start of this process, or was already far ahead of what is
    /// stored then.
    fn trusted(&mut self, newest_block_s: Option<i64>) -> Option<i64> {
        let stamp = now();
        let unix_s = stamp.unix_ns.div_euclid(1_000_000_000);
        let offset_ns = stamp.unix_ns - stamp.monotonic_ns.cast_signed();
        let ahead_s = match self.offset_ns {
            Some(before_ns) => (offset_ns - before_ns) / 1_000_000_000,
            None => newest_block_s.map_or(0, |newest_s| unix_s - newest_s),
        };
        let allowed_s = if self.offset_ns.is_some() { JUMP_S } else { PAUSE_S };
        self.offset_ns = Some(self.offset_ns.unwrap_or(offset_ns));
        if ahead_s > allowed_s && !self.distrusted {
            self.distrusted = true;
            tracing::warn!(
                "the clock is far ahead of what is stored: nothing goes by age until the next start"
            );
        }
        (!self.distrusted).then_some(unix_s)
    }
}

struct Writer {
    settings: HistorySettings,
    history: Arc<History>,
    receiver: Receiver<Record>,
    /// Records for which there was no room.
    refused: Arc<AtomicU64>,
    store: Option<Store>,
    consist: Consist,
    clock: Clock,
    opened: Option<Instant>,
    /// Records that came while there was no store.
    lost: u64,
}

impl Writer {
    fn run(mut self) {
        let set = Duration::from_secs_f64(self.settings.flush_s);
        let started = Instant::now();
        let (mut flushed, mut pruned) = (started, None::<Instant>);
        loop {
            let period = set.min((started.elapsed() / 4).max(FIRST));
            self.open_if_due();
            match self.receiver.recv_timeout(period.saturating_sub(flushed.elapsed())) {
                Ok(record) => self.push(record),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if flushed.elapsed() >= period {
                flushed = Instant::now();
                // What waits has arrived: only then is it true that everything until now is written.
                while let Ok(record) = self.receiver.try_recv() {
                    self.push(record);
                }
                self.flush(false);
                if pruned.is_none_or(|pruned| pruned.elapsed() >= PRUNE) {
                    pruned = Some(Instant::now());
                    self.prune();
                }
            }
        }
        self.flush(true);
    }

    fn open_if_due(&mut self) {
        if self.store.is_some() || self.opened.is_some_and(|opened| opened.elapsed() < REOPEN) {
            return;
        }
        self.opened = Some(Instant::now());
        let database = self.settings.database();
        let names = columns::stored(self.history.columns());
        let names: Vec<_> = names.iter().map(|(name, keep)| (name.as_str(), *keep)).collect();
        // If the folder cannot be made, opening says so.
        let _ = std::fs::create_dir_all(&self.settings.dir);
        match Store::open_renamed(&database, &names, &columns::former(self.history.columns())) {
            Ok(store) => {
                if let Some(aside) = store.set_aside() {
                    tracing::error!(file = %aside.display(), "the history was damaged and has been set aside");
                }
                tracing::info!(file = %database.display(), "history");
                // Asked once before anything new is stored, so that it can be compared with what was.
                self.clock.trusted(store.newest_block_s().ok().flatten());
                match Consist::enter(&store, self.history.numbers()) {
                    Ok(consist) => {
                        (self.consist, self.store) = (consist, Some(store));
                        self.report(None);
                    }
                    Err(error) => self.report(Some(&error)),
                }
            }
            Err(error) => self.report(Some(&error)),
        }
    }

    fn push(&mut self, record: Record) {
        let Some(store) = &mut self.store else {
            self.lost += 1;
            return;
        };
        let record = match record {
            Record::Figures(record) => record,
            Record::Event(mut event) => {
                event.wagon = event.wagon.map(|place| self.consist.id(place));
                return store.push_event(event);
            }
            Record::Cells(cells) => {
                return cells.into_iter().for_each(|(place, packed)| store.push_cell(place, packed));
            }
        };
        if let Err(error) = store.push(self.consist.id(record.wagon), record.unix_s, &record.values) {
            self.lost += 1;
            self.report(Some(&error));
        }
    }

    fn flush(&mut self, everything: bool) {
        let Some(store) = &mut self.store else { return };
        let until = now().unix_ns.div_euclid(1_000_000_000);
        match store.flush(everything) {
            Ok(flushed) => {
                let size_bytes = store.size_bytes().unwrap_or(0);
                let dropped = store.dropped_blocks()
                    + store.dropped_events()
                    + self.lost
                    + self.refused.load(Ordering::Relaxed);
                self.history.update(|status| {
                    status.written_until_unix_s = Some(until);
                    status.flushes += 1;
                    status.written_bytes += flushed.bytes;
                    (status.size_bytes, status.dropped) = (size_bytes, dropped);
                });
                self.report(None);
            }
            Err(error) => self.report(Some(&error)),
        }
    }

    fn prune(&mut self) {
        const DAY_S: f64 = 86_400.0;
        let limits = |tier: railgrip_settings::TierLimits| Limits {
            age_s: (tier.days * DAY_S) as i64,
            size_bytes: (tier.megabytes * 1e6) as u64,
        };
        let retention = Retention {
            tiers: self.settings.tiers.map(limits),
            event_s: (self.settings.event_days * DAY_S) as i64,
        };
        let Some(store) = &mut self.store else { return };
        let now_unix_s = self.clock.trusted(store.newest_block_s().ok().flatten());
        if let Err(error) = store.prune(&retention, now_unix_s) {
            self.report(Some(&error));
        }
    }

    /// Tells everybody what is wrong, once.
    fn report(&self, error: Option<&HistoryError>) {
        let trouble = error.map(ToString::to_string);
        let before = self.history.trouble();
        if trouble == before {
            return;
        }
        match &trouble {
            Some(trouble) => tracing::error!("only live data are served, nothing is remembered: {trouble}"),
            None => tracing::info!("the history is written again"),
        }
        self.history.update(|status| status.trouble = trouble);
    }
}
