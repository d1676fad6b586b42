//! What the feeding thread and the requests share.

use crate::history::{History, columns};
use crate::limits::Limits;
use crate::store::Snapshot;
use axum::body::Bytes;
use prometheus_client::encoding::EncodeLabelSet;
use railgrip_indicators::Table;
use railgrip_messages::Stamp;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, PoisonError, RwLock};
use tokio::sync::{broadcast, watch};

/// Events that may wait for a slow reader of the stream; it then gets the whole picture anew.
const WAITING_EVENTS: usize = 64;

/// Ages in an answer are at most so old, s; the feeding thread renews the snapshot more often.
const RENEWED_WITHIN_S: f64 = 0.5;

/// One server-sent event, ready to be sent.
#[derive(Debug, Clone)]
pub struct StreamEvent {
    /// Its name.
    pub name: &'static str,
    /// Its data, JSON.
    pub data: Bytes,
}

/// From what the program is built.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash, EncodeLabelSet)]
pub struct Build {
    /// Its version.
    pub version: &'static str,
    /// The commit of its sources, or `unknown`.
    pub commit: &'static str,
}

/// The latest snapshot and the stream of changes. Clones share.
#[derive(Debug, Clone)]
pub struct Shared {
    inner: Arc<Inner>,
}

#[derive(Debug)]
struct Inner {
    latest: RwLock<Arc<Snapshot>>,
    stream: broadcast::Sender<StreamEvent>,
    closing: watch::Sender<bool>,
    requests: AtomicU64,
    clock: fn() -> Stamp,
    openapi: std::sync::OnceLock<Bytes>,
    history: std::sync::OnceLock<Arc<History>>,
    limits: RwLock<Arc<Limits>>,
    build: std::sync::OnceLock<Build>,
    receiver_states: crate::alerts::notify::ReceiverStates,
    notes: crate::notes::NoteBook,
    table: Table,
}

impl Shared {
    /// Serves `first` until there is a newer snapshot; `clock` tells the time.
    #[must_use]
    pub fn new(first: Snapshot, clock: fn() -> Stamp) -> Self {
        let limits = RwLock::new(Arc::new(Limits::default().with(first.table)));
        let inner = Inner {
            table: first.table,
            latest: RwLock::new(Arc::new(first)),
            stream: broadcast::Sender::new(WAITING_EVENTS),
            closing: watch::Sender::new(false),
            requests: AtomicU64::new(0),
            clock,
            openapi: std::sync::OnceLock::new(),
            history: std::sync::OnceLock::new(),
            limits,
            build: std::sync::OnceLock::new(),
            receiver_states: crate::alerts::notify::ReceiverStates::default(),
            notes: crate::notes::NoteBook::default(),
        };
        Self { inner: Arc::new(inner) }
    }

    /// The latest snapshot. One that nobody renews is aged as it is asked for, so that nothing old passes for the present
    /// even if the feeding thread stands still.
    #[must_use]
    pub fn latest(&self) -> Arc<Snapshot> {
        self.inner.requests.fetch_add(1, Ordering::Relaxed);
        let latest = Arc::clone(&self.inner.latest.read().unwrap_or_else(PoisonError::into_inner));
        let now = self.now();
        if latest.as_of.age_s(now.monotonic_ns) <= RENEWED_WITHIN_S {
            return latest;
        }
        let aged = Arc::new(latest.aged(now));
        let mut current = self.inner.latest.write().unwrap_or_else(PoisonError::into_inner);
        if Arc::ptr_eq(&current, &latest) {
            *current = Arc::clone(&aged);
        }
        aged
    }

    /// Serves `snapshot` from now on.
    pub fn replace(&self, snapshot: Arc<Snapshot>) {
        *self.inner.latest.write().unwrap_or_else(PoisonError::into_inner) = snapshot;
    }

    /// Sends an event to everybody who listens.
    pub fn send(&self, event: StreamEvent) {
        // An error only says that nobody listens.
        let _ = self.inner.stream.send(event);
    }

    /// Names of the indicators that the history holds, or would hold.
    pub(crate) fn fields(&self) -> Vec<String> {
        let wagons = || columns::of(self.table(), railgrip_messages::MAX_WHEELSETS);
        let columns = self.history().map_or_else(wagons, |history| history.columns().to_vec());
        columns.into_iter().map(|column| column.name).collect()
    }

    /// The indicators.
    pub(crate) fn table(&self) -> Table {
        self.inner.table
    }

    /// True if somebody listens.
    #[must_use]
    pub fn has_listeners(&self) -> bool {
        self.inner.stream.receiver_count() > 0
    }

    /// Listens to the events from now on.
    #[must_use]
    pub fn listen(&self) -> broadcast::Receiver<StreamEvent> {
        self.inner.stream.subscribe()
    }

    /// Ends all streams: the service is about to stop.
    pub fn close(&self) {
        self.inner.closing.send_replace(true);
    }

    /// Becomes true when the service is about to stop.
    #[must_use]
    pub fn closing(&self) -> watch::Receiver<bool> {
        self.inner.closing.subscribe()
    }

    /// Requests answered from snapshots so far.
    #[must_use]
    pub fn requests(&self) -> u64 {
        self.inner.requests.load(Ordering::Relaxed)
    }

    /// This instant.
    #[must_use]
    pub fn now(&self) -> Stamp {
        (self.inner.clock)()
    }

    /// Serves this history from now on; only the first one counts.
    pub fn remember(&self, history: Arc<History>) {
        let _ = self.inner.history.set(history);
    }

    /// What is remembered, if anything is.
    #[must_use]
    pub fn history(&self) -> Option<&Arc<History>> {
        self.inner.history.get()
    }

    /// Draws these limits beside the figures from now on.
    pub fn judge_by(&self, limits: Limits) {
        *self.inner.limits.write().unwrap_or_else(PoisonError::into_inner) = Arc::new(limits);
    }

    /// The limits that the pages draw.
    pub(crate) fn limits(&self) -> Arc<Limits> {
        Arc::clone(&self.inner.limits.read().unwrap_or_else(PoisonError::into_inner))
    }

    /// Says from what the program is built; only the first one counts.
    pub fn built_from(&self, build: Build) {
        let _ = self.inner.build.set(build);
    }

    /// From what the program is built.
    #[must_use]
    pub fn build(&self) -> Build {
        self.inner.build.get().copied().unwrap_or_default()
    }

    /// How the receivers of notifications are.
    #[must_use]
    pub fn receiver_states(&self) -> &crate::alerts::notify::ReceiverStates {
        &self.inner.receiver_states
    }

    /// What people wrote down about vehicles.
    #[must_use]
    pub fn notes(&self) -> &crate::notes::NoteBook {
        &self.inner.notes
    }

    pub(crate) fn openapi(&self) -> &std::sync::OnceLock<Bytes> {
        &self.inner.openapi
    }
}
