//! When the next batch leaves: absolute deadlines on the monotonic clock.

use railgrip_bus::{Lifecycle, monotonic_ns, now};
use railgrip_messages::Stamp;
use std::time::Duration;

/// Shortest tick; what is due within it leaves together.
const SHORTEST_TICK_S: f64 = 0.001;
/// Longest sleep between two looks at the stop flag.
const LONGEST_SLEEP: Duration = Duration::from_millis(100);
/// Being so far behind means that the process was stopped: the time lost is not caught up.
const GIVE_UP_S: f64 = 1.0;
/// A sample that is due in less than this is due now.
const TOLERANCE_S: f64 = 1e-6;

/// Ties the time of a source (seconds since its start) to the clock.
#[derive(Debug, Clone)]
pub(crate) struct Pace {
    start_ns: u64,
    tick_s: f64,
    speed: f64,
    ticks: u64,
}

impl Pace {
    /// Starts now, with a tick of `batch_s`, `speed` seconds of the source in a second.
    pub fn new(batch_s: f64, speed: f64) -> Self {
        Self { start_ns: monotonic_ns(), tick_s: batch_s.max(SHORTEST_TICK_S), speed, ticks: 0 }
    }

    /// Sleeps until the next tick; gives the time of the source up to which everything is due.
    pub fn wait(&mut self, lifecycle: &Lifecycle) -> f64 {
        self.ticks += 1;
        let deadline_ns = self.start_ns + (self.ticks as f64 * self.tick_s * 1e9) as u64;
        while !lifecycle.should_stop() {
            let left = Duration::from_nanos(deadline_ns.saturating_sub(monotonic_ns()));
            if left.is_zero() {
                break;
            }
            std::thread::sleep(left.min(LONGEST_SLEEP));
        }
        self.ticks as f64 * self.tick_s * self.speed + TOLERANCE_S
    }

    /// After a long stop: moves the start so that `until_s` is now; gives the seconds that were lost.
    pub fn catch_up(&mut self, until_s: f64) -> Option<f64> {
        let behind_s = (monotonic_ns() - self.start_ns) as f64 * 1e-9 - until_s / self.speed;
        if behind_s < GIVE_UP_S {
            return None;
        }
        self.start_ns += (behind_s * 1e9) as u64;
        Some(behind_s)
    }

    /// The stamp of a sample that was due then; never in the future.
    pub fn stamp(&self, due_s: f64) -> Stamp {
        let mut stamp = now();
        let due_ns = self.start_ns + (due_s / self.speed * 1e9).max(0.0) as u64;
        let age_ns = stamp.monotonic_ns.saturating_sub(due_ns);
        stamp.monotonic_ns -= age_ns;
        stamp.unix_ns -= i64::try_from(age_ns).unwrap_or(0);
        stamp
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deadlines_do_not_drift_when_a_round_takes_long() {
        let lifecycle = Lifecycle::new();
        let mut pace = Pace::new(0.005, 2.0);
        let begin_ns = pace.start_ns;
        for tick in 1..=20 {
            let until_s = pace.wait(&lifecycle);
            assert!((until_s - f64::from(tick) * 0.01).abs() < 1e-5, "{until_s}");
            if tick == 5 {
                std::thread::sleep(Duration::from_millis(12));
            }
        }
        let elapsed_s = (monotonic_ns() - begin_ns) as f64 * 1e-9;
        println!("20 ticks of 5 ms, one of them 12 ms late: {:.1} ms", elapsed_s * 1e3);
        assert!(elapsed_s >= 0.1);
        assert_eq!(pace.catch_up(0.2), None);
    }

    #[test]
    fn a_stamp_is_the_instant_at_which_the_sample_was_due() {
        let mut pace = Pace::new(0.01, 1.0);
        pace.wait(&Lifecycle::new());
        let stamp = pace.stamp(0.004);
        assert_eq!(stamp.monotonic_ns, pace.start_ns + 4_000_000);
        let future = pace.stamp(60.0);
        assert!(future.monotonic_ns <= monotonic_ns());
    }

    #[test]
    fn a_long_stop_is_not_caught_up() {
        let mut pace = Pace::new(0.01, 1.0);
        pace.start_ns -= 5_000_000_000;
        let lost_s = pace.catch_up(0.01).unwrap();
        assert!((lost_s - 4.99).abs() < 0.1, "{lost_s}");
        assert_eq!(pace.catch_up(0.01), None);
    }
}
