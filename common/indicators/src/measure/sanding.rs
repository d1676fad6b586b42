//! What sand does: adhesion in slides with sand over adhesion in slides without.

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
}

impl Sanding {
    /// Takes in an instant that holds for `dt_s`: sand from 0 to 1, and the adhesion of the wheelsets that slide, if any do.
    pub fn add(&mut self, dt_s: f64, sand: f64, sliding: Option<f64>, memory_s: f64) {
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
        self.since_change_s = if now == self.was { self.since_change_s + dt_s } else { 0.0 };
        self.was = now;
        let Some(adhesion) = sliding.filter(|_| self.since_change_s >= DELAY_S) else { return };
        if now > 0.0 {
            self.with.add(dt_s, adhesion);
        } else if now < 0.0 {
            self.without.add(dt_s, adhesion);
        }
    }

    /// The ratio with the ends of its 95 % interval.
    pub fn ratio(&self) -> Option<(f64, f64, f64)> {
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
                sanding.add(0.01, 0.0, Some(0.06 + wobble), 120.0);
            }
            (0..1000).for_each(|_| sanding.add(0.01, 1.0, Some(0.06 * truth), 120.0));
            let (ratio, low, high) = sanding.ratio().unwrap();
            println!("truth {truth}: {ratio:.3} ({low:.3} to {high:.3})");
            assert!(low <= truth && truth <= high && high - low < 0.2);
        }
    }
}
