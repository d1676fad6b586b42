//! What a wagon's recorder gets: readings with noise, colour, bias, drift, delay, eccentricity, rounding and gaps.

use std::f64::consts::TAU;

use crate::random::{Stream, Wander};

use super::{faults::WagonDefects, units::PerWheelset};

/// Longest delay that is kept, s.
const LONGEST_DELAY_S: f64 = 1.0;
/// Healthy channels lose a reading so often a second.
const GAPS_PER_S: f64 = 1.0 / 1500.0;
/// A bad tachometer loses readings for so long at a time, s.
const BAD_GAP_S: (f64, f64) = (0.05, 0.8);

/// Sensors of one wagon, as installed.
#[derive(Debug, Clone, Copy)]
pub struct SensorPlan {
    /// Noise of vehicle speed, wheel speed and pressing force over what the file says.
    pub noise: f64,
    /// Share of the noise that is coloured, and its correlation time, s.
    pub colour: (f64, f64),
    /// Error of the vehicle speed's scale.
    pub v_scale: f64,
    /// Lag of vehicle speed and wheel speed readings, s.
    pub lag_s: (f64, f64),
    /// Eccentricity of each tachometer.
    pub eccentricity: PerWheelset,
    /// Offset of each pressure reading, N, and its drift, N/h.
    pub pressing_offset_n: (PerWheelset, f64),
    /// Error of the drive torque's scale.
    pub torque_scale: f64,
    /// Bias of the position, m, and its period, s.
    pub position_bias: (f64, f64),
    /// Whether load is measured, and the error of its scale.
    pub load_scale: Option<f64>,
    /// Resolution of wheel speed (rad/s) and pressing force (N).
    pub resolution: (f64, f64),
    /// One sigma of speed (m/s), wheel speed (rad/s) and pressing force (N), as in the file.
    pub sigma: (f64, f64, f64),
}

/// One row of a wagon's recording; what was not measured is NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Time, s.
    pub time_s: f64,
    /// Vehicle speed, m/s.
    pub v_m_s: f64,
    /// Wheel speeds, front first, rad/s.
    pub wheel_speed_rad_s: PerWheelset,
    /// Pressing forces inferred from cylinder pressure, N.
    pub pressing_force_n: PerWheelset,
    /// Drive torques, braking negative, N m.
    pub drive_torque_nm: PerWheelset,
    /// Slope as the map gives it, rad.
    pub grade_rad: f64,
    /// 1 while the sander runs.
    pub sanding: f64,
    /// Position by satellite, m.
    pub position_m: f64,
    /// Mass on the springs and below, kg.
    pub load_kg: f64,
    /// Brake ordered, 0 to 1.
    pub brake_demand: f64,
}

/// What the sensors look at.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen<'a> {
    pub(crate) time_s: f64,
    pub(crate) cylinder_n: &'a PerWheelset,
    pub(crate) full_force_n: &'a PerWheelset,
    pub(crate) drive_nm: &'a PerWheelset,
    pub(crate) map_rad: f64,
    pub(crate) sanding: bool,
    pub(crate) position_m: f64,
    pub(crate) mass_kg: f64,
    pub(crate) brake_demand: f64,
}

/// A value some time ago.
#[derive(Debug, Clone)]
struct Memory {
    values: Vec<f64>,
    next: usize,
    tick_s: f64,
}

impl Memory {
    fn new(tick_s: f64) -> Self {
        Self { values: vec![0.0; (LONGEST_DELAY_S / tick_s) as usize + 2], next: 0, tick_s }
    }

    fn keep(&mut self, value: f64) {
        self.values[self.next] = value;
        self.next = (self.next + 1) % self.values.len();
    }

    fn ago(&self, delay_s: f64) -> f64 {
        let count = self.values.len();
        let back = ((delay_s / self.tick_s).round() as usize).min(count - 2) + 1;
        self.values[(self.next + count - back) % count]
    }
}

/// When readings of one channel are missing.
#[derive(Debug, Clone, Copy)]
struct Gap {
    from_s: f64,
    to_s: f64,
}

/// Sensors at work.
#[derive(Debug, Clone)]
pub(crate) struct Sensors {
    plan: SensorPlan,
    wheelsets: usize,
    tick_s: f64,
    noise: Stream,
    chance: Stream,
    colour: [Wander; 5],
    lagged_v: f64,
    lagged: PerWheelset,
    angle_rad: PerWheelset,
    ring: PerWheelset,
    memory: [Option<Memory>; 5],
    gaps: [Gap; 9],
}

