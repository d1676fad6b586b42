//! How often recordings are gone through, and for how long: what a diagnosis spends its time on, for whoever makes it faster.
//!
//! Counted for the process, in whatever thread: a pass adds to two counters when it ends, which is nothing beside the pass.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// A way in which a run is gone through.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// A filter that computes its gains.
    Gains,
    /// A filter with frozen gains.
    Frozen,
    /// A filter with frozen gains that leaves its path.
    Path,
    /// Another model's response along such a path.
    Response,
    /// The windows of the gap, driven open loop.
    Windows,
    /// A filter with one place of the equations freed.
    Freed,
}

impl Pass {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Gains, Self::Frozen, Self::Path, Self::Response, Self::Windows, Self::Freed];
}

/// What was spent on passes of one kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Spent {
    /// Samples that were gone through.
    pub samples: u64,
    /// Time of the threads that did, ns.
    pub nanoseconds: u64,
}

impl Spent {
    /// What was spent since `before`.
    #[must_use]
    pub fn since(self, before: Self) -> Self {
        Self {
            samples: self.samples.wrapping_sub(before.samples),
            nanoseconds: self.nanoseconds.wrapping_sub(before.nanoseconds),
        }
    }
}

static SAMPLES: [AtomicU64; Pass::ALL.len()] = [const { AtomicU64::new(0) }; Pass::ALL.len()];
static NANOSECONDS: [AtomicU64; Pass::ALL.len()] = [const { AtomicU64::new(0) }; Pass::ALL.len()];

/// What this process has spent so far, in the order of [`Pass::ALL`].
pub fn spent() -> [Spent; Pass::ALL.len()] {
    std::array::from_fn(|kind| Spent {
        samples: SAMPLES[kind].load(Ordering::Relaxed),
        nanoseconds: NANOSECONDS[kind].load(Ordering::Relaxed),
    })
}

/// Goes through so many samples, and counts it.
pub(super) fn counted<T>(kind: Pass, samples: usize, go: impl FnOnce() -> T) -> T {
    let started = Instant::now();
    let answer = go();
    let nanoseconds = u64::try_from(started.elapsed().as_nanos()).unwrap_or(u64::MAX);
    SAMPLES[kind as usize].fetch_add(samples as u64, Ordering::Relaxed);
    NANOSECONDS[kind as usize].fetch_add(nanoseconds, Ordering::Relaxed);
    answer
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pass_is_counted_as_what_it_is() {
        // Other tests of this process go through runs as well, but none frees a place of so many samples.
        let many = 1 << 40;
        let before = spent();
        assert_eq!(counted(Pass::Freed, many, || 7), 7);
        let after = spent();
        for (kind, (after, before)) in Pass::ALL.into_iter().zip(after.into_iter().zip(before)) {
            let spent = after.since(before);
            assert_eq!(kind == Pass::Freed, spent.samples >= many as u64, "{kind:?}: {spent:?}");
        }
    }
}
