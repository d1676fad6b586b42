//! Random numbers: a stream of its own for every wagon and purpose, so that nothing disturbs anything else's draws.

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;

/// What a stream is drawn for.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Purpose {
    /// Noise of sensors, and their spikes and holes.
    Sensors = 1,
    /// Slow disturbances.
    Disturbance = 2,
    /// Unevenness of the track (the same for all wagons: wagon 0).
    Track = 3,
}

/// A stream of random numbers.
#[derive(Clone, Debug)]
pub(crate) struct Stream(Pcg64);

impl Stream {
    /// The stream of one wagon (from 0) for one purpose. State and increment are both mixed from all three numbers, since
    /// streams of one PCG that share their state are correlated.
    pub fn new(seed: u64, wagon: usize, purpose: Purpose) -> Self {
        let mut key = mix(mix(mix(seed).wrapping_add(wagon as u64)).wrapping_add(purpose as u64));
        let mut next = || {
            key = mix(key);
            u128::from(key)
        };
        let state = next() << 64 | next();
        let stream = next() << 64 | next();
        Self(Pcg64::new(state, stream))
    }

    /// A draw from the standard normal distribution.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// True with this probability.
    pub fn chance(&mut self, probability: f64) -> bool {
        let uniform: f64 = rand_distr::StandardUniform.sample(&mut self.0);
        uniform < probability
    }
}

/// Mixes 64 bits (finaliser of SplitMix64, Steele et al. 2014).
pub(crate) fn mix(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}
