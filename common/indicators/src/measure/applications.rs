//! Brake applications: when they begin, and how long the brake takes to build up.
//!
//! An application begins when the pressing force of all wheelsets together passes a threshold after the brake was off. Its
//! level is where the force comes to rest; the response time runs from the beginning to 90 % of that level.

use bytemuck::{Pod, Zeroable};
use railgrip_messages::Stamp;

/// Time between two kept forces, s.
const PLACE_S: f64 = 0.125;
/// Forces kept of one application.
const PLACES: usize = 128;
/// The brake must have been off for so long, s, before it can be applied anew.
const OFF_S: f64 = 1.0;
/// Response times kept.
const KEPT: usize = 15;
/// The level is a mean over so many places.
const LEVEL_PLACES: usize = 8;
/// It rests when two such means in a row differ by less than this share.
const REST_SHARE: f64 = 0.01;
/// Share of the level that ends the response.
const RESPONSE_SHARE: f64 = 0.9;

/// Applications of one wagon so far.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub(crate) struct Applications {
    /// How many.
    pub count: u64,
    /// When the latest began.
    pub began_unix_ns: i64,
    /// The same by the monotonic clock.
    pub began_monotonic_ns: u64,
    /// Response times known so far.
    pub known: u64,
    times_s: [f64; KEPT],
    off_s: f64,
    /// Seconds since the running application began; negative when none is being watched.
    since_s: f64,
    place: u64,
    in_place_s: f64,
    force_n: [f64; PLACES],
}

impl Default for Applications {
    fn default() -> Self {
        Self { off_s: OFF_S, since_s: -1.0, ..Self::zeroed() }
    }
}

impl Applications {
    /// When the latest application began; zeros before the first.
    pub const fn began(&self) -> Stamp {
        Stamp { unix_ns: self.began_unix_ns, monotonic_ns: self.began_monotonic_ns }
    }

    /// Takes in the force of all wheelsets; `disturbed` while slide protection works on it.
    pub fn add(&mut self, dt_s: f64, force_n: f64, threshold_n: f64, disturbed: bool, stamp: Stamp) {
        if !force_n.is_finite() {
            return;
        }
        if force_n < threshold_n {
            self.off_s += dt_s;
            self.since_s = -1.0;
            return;
        }
        if self.off_s >= OFF_S {
            self.count += 1;
            (self.began_unix_ns, self.began_monotonic_ns) = (stamp.unix_ns, stamp.monotonic_ns);
            (self.since_s, self.place, self.in_place_s) = (0.0, 0, 0.0);
        }
        self.off_s = 0.0;
        if self.since_s < 0.0 {
            return;
        }
        self.since_s += dt_s;
        self.in_place_s += dt_s;
        if disturbed {
            self.since_s = -1.0;
        } else if self.in_place_s >= PLACE_S {
            self.in_place_s -= PLACE_S;
            self.keep(force_n);
        }
    }

    fn keep(&mut self, force_n: f64) {
        let place = self.place as usize % PLACES;
        self.force_n[place] = force_n;
        self.place = place as u64 + 1;
        let places = place + 1;
        if places >= 2 * LEVEL_PLACES {
            let mean = |from: usize| {
                self.force_n[from..from + LEVEL_PLACES].iter().sum::<f64>() / LEVEL_PLACES as f64
            };
            let (before, level) = (mean(places - 2 * LEVEL_PLACES), mean(places - LEVEL_PLACES));
            if (level - before).abs() <= REST_SHARE * level {
                let reached =
                    self.force_n[..places].iter().position(|force_n| *force_n >= RESPONSE_SHARE * level);
                if let Some(reached) = reached {
                    self.times_s[(self.known % KEPT as u64) as usize] = (reached + 1) as f64 * PLACE_S;
                    self.known += 1;
                }
                self.since_s = -1.0;
            }
        }
        if places >= PLACES {
            // It never came to rest: a driver's hand, not the brake.
            self.since_s = -1.0;
        }
    }

    /// Median response time with the interval that holds it with 95 % (order statistics, binomial), s; `None` before the
    /// third.
    pub fn response_s(&self) -> Option<(f64, f64, f64)> {
        let count = (self.known as usize).min(KEPT);
        if count < 3 {
            return None;
        }
        let mut times = self.times_s;
        let times = &mut times[..count];
        times.sort_by(f64::total_cmp);
        // Ranks l and n + 1 − l hold the median with at least 95 %; below six values no ranks do, and all are taken.
        let rank = match count {
            0..=8 => 0,
            9..=11 => 1,
            12..=14 => 2,
            _ => 3,
        };
        Some((times[count / 2], times[rank], times[count - 1 - rank]))
    }

    /// True if these are numbers that make sense; a snapshot may bring anything.
    pub fn is_sound(&self) -> bool {
        self.off_s.is_finite() && self.since_s.is_finite() && self.times_s.iter().all(|time| time.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Applications that fill with a time constant, 10 s on and 10 s off.
    fn applied(time_constant_s: f64, times: usize) -> Applications {
        let mut applications = Applications::default();
        for application in 0..times {
            for step in 0..2000 {
                let t_s = f64::from(step) * 0.01;
                let on = t_s < 10.0;
                let force_n = if on { 80e3 * (1.0 - (-t_s / time_constant_s).exp()) } else { 0.0 };
                let monotonic_ns = (application * 2000 + step as usize) as u64 * 10_000_000;
                applications.add(0.01, force_n, 4e3, false, Stamp { unix_ns: 0, monotonic_ns });
            }
        }
        applications
    }

    #[test]
    fn the_time_of_a_first_order_brake_is_found() {
        for time_constant_s in [0.5, 1.3, 2.0] {
            let applications = applied(time_constant_s, 5);
            let (median, low, high) = applications.response_s().unwrap();
            // From 5 % to 90 % of the level.
            let expected = time_constant_s * ((0.95f64 / 0.10).ln());
            println!(
                "time constant {time_constant_s} s: response {median:.2} s ({low:.2} to {high:.2}), expected {expected:.2}"
            );
            assert!((median - expected).abs() < 0.3);
            assert_eq!(applications.count, 5);
            let began_s = applications.began_monotonic_ns as f64 * 1e-9;
            assert!((began_s - 80.0).abs() < 0.2, "{began_s}");
        }
    }

    #[test]
    fn slide_protection_and_a_slow_hand_give_no_time() {
        let mut applications = Applications::default();
        for step in 0..4000 {
            let force_n = 40.0 * f64::from(step);
            applications.add(0.01, force_n, 4e3, false, Stamp::default());
        }
        assert_eq!((applications.count, applications.known), (1, 0));
        let mut applications = Applications::default();
        (0..1000).for_each(|_| applications.add(0.01, 80e3, 4e3, true, Stamp::default()));
        assert_eq!((applications.count, applications.known), (1, 0));
    }
}
