//! When a dead process is started again, and when its deaths are worth a loud word.
//!
//! Who dies at work is back at once, and so is who dies while it starts for the first time. Who dies so again waits longer each
//! time, because starting it costs time that the others need; who dies at work again and again waits a little.

use std::time::{Duration, Instant};

/// A process that was ready for so long had been at work.
const AT_WORK_AFTER: Duration = Duration::from_secs(1);
/// The pause of one that dies at work again and again.
const PAUSE_AT_WORK: Duration = Duration::from_millis(250);
/// The pause after a second death at the start.
const SHORTEST_PAUSE: Duration = Duration::from_millis(50);
/// The pause that repeated deaths at the start lead to.
const LONGEST_PAUSE: Duration = Duration::from_secs(5);
/// A process that lived this long has recovered.
const RECOVERED_AFTER: Duration = Duration::from_secs(10);
/// So many deaths without recovery in between are a crash loop.
const CRASH_LOOP: u32 = 5;

/// Counts the deaths of one process since it last lived long.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct Restarts {
    deaths: u32,
    /// Of these, those at the start since it last worked.
    failed_starts: u32,
}

impl Restarts {
    /// Takes note of a death after `lived`, of which it was ready for `worked`; returns the pause before the next start.
    pub(super) fn died(&mut self, lived: Duration, worked: Duration) -> Duration {
        if lived >= RECOVERED_AFTER {
            *self = Self::default();
        }
        self.deaths += 1;
        if worked >= AT_WORK_AFTER {
            self.failed_starts = 0;
            return if self.crash_loop() { PAUSE_AT_WORK } else { Duration::ZERO };
        }
        self.failed_starts += 1;
        match self.failed_starts.checked_sub(2) {
            None => Duration::ZERO,
            Some(doublings) => SHORTEST_PAUSE.saturating_mul(1 << doublings.min(16)).min(LONGEST_PAUSE),
        }
    }

    /// Deaths in a row, without recovery in between.
    pub(super) const fn deaths(&self) -> u32 {
        self.deaths
    }

    /// True if the process keeps dying.
    pub(super) const fn crash_loop(&self) -> bool {
        self.deaths >= CRASH_LOOP
    }

    /// True if the process keeps dying and has not lived long enough since `started` to be trusted again.
    pub(super) fn still_crashing(&self, started: Option<Instant>) -> bool {
        self.crash_loop() && started.is_none_or(|started| started.elapsed() < RECOVERED_AFTER)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NO_TIME: Duration = Duration::ZERO;

    #[test]
    fn pauses_grow_to_a_limit_and_a_long_life_resets_them() {
        let mut restarts = Restarts::default();
        let pauses: Vec<u128> =
            (0..10).map(|_| restarts.died(Duration::from_secs(1), NO_TIME).as_millis()).collect();
        assert_eq!(pauses, [0, 50, 100, 200, 400, 800, 1600, 3200, 5000, 5000]);
        assert!(restarts.crash_loop());
        assert_eq!(restarts.died(Duration::from_secs(11), NO_TIME), NO_TIME);
        assert!(!restarts.crash_loop());
    }

    #[test]
    fn who_dies_at_work_is_back_at_once_or_soon() {
        let mut restarts = Restarts::default();
        let worked = Duration::from_secs(2);
        let pauses: Vec<u128> =
            (0..6).map(|_| restarts.died(Duration::from_secs(3), worked).as_millis()).collect();
        assert_eq!(pauses, [0, 0, 0, 0, 250, 250]);
        assert!(restarts.crash_loop(), "that is worth a loud word all the same");
        assert_eq!(restarts.died(Duration::from_secs(2), NO_TIME), NO_TIME, "the first failed start");
        assert_eq!(restarts.died(Duration::from_secs(2), NO_TIME).as_millis(), 50, "the second");
        assert_eq!(restarts.died(Duration::from_secs(20), worked), NO_TIME);
        assert!(!restarts.crash_loop());
    }
}
