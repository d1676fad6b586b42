//! When a dead process is started again, and when its deaths are worth a loud word.

use std::time::{Duration, Instant};

/// The pause after a first death.
const SHORTEST_PAUSE: Duration = Duration::from_millis(50);
/// The pause that repeated deaths lead to.
const LONGEST_PAUSE: Duration = Duration::from_secs(5);
/// A process that lived this long has recovered.
const RECOVERED_AFTER: Duration = Duration::from_secs(10);
/// So many deaths without recovery in between are a crash loop.
const CRASH_LOOP: u32 = 5;

/// Counts the deaths of one process since it last lived long.
#[derive(Debug, Default, Clone, Copy)]
pub(super) struct Restarts {
    deaths: u32,
}

impl Restarts {
    /// Takes note of a death after `lived`; returns the pause before the next start.
    pub(super) fn died(&mut self, lived: Duration) -> Duration {
        if lived >= RECOVERED_AFTER {
            self.deaths = 0;
        }
        self.deaths += 1;
        SHORTEST_PAUSE.saturating_mul(1 << (self.deaths - 1).min(16)).min(LONGEST_PAUSE)
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

    #[test]
    fn pauses_grow_to_a_limit_and_a_long_life_resets_them() {
        let mut restarts = Restarts::default();
        let pauses: Vec<u128> = (0..9).map(|_| restarts.died(Duration::from_secs(1)).as_millis()).collect();
        assert_eq!(pauses, [50, 100, 200, 400, 800, 1600, 3200, 5000, 5000]);
        assert!(restarts.crash_loop());
        assert_eq!(restarts.died(Duration::from_secs(11)).as_millis(), 50);
        assert!(!restarts.crash_loop());
    }
}
