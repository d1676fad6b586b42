//! Whose turn it is to have an export: one at a time, and a receiver that is slow gives way to one that waits.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// An export keeps its turn for so long whatever its pace.
const GRACE: Duration = Duration::from_secs(5);
/// And as long as its receiver takes so many bytes a second on the whole: a mobile link does.
const PACE_BYTES_PER_S: f64 = 64.0 * 1024.0;

/// The one export that may be under way.
#[derive(Debug, Default)]
pub(crate) struct Exports {
    current: Mutex<Option<Arc<Under>>>,
}

/// An export under way.
#[derive(Debug)]
struct Under {
    began: Instant,
    bytes: AtomicU64,
    over: AtomicBool,
}

/// The turn of one export; it ends when dropped.
#[derive(Debug)]
pub(crate) struct Turn(Arc<Under>);

impl Exports {
    /// The turn, if nobody has it or whoever has it is slow.
    pub(crate) fn take(&self) -> Option<Turn> {
        let mut current = self.current.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(other) = current.as_ref().filter(|other| !other.is_over()) {
            if !other.is_slow(other.began.elapsed()) {
                return None;
            }
            other.over.store(true, Ordering::Relaxed);
        }
        let under = Under { began: Instant::now(), bytes: AtomicU64::new(0), over: AtomicBool::new(false) };
        let under = Arc::new(under);
        *current = Some(Arc::clone(&under));
        Some(Turn(under))
    }
}

impl Under {
    fn is_over(&self) -> bool {
        self.over.load(Ordering::Relaxed)
    }

    fn is_slow(&self, after: Duration) -> bool {
        let bytes = self.bytes.load(Ordering::Relaxed) as f64;
        after > GRACE && bytes < PACE_BYTES_PER_S * (after - GRACE).as_secs_f64()
    }
}

impl Turn {
    /// Notes what the receiver took.
    pub(crate) fn sent(&self, bytes: usize) {
        self.0.bytes.fetch_add(bytes as u64, Ordering::Relaxed);
    }

    /// Whether another has taken the turn.
    pub(crate) fn is_over(&self) -> bool {
        self.0.is_over()
    }
}

impl Drop for Turn {
    fn drop(&mut self) {
        self.0.over.store(true, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_at_a_time_and_the_slow_give_way() {
        let exports = Exports::default();
        let first = exports.take().expect("the first");
        assert!(exports.take().is_none(), "one at a time");
        let after = GRACE + Duration::from_secs(10);
        first.sent(700_000);
        assert!(!first.0.is_slow(after) && !Under::is_slow(&first.0, GRACE));
        assert!(first.0.is_slow(after + Duration::from_secs(10)));
        drop(first);
        let began = Instant::now().checked_sub(after).expect("the machine runs for longer");
        let slow = Under { began, bytes: AtomicU64::new(130_000), over: AtomicBool::new(false) };
        let slow = Turn(Arc::new(slow));
        *exports.current.lock().expect("lock") = Some(Arc::clone(&slow.0));
        let next = exports.take().expect("the slow one gives way");
        assert!(slow.is_over() && !next.is_over());
        drop(slow);
        assert!(exports.take().is_none(), "the end of the slow one is not that of the next");
    }
}
