//! What changes slowly and unseen: pad friction and gusts.

use crate::random::{Purpose, Stream};
use crate::scenario::DisturbanceTable;
use railgrip_vehicle::PerWheelset;

/// A stationary first-order Gauss–Markov process.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlowNoise {
    sigma: f64,
    decay: f64,
    value: f64,
}

impl SlowNoise {
    /// A process that is stationary from its first value on.
    pub fn new(sigma: f64, correlation_time_s: f64, period_s: f64, random: &mut Stream) -> Self {
        Self { sigma, decay: (-period_s / correlation_time_s).exp(), value: sigma * random.normal() }
    }

    /// The value after one more period.
    pub fn step(&mut self, random: &mut Stream) -> f64 {
        let shock = self.sigma * (1.0 - self.decay * self.decay).sqrt();
        self.value = self.decay * self.value + shock * random.normal();
        self.value
    }
}

/// The slow disturbances of one wagon.
#[derive(Clone, Debug)]
pub(crate) struct Disturbance {
    random: Stream,
    pad_level: PerWheelset,
    pad: [SlowNoise; railgrip_vehicle::MAX_WHEELSETS],
    gust: SlowNoise,
    /// Pad friction relative to the nominal one.
    pub pad_friction_factor: PerWheelset,
    /// Gust on top of the headwind, m/s.
    pub gust_m_s: f64,
}

impl Disturbance {
    pub fn new(
        table: &DisturbanceTable,
        pad_factors: &[f64],
        period_s: f64,
        seed: u64,
        wagon: usize,
    ) -> Self {
        let mut random = Stream::new(seed, wagon, Purpose::Disturbance);
        let pad_level = std::array::from_fn(|wheelset| {
            let factor = pad_factors.get(wheelset).copied().unwrap_or(1.0);
            factor * (1.0 + table.pad_friction_spread * random.normal()).max(0.1)
        });
        let (sigma, time_s) = (table.pad_friction_sigma, table.pad_friction_time_s);
        let pad = std::array::from_fn(|_| SlowNoise::new(sigma, time_s, period_s, &mut random));
        let gust = SlowNoise::new(table.gust_sigma_m_s, table.gust_time_s, period_s, &mut random);
        let mut disturbance =
            Self { random, pad_level, pad, gust, pad_friction_factor: pad_level, gust_m_s: 0.0 };
        disturbance.step();
        disturbance
    }

    /// Advances by one sample.
    pub fn step(&mut self) {
        for (wheelset, pad) in self.pad.iter_mut().enumerate() {
            self.pad_friction_factor[wheelset] =
                self.pad_level[wheelset] * (1.0 + pad.step(&mut self.random)).max(0.1);
        }
        self.gust_m_s = self.gust.step(&mut self.random);
    }
}
