//! What sand does: adhesion in slides with sand over adhesion in slides without. Sanding long enough while wheelsets slide, soon
//! after they slid without sand, is a test of the sanders; its result is kept until the next one.

use bytemuck::{Pod, Zeroable};

/// From this on there is sand, and below that none.
const SAND: [f64; 2] = [0.05, 0.5];
/// Sand needs so long to get under the wheels, s.
const DELAY_S: f64 = 1.0;
/// Values closer than this say the same thing twice, s.
const INDEPENDENT_S: f64 = 0.5;
/// Sliding that each side needs, s.
const LEAST_S: f64 = 2.0;

/// Means with their scatter over a fading memory.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
struct Moments {
    seconds: f64,
    first: f64,
    second: f64,
}

impl Moments {
    fn fade(&mut self, keep: f64) {
        self.seconds *= keep;
        self.first *= keep;
        self.second *= keep;
    }

    fn add(&mut self, dt_s: f64, value: f64) {
        self.seconds += dt_s;
        self.first += dt_s * value;
        self.second += dt_s * value * value;
    }

    /// Mean, and its relative variance.
    fn mean(&self) -> Option<(f64, f64)> {
        if self.seconds < LEAST_S {
            return None;
        }
        let mean = self.first / self.seconds;
        let variance = (self.second / self.seconds - mean * mean).max(0.0);
        (mean > 0.0).then(|| (mean, variance / (self.seconds / INDEPENDENT_S) / (mean * mean)))
    }
}

/// What is known about sanding.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
pub(crate) struct Sanding {
    with: Moments,
    without: Moments,
    since_change_s: f64,
    was: f64,
    /// Sliding in the running spell of sand, s.
    spell_s: f64,
    /// When the last test ended, ns since 1970; 0 for none.
    tested_unix_ns: i64,
    /// What it found: the ratio with the ends of its interval.
    tested: [f64; 3],
}

/// A ratio of adhesion with sand over that without.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gain {
    pub value: f64,
    pub low: f64,
    pub high: f64,
    /// When the test ended that found it, ns since 1970; `None` while it is being found.
    pub tested_unix_ns: Option<i64>,
}

impl Sanding {
    /// Takes in an instant that holds for `dt_s`: sand from 0 to 1, and the adhesion of the wheelsets that slide, if any do.
    /// `unix_ns` is that instant.
    pub fn add(&mut self, dt_s: f64, sand: f64, sliding: Option<f64>, unix_ns: i64, memory_s: f64) {
        let keep = 1.0 - (dt_s / memory_s).min(1.0);
        self.with.fade(keep);
        self.without.fade(keep);
        let now = if sand >= SAND[1] {
            1.0
        } else if sand <= SAND[0] {
            -1.0
        } else {
            0.0
        };
        if self.was > 0.0 && now <= 0.0 {
            self.end_spell(unix_ns);
        }
        self.since_change_s = if now == self.was { self.since_change_s + dt_s } else { 0.0 };
        self.was = now;
        let Some(adhesion) = sliding.filter(|_| self.since_change_s >= DELAY_S) else { return };
        if now > 0.0 {
            self.with.add(dt_s, adhesion);
            self.spell_s += dt_s;
        } else if now < 0.0 {
            self.without.add(dt_s, adhesion);
        }
    }

    /// The sand stops. What it did is a test if it was long enough for a figure of its own.
    fn end_spell(&mut self, unix_ns: i64) {
        if std::mem::take(&mut self.spell_s) < LEAST_S {
            return;
        }
        if let Some((value, low, high)) = self.ratio() {
            (self.tested, self.tested_unix_ns) = ([value, low, high], unix_ns);
        }
    }

    /// What is found now, else what the last test found.
    pub fn gain(&self) -> Option<Gain> {
        if let Some((value, low, high)) = self.ratio() {
            return Some(Gain { value, low, high, tested_unix_ns: None });
        }
        let [value, low, high] = self.tested;
        (self.tested_unix_ns != 0).then_some(Gain {
            value,
            low,
            high,
            tested_unix_ns: Some(self.tested_unix_ns),
        })
    }

    /// The ratio with the ends of its 95 % interval.
    fn ratio(&self) -> Option<(f64, f64, f64)> {
        let ((with, one), (without, other)) = (self.with.mean()?, self.without.mean()?);
        let (ratio, half) = (with / without, 1.96 * (one + other).sqrt());
        Some((ratio, ratio * (1.0 - half).max(0.0), ratio * (1.0 + half)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sand_that_helps_and_sand_that_does_not_are_told_apart() {
        for truth in [1.0, 1.6] {
            let mut sanding = Sanding::default();
            assert_eq!(sanding.ratio(), None);
            for step in 0..1000 {
                let wobble = 0.004 * (f64::from(step) * 0.11).sin();
                sanding.add(0.01, 0.0, Some(0.06 + wobble), 1, 120.0);
            }
            (0..1000).for_each(|_| sanding.add(0.01, 1.0, Some(0.06 * truth), 2, 120.0));
            let (ratio, low, high) = sanding.ratio().unwrap();
            println!("truth {truth}: {ratio:.3} ({low:.3} to {high:.3})");
            assert!(low <= truth && truth <= high && high - low < 0.2);
            assert_eq!(sanding.gain().unwrap().tested_unix_ns, None, "the test has not ended");
            // The sand stops; much later the comparison has faded, and the test is still known.
            sanding.add(0.01, 0.0, None, 3, 120.0);
            (0..60_000).for_each(|_| sanding.add(0.01, 0.0, None, 4, 120.0));
            let kept = sanding.gain().unwrap();
            assert_eq!((kept.tested_unix_ns, sanding.ratio()), (Some(3), None));
            assert!(kept.low <= truth && truth <= kept.high, "{kept:?}");
            // A puff of sand, and sand where nothing slides, are no tests.
            for sliding in [Some(0.06), None] {
                (0..if sliding.is_some() { 150 } else { 3000 })
                    .for_each(|_| sanding.add(0.01, 1.0, sliding, 5, 120.0));
                sanding.add(0.01, 0.0, sliding, 6, 120.0);
                assert_eq!(sanding.gain(), Some(kept));
            }
        }
    }
}