impl Sensors {
    /// `defects` are all that this wagon will ever have, to know which memories are needed.
    pub(crate) fn new(
        plan: SensorPlan,
        wheelsets: usize,
        defects: &WagonDefects,
        (seed, wagon): (u64, usize),
        (tick_s, sample_s): (f64, f64),
    ) -> Self {
        let colour = |k: usize| {
            let stream = Stream::new(seed, "colour", (8 * wagon + k) as u64);
            Wander::new(stream, 1.0, plan.colour.1, sample_s)
        };
        let late = |channel: usize| {
            let delay_s =
                if channel == 4 { defects.v_delay_s } else { defects.wheelset[channel].speed_delay_s };
            (delay_s > 0.0).then(|| Memory::new(tick_s))
        };
        let mut chance = Stream::new(seed, "gaps", wagon as u64);
        let gaps = std::array::from_fn(|_| Gap::after(0.0, GAPS_PER_S, (0.02, 0.3), &mut chance));
        let mut phase = Stream::new(seed, "phase", wagon as u64);
        Self {
            plan,
            wheelsets,
            tick_s,
            noise: Stream::new(seed, "sensor noise", wagon as u64),
            chance,
            colour: std::array::from_fn(colour),
            lagged_v: 0.0,
            lagged: [0.0; 4],
            angle_rad: std::array::from_fn(|_| phase.uniform(0.0, TAU)),
            ring: [0.0; 4],
            memory: std::array::from_fn(late),
            gaps,
        }
    }

    /// Follows the true motion; every tick.
    pub(crate) fn follow(&mut self, v_m_s: f64, wheel_speed_rad_s: &PerWheelset, defects: &WagonDefects) {
        let (v_lag_s, wheel_lag_s) = self.plan.lag_s;
        self.lagged_v += self.tick_s / (self.tick_s + v_lag_s) * (v_m_s - self.lagged_v);
        for k in 0..self.wheelsets {
            let omega = wheel_speed_rad_s[k];
            let before = self.angle_rad[k];
            let turn = before + self.tick_s * omega;
            self.angle_rad[k] = turn.rem_euclid(TAU);
            // A flat hits once a turn; wheelset and reading ring for some hundredths of a second.
            self.ring[k] *= (-self.tick_s / 0.02).exp();
            let flat_mm = defects.wheelset[k].flat_mm;
            if flat_mm > 0.0 && !(0.0..TAU).contains(&turn) {
                self.ring[k] = 3e-4 * flat_mm * omega * self.noise.uniform(0.7, 1.0) * self.noise.sign();
            }
            let share = self.plan.eccentricity[k] + defects.wheelset[k].eccentricity;
            let shown = omega * (1.0 + share * self.angle_rad[k].sin()) + self.ring[k];
            self.lagged[k] += self.tick_s / (self.tick_s + wheel_lag_s) * (shown - self.lagged[k]);
            if let Some(memory) = &mut self.memory[k] {
                memory.keep(self.lagged[k]);
            }
        }
        if let Some(memory) = &mut self.memory[4] {
            memory.keep(self.lagged_v);
        }
    }

    /// Rim speeds as the slide protection sees them, m/s; NaN where a tachometer gives nothing.
    pub(crate) fn rims_m_s(&self, time_s: f64, radius_m: f64, defects: &WagonDefects) -> PerWheelset {
        std::array::from_fn(|k| {
            if k < self.wheelsets && !self.missing(k, time_s, defects) {
                self.lagged[k] * radius_m
            } else {
                f64::NAN
            }
        })
    }

    fn missing(&self, wheelset: usize, time_s: f64, defects: &WagonDefects) -> bool {
        defects.wheelset[wheelset].speed_missing >= 1.0 || self.gaps[wheelset].holds(time_s)
    }

