//! The thread that writes the history.

use super::History;
use super::columns::{self, Column};
use railgrip_bus::now;
use railgrip_history::{HistoryError, Retention, Store};
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
/// Time between two looks at age and size.
const PRUNE: Duration = Duration::from_secs(600);

struct Record {
    wagon: u32,
    unix_s: i64,
    values: Vec<f32>,
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
        let record = Record {
            wagon: health.wagon,
            unix_s: health.acquired.unix_ns.div_euclid(1_000_000_000),
            values: columns::values(&self.columns, health),
        };
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
        opened: None,
        lost: 0,
    };
    (recorder, std::thread::spawn(move || writer.run()))
}

struct Writer {
    settings: HistorySettings,
    history: Arc<History>,
    receiver: Receiver<Record>,
    /// Records for which there was no room.
    refused: Arc<AtomicU64>,
    store: Option<Store>,
    opened: Option<Instant>,
    /// Records that came while there was no store.
    lost: u64,
}

impl Writer {
    fn run(mut self) {
        let period = Duration::from_secs_f64(self.settings.flush_s);
        let (mut flushed, mut pruned) = (Instant::now(), None::<Instant>);
        loop {
            self.open_if_due();
            match self.receiver.recv_timeout(period.saturating_sub(flushed.elapsed())) {
                Ok(record) => self.push(&record),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if flushed.elapsed() >= period {
                flushed = Instant::now();
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
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        // If the folder cannot be made, opening says so.
        let _ = std::fs::create_dir_all(&self.settings.dir);
        match Store::open(&database, &names) {
            Ok(store) => {
                if let Some(aside) = store.set_aside() {
                    tracing::error!(file = %aside.display(), "the history was damaged and has been set aside");
                }
                tracing::info!(file = %database.display(), "history");
                self.store = Some(store);
                self.report(None);
            }
            Err(error) => self.report(Some(&error)),
        }
    }

    fn push(&mut self, record: &Record) {
        let Some(store) = &mut self.store else {
            self.lost += 1;
            return;
        };
        if let Err(error) = store.push(record.wagon, record.unix_s, &record.values) {
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
                let dropped = store.dropped_blocks() + self.lost + self.refused.load(Ordering::Relaxed);
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
        let [second, minute, hour] = self.settings.tiers;
        let retention = Retention {
            second_s: (second.days * DAY_S) as i64,
            minute_s: (minute.days * DAY_S) as i64,
            hour_s: (hour.days * DAY_S) as i64,
            size_bytes: ((second.megabytes + minute.megabytes + hour.megabytes) * 1e6) as u64,
        };
        let Some(store) = &mut self.store else { return };
        if let Err(error) = store.prune(&retention, now().unix_ns.div_euclid(1_000_000_000)) {
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
