//! Quantiles of durations without storing them: a histogram with eight cells an octave.

/// Cells an octave: a quantile is right to 9 %.
const PER_OCTAVE: u32 = 8;
/// Octaves from 1 ns on: up to 18 minutes.
const OCTAVES: u32 = 40;
const CELLS: usize = (PER_OCTAVE * OCTAVES) as usize;
/// A window closes after so many durations; quantiles are those of the last closed one and the open one.
const WINDOW: u32 = 10_000;

/// Durations of late, in nanoseconds.
#[derive(Debug, Clone)]
pub struct Histogram {
    open: Box<[u32; CELLS]>,
    closed: Box<[u32; CELLS]>,
    count: u32,
}

impl Default for Histogram {
    fn default() -> Self {
        Self { open: Box::new([0; CELLS]), closed: Box::new([0; CELLS]), count: 0 }
    }
}

impl Histogram {
    /// Counts one duration.
    pub fn add(&mut self, ns: u64) {
        self.open[cell(ns)] += 1;
        self.count += 1;
        if self.count >= WINDOW {
            self.closed = std::mem::replace(&mut self.open, Box::new([0; CELLS]));
            self.count = 0;
        }
    }

    /// The duration below which a share of them lies, ns; 0 before the first.
    #[must_use]
    pub fn quantile_ns(&self, share: f64) -> u64 {
        let counts =
            || self.open.iter().zip(self.closed.iter()).map(|(open, closed)| u64::from(open + closed));
        let total: u64 = counts().sum();
        let wanted = (share * total as f64).ceil().max(1.0) as u64;
        let mut sum = 0;
        for (cell, count) in counts().enumerate() {
            sum += count;
            if sum >= wanted {
                return upper_end_ns(cell);
            }
        }
        0
    }
}

fn cell(ns: u64) -> usize {
    let ns = ns.max(1);
    let octave = ns.ilog2();
    let fraction = (ns << PER_OCTAVE.ilog2() >> octave) as u32 - PER_OCTAVE;
    ((octave * PER_OCTAVE + fraction) as usize).min(CELLS - 1)
}

fn upper_end_ns(cell: usize) -> u64 {
    let (octave, fraction) = (cell as u64 / u64::from(PER_OCTAVE), cell as u64 % u64::from(PER_OCTAVE));
    ((u64::from(PER_OCTAVE) + fraction + 1) << octave) / u64::from(PER_OCTAVE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_right_to_an_eighth_of_an_octave() {
        let mut histogram = Histogram::default();
        assert_eq!(histogram.quantile_ns(0.5), 0);
        for ns in 1..=5000 {
            histogram.add(ns);
        }
        for (share, expected) in [(0.5, 2500.0), (0.99, 4950.0), (0.01, 50.0)] {
            let found = histogram.quantile_ns(share) as f64;
            println!("{share}: {found} for {expected}");
            assert!((1.0..=1.13).contains(&(found / expected)), "{share}: {found} for {expected}");
        }
    }

    #[test]
    fn old_durations_are_forgotten() {
        let mut histogram = Histogram::default();
        (0..WINDOW).for_each(|_| histogram.add(1_000_000));
        (0..2 * WINDOW).for_each(|_| histogram.add(100));
        assert!(histogram.quantile_ns(0.999) < 120);
        histogram.add(u64::MAX);
        assert!(histogram.quantile_ns(1.0) > 1_000_000_000_000);
    }
}