    /// One row.
    pub(crate) fn read(&mut self, seen: &Seen<'_>, defects: &WagonDefects) -> Reading {
        let time_s = seen.time_s;
        self.renew_gaps(time_s, defects);
        let nothing = [f64::NAN; 4];
        let mut reading = Reading {
            time_s,
            v_m_s: f64::NAN,
            wheel_speed_rad_s: nothing,
            pressing_force_n: nothing,
            drive_torque_nm: nothing,
            grade_rad: f64::NAN,
            sanding: f64::NAN,
            position_m: f64::NAN,
            load_kg: f64::NAN,
            brake_demand: f64::NAN,
        };
        let (v_sigma, _, _) = self.plan.sigma;
        let v_noise = self.noise(4, v_sigma);
        let wheel_noise: PerWheelset = std::array::from_fn(|k| self.noise(k, self.plan.sigma.1));
        let bias_m = self.plan.position_bias.0 * (TAU * time_s / self.plan.position_bias.1).sin();
        let position_m = seen.position_m + bias_m + 0.3 * self.noise.normal();
        let press_noise: PerWheelset =
            std::array::from_fn(|_| self.plan.noise * self.plan.sigma.2 * self.noise.normal());
        let load_noise = self.noise.normal();
        if defects.silent {
            return reading;
        }
        if !self.gaps[8].holds(time_s) {
            let v_m_s = self.memory[4].as_ref().map_or(self.lagged_v, |memory| memory.ago(defects.v_delay_s));
            reading.v_m_s = v_m_s * (1.0 + self.plan.v_scale + defects.v_scale) + v_noise;
        }
        for k in 0..self.wheelsets {
            let defect = &defects.wheelset[k];
            if !self.missing(k, time_s, defects) {
                let delayed = self.memory[k].as_ref().map(|memory| memory.ago(defect.speed_delay_s));
                reading.wheel_speed_rad_s[k] =
                    stepped(delayed.unwrap_or(self.lagged[k]) + wheel_noise[k], self.plan.resolution.0);
            }
            if !self.gaps[4 + k].holds(time_s) {
                let (offset_n, drift_n_per_h) =
                    (self.plan.pressing_offset_n.0[k], self.plan.pressing_offset_n.1);
                let wrong_n = defect.pressure_offset * seen.full_force_n[k];
                let force_n = seen.cylinder_n[k] + offset_n + drift_n_per_h * time_s / 3600.0 + wrong_n;
                reading.pressing_force_n[k] =
                    stepped((force_n + press_noise[k]).max(0.0), self.plan.resolution.1);
            }
            reading.drive_torque_nm[k] = seen.drive_nm[k] * (1.0 + self.plan.torque_scale);
        }
        reading.grade_rad = seen.map_rad;
        reading.sanding = f64::from(u8::from(seen.sanding));
        reading.position_m = position_m;
        reading.brake_demand = seen.brake_demand;
        if let Some(scale) = self.plan.load_scale {
            reading.load_kg = seen.mass_kg * (1.0 + scale + 0.02 * load_noise);
        }
        reading
    }

    /// White and coloured noise of a channel with this standard deviation.
    fn noise(&mut self, channel: usize, sigma: f64) -> f64 {
        let share = self.plan.colour.0;
        let coloured = self.colour[channel].advance();
        sigma * self.plan.noise * (share * coloured + (1.0 - share * share).sqrt() * self.noise.normal())
    }

    fn renew_gaps(&mut self, time_s: f64, defects: &WagonDefects) {
        for channel in 0..self.gaps.len() {
            let missing = if channel < 4 { defects.wheelset[channel].speed_missing } else { 0.0 };
            let bad = missing > 0.0 && missing < 1.0;
            let over = time_s > self.gaps[channel].to_s;
            // A tachometer that goes bad does not wait for the next gap of its healthy days.
            if over || (bad && self.gaps[channel].from_s > time_s + 60.0) {
                let mean_s = 0.5 * (BAD_GAP_S.0 + BAD_GAP_S.1);
                let (rate, length_s) = if bad {
                    (missing / (1.0 - missing) / mean_s, BAD_GAP_S)
                } else {
                    (GAPS_PER_S, (0.02, 0.3))
                };
                self.gaps[channel] = Gap::after(time_s, rate, length_s, &mut self.chance);
            }
        }
    }
}

fn stepped(value: f64, resolution: f64) -> f64 {
    (value / resolution).round() * resolution
}

impl Gap {
    /// The next gap after a time, at so many a second.
    fn after(time_s: f64, rate: f64, length_s: (f64, f64), chance: &mut Stream) -> Self {
        let from_s = time_s - chance.uniform(f64::EPSILON, 1.0).ln() / rate;
        Self { from_s, to_s: from_s + chance.uniform(length_s.0, length_s.1) }
    }

    fn holds(&self, time_s: f64) -> bool {
        (self.from_s..self.to_s).contains(&time_s)
    }
}
