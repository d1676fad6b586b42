//! The two clocks of a [`Stamp`].

use railgrip_messages::Stamp;
use rustix::time::{ClockId, Timespec, clock_gettime};

/// This instant on both clocks.
#[must_use]
pub fn now() -> Stamp {
    Stamp { unix_ns: nanoseconds(clock_gettime(ClockId::Realtime)), monotonic_ns: monotonic_ns() }
}

/// `CLOCK_MONOTONIC`, ns since boot: the clock for ages and latencies.
#[must_use]
pub fn monotonic_ns() -> u64 {
    nanoseconds(clock_gettime(ClockId::Monotonic)).unsigned_abs()
}

fn nanoseconds(time: Timespec) -> i64 {
    time.tv_sec * 1_000_000_000 + time.tv_nsec
}
