//! What a source has counted, by name; shared by the threads that read it.

use railgrip_messages::{MAX_SOURCE_COUNTS, SourceCount};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Counts by the code of their name. Clones count together.
#[derive(Debug, Clone, Default)]
pub struct Tally(Arc<[AtomicU64; MAX_SOURCE_COUNTS]>);

impl Tally {
    /// Adds so many.
    pub fn add(&self, what: SourceCount, count: u64) {
        if let Some(place) = self.0.get(what.code() as usize).filter(|_| count > 0) {
            place.fetch_add(count, Ordering::Relaxed);
        }
    }

    /// Adds what a predecessor had counted.
    pub fn go_on_from(&self, counts: &[u64]) {
        for (place, count) in self.0.iter().zip(counts) {
            place.fetch_add(*count, Ordering::Relaxed);
        }
    }

    /// All counts.
    #[must_use]
    pub fn counts(&self) -> [u64; MAX_SOURCE_COUNTS] {
        std::array::from_fn(|place| self.0[place].load(Ordering::Relaxed))
    }

    /// One count.
    #[must_use]
    pub fn count(&self, what: SourceCount) -> u64 {
        self.counts()[what.code() as usize]
    }
}

/// What a source knows of one wagon, or of itself as a whole.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Account {
    /// By the code of a [`SourceCount`].
    pub counts: [u64; MAX_SOURCE_COUNTS],
    /// How much faster our clock runs than that of the source, parts in a million, once it is known.
    pub drift_ppm: Option<f64>,
}
