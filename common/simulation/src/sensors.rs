//! What the sensors of one wagon make of its state: latency, noise, spikes, holes, digits.

use crate::disturbance::SlowNoise;
use crate::random::{Purpose, Stream};
use crate::scenario::SensorTable;
use railgrip_vehicle::{MAX_WHEELSETS, PerWheelset, Sensors as Declared};
use std::collections::VecDeque;

/// Steps of digits that no scenario changes.
const TORQUE_RESOLUTION_NM: f64 = 1.0;
const GRADE_RESOLUTION_RAD: f64 = 1e-5;
const POSITION_RESOLUTION_M: f64 = 0.01;

/// What sensors measure, without their errors.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Measurand {
    pub v_m_s: f64,
    pub wheel_speed_rad_s: PerWheelset,
    pub pressing_force_n: PerWheelset,
}

/// The sensors of one wagon.
#[derive(Clone, Debug)]
pub(crate) struct Sensors {
    table: SensorTable,
    sigma: Declared,
    wheelsets: usize,
    random: Stream,
    position_bias: SlowNoise,
    /// Newest last; empty where nothing is late.
    past: VecDeque<Measurand>,
    depth: usize,
    step_s: f64,
}

impl Sensors {
    pub fn new(
        table: &SensorTable,
        declared: &Declared,
        wheelsets: usize,
        step_s: f64,
        period_s: f64,
        seed: u64,
        wagon: usize,
    ) -> Self {
        let mut random = Stream::new(seed, wagon, Purpose::Sensors);
        let latest =
            table.speed_latency_s.max(table.wheel_speed_latency_s).max(table.pressing_force_latency_s);
        let depth = if latest > 0.0 { (latest / step_s).round() as usize + 1 } else { 0 };
        let sigma = Declared {
            sample_rate_hz: declared.sample_rate_hz,
            speed_sigma_m_s: table.noise_factor * declared.speed_sigma_m_s,
            wheel_speed_sigma_rad_s: table.noise_factor * declared.wheel_speed_sigma_rad_s,
            pressing_force_sigma_n: table.noise_factor * declared.pressing_force_sigma_n,
        };
        let bias_sigma_m = table.noise_factor * table.position_bias_sigma_m;
        let position_bias = SlowNoise::new(bias_sigma_m, table.position_bias_time_s, period_s, &mut random);
        let past = VecDeque::with_capacity(depth + 1);
        Self { table: table.clone(), sigma, wheelsets, random, position_bias, past, depth, step_s }
    }

    /// Remembers the state of one integration step, for sensors that are late.
    pub fn remember(&mut self, now: Measurand) {
        if self.depth > 0 {
            self.past.push_back(now);
            if self.past.len() > self.depth {
                self.past.pop_front();
            }
        }
    }

    /// Whether [`Sensors::remember`] needs to be called.
    pub fn remembers(&self) -> bool {
        self.depth > 0
    }

    fn delayed(&self, latency_s: f64, now: &Measurand) -> Measurand {
        let back = (latency_s / self.step_s).round() as usize;
        let newest = self.past.len();
        match newest.checked_sub(1) {
            Some(last) if back > 0 => self.past.get(last.saturating_sub(back)).copied().unwrap_or(*now),
            _ => *now,
        }
    }

    /// The readings: delayed, noisy, rounded; NaN where a value is lost. The pressing force comes from a pressure and is never
    /// negative.
    pub fn read(&mut self, now: &Measurand) -> Measurand {
        let mut reading = Measurand::default();
        let v_m_s = self.delayed(self.table.speed_latency_s, now).v_m_s;
        reading.v_m_s = self.cell(v_m_s, self.sigma.speed_sigma_m_s, self.table.speed_resolution_m_s);
        let wheels = self.delayed(self.table.wheel_speed_latency_s, now).wheel_speed_rad_s;
        let forces = self.delayed(self.table.pressing_force_latency_s, now).pressing_force_n;
        let (wheel, force) = (self.sigma.wheel_speed_sigma_rad_s, self.sigma.pressing_force_sigma_n);
        for i in 0..self.wheelsets {
            reading.wheel_speed_rad_s[i] =
                self.cell(wheels[i], wheel, self.table.wheel_speed_resolution_rad_s);
        }
        for i in 0..self.wheelsets {
            let cell = self.cell(forces[i], force, self.table.pressing_force_resolution_n);
            reading.pressing_force_n[i] = if cell < 0.0 { 0.0 } else { cell };
        }
        reading
    }

    fn cell(&mut self, value: f64, sigma: f64, resolution: f64) -> f64 {
        let mut cell = value + sigma * self.random.normal();
        if self.table.spike_probability > 0.0 && self.random.chance(self.table.spike_probability) {
            cell += self.table.spike_sigmas * sigma * self.random.normal().signum();
        }
        if self.table.missing_probability > 0.0 && self.random.chance(self.table.missing_probability) {
            return f64::NAN;
        }
        rounded(cell, resolution)
    }

    /// Position by satellite.
    pub fn position_m(&mut self, position_m: f64) -> f64 {
        let bias_m = self.position_bias.step(&mut self.random);
        let noise_m = self.table.noise_factor * self.table.position_sigma_m * self.random.normal();
        rounded(position_m + bias_m + noise_m, POSITION_RESOLUTION_M)
    }
}

/// Drive torques as the traction unit reports them.
pub(crate) fn torques_nm(torque_nm: &PerWheelset) -> PerWheelset {
    std::array::from_fn::<f64, MAX_WHEELSETS, _>(|i| rounded(torque_nm[i], TORQUE_RESOLUTION_NM))
}

/// Grade as the map has it.
pub(crate) fn grade_rad(grade_rad: f64) -> f64 {
    rounded(grade_rad, GRADE_RESOLUTION_RAD)
}

/// Rounds to the digits of a recorder. Multiplied by the inverse, decimal steps give the shortest decimal numbers.
fn rounded(value: f64, resolution: f64) -> f64 {
    if resolution <= 0.0 {
        return value;
    }
    let inverse = (1.0 / resolution).round();
    let step = |value: f64| {
        if inverse >= 1.0 {
            (value * inverse).round() / inverse
        } else {
            (value / resolution).round() * resolution
        }
    };
    step(value) + 0.0
}
