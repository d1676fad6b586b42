//! Seeded randomness: one independent stream for each purpose, so that switching an effect off leaves the noise,
//! the wander and the gusts of a run exactly as they were.

use rand::{RngExt, SeedableRng};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

/// A stream of random numbers for one purpose of one run of one case.
#[derive(Debug, Clone)]
pub struct Stream(Pcg64);

impl Stream {
    /// The stream of `purpose` under `seed`; other purposes or indices give unrelated streams.
    #[must_use]
    pub fn new(seed: u64, purpose: &str, index: u64) -> Self {
        let mut key = mix(seed ^ 0x9e37_79b9_7f4a_7c15);
        for byte in purpose.bytes() {
            key = mix(key ^ u64::from(byte));
        }
        Self(Pcg64::seed_from_u64(mix(key.wrapping_add(index.wrapping_mul(0xd134_2543_de82_ef95)))))
    }

    /// Uniform in `[low, high)`.
    pub fn uniform(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    /// Standard normal.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// Plus or minus one, equally likely.
    pub fn sign(&mut self) -> f64 {
        if self.0.random::<f64>() < 0.5 { -1.0 } else { 1.0 }
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        self.0.random::<f64>() < probability
    }

    /// An index below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        self.0.random_range(0..count.max(1))
    }

    /// A seed for further streams.
    pub fn seed(&mut self) -> u64 {
        self.0.random()
    }

    /// The items in random order.
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for last in (1..items.len()).rev() {
            items.swap(last, self.below(last + 1));
        }
    }
}

/// SplitMix64 finaliser (Steele et al. 2014): spreads neighbouring keys over the whole range.
fn mix(key: u64) -> u64 {
    let z = (key ^ (key >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Ornstein–Uhlenbeck process, sampled exactly at a fixed step.
#[derive(Debug, Clone)]
pub struct Wander {
    value: f64,
    keep: f64,
    kick: f64,
    stream: Stream,
}

impl Wander {
    /// A stationary process with this standard deviation and correlation time, advanced by `step_s`.
    #[must_use]
    pub fn new(mut stream: Stream, sigma: f64, correlation_s: f64, step_s: f64) -> Self {
        let keep = (-step_s / correlation_s).exp();
        let value = sigma * stream.normal();
        Self { value, keep, kick: sigma * (1.0 - keep * keep).sqrt(), stream }
    }

    /// Advances one step and returns the new value.
    pub fn advance(&mut self) -> f64 {
        self.value = self.keep * self.value + self.kick * self.stream.normal();
        self.value
    }
}
