//! Sensors of the rig: pulse counters, torque transducer, load cell.
//!
//! Noise comes in as standard normal numbers, so that who simulates keeps the seed.

use super::{BOGIE_WHEELSETS, BogieRigStep};
use std::f64::consts::TAU;

/// Constants of the sensors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorParameters {
    /// Pulses a revolution of the motor shaft.
    pub roller_pulses_per_rev: f64,
    /// Window of the rollers' counter, s.
    pub roller_window_s: f64,
    /// Pulses a revolution of a wheelset.
    pub wheel_pulses_per_rev: f64,
    /// Window of the wheelsets' counters and period of the analogue inputs, s.
    pub sample_period_s: f64,
    /// Zero error of the transducer, N m.
    pub torque_offset_nm: f64,
    /// Zero error of the load cell, N.
    pub load_cell_offset_n: f64,
    /// Torque that the transducer can tell, N m.
    pub torque_capacity_nm: f64,
    /// Force that the load cell can tell, N.
    pub load_cell_capacity_n: f64,
    /// One sigma of the transducer at no torque, N m, and its growth as a share of the torque.
    pub torque_sigma: (f64, f64),
    /// One sigma of the load cell under load, N, and that of its link's rattle, which a force of
    /// 250 N damps to 37 %, N.
    pub load_cell_sigma_n: (f64, f64),
}

/// Force over which the rattle of the link fades, N. Chosen after the paper's Fig. 8.
const RATTLE_FADES_N: f64 = 250.0;

impl Default for SensorParameters {
    /// From the paper: 90 pulses a revolution counted for 0.125 s, acquisition at 100 Hz, 100 N m, 500 kg. Chosen:
    /// wheelset encoders of 3600 pulses counted at 100 Hz (slip beyond the peak grows within some 30 ms; nothing could
    /// hold it from counts at 8 Hz), zero errors of 0.3 % of capacity, and noise after the paper's Fig. 8: the transducer
    /// jitters more under load, the link rattles until it is loaded.
    fn default() -> Self {
        Self {
            roller_pulses_per_rev: 90.0,
            roller_window_s: 0.125,
            wheel_pulses_per_rev: 3600.0,
            sample_period_s: 0.01,
            torque_offset_nm: 0.3,
            load_cell_offset_n: -15.0,
            torque_capacity_nm: 100.0,
            load_cell_capacity_n: 500.0 * crate::GRAVITY_M_S2,
            torque_sigma: (0.4, 0.02),
            load_cell_sigma_n: (12.0, 40.0),
        }
    }
}

impl SensorParameters {
    /// One sigma of the transducer at a torque, N m.
    pub fn torque_sigma_nm(&self, torque_nm: f64) -> f64 {
        self.torque_sigma.0 + self.torque_sigma.1 * torque_nm.abs()
    }

    /// One sigma of the load cell at a force, N.
    pub fn load_cell_sigma_n(&self, force_n: f64) -> f64 {
        self.load_cell_sigma_n.0 + self.load_cell_sigma_n.1 * (-force_n.abs() / RATTLE_FADES_N).exp()
    }
}

/// Counts the pulses of an encoder.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PulseCounter {
    pulses_per_rad: f64,
    last: f64,
}

impl PulseCounter {
    /// A counter for an encoder, beginning at an angle.
    pub fn new(pulses_per_rev: f64, angle_rad: f64) -> Self {
        let pulses_per_rad = pulses_per_rev / TAU;
        Self { pulses_per_rad, last: (angle_rad * pulses_per_rad).floor() }
    }

    /// Pulses since the last reading.
    pub fn read(&mut self, angle_rad: f64) -> f64 {
        let now = (angle_rad * self.pulses_per_rad).floor();
        let pulses = now - self.last;
        self.last = now;
        pulses
    }
}

/// The rig's sensors in use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BogieSensors {
    parameters: SensorParameters,
    gear_ratio: f64,
    phase_rad: [f64; 1 + BOGIE_WHEELSETS],
    roller: PulseCounter,
    wheels: [PulseCounter; BOGIE_WHEELSETS],
}

impl BogieSensors {
    /// Sensors of a rig at angle zero; `phase_rad` is where the encoders stand then: rollers first, then wheelsets.
    pub fn new(parameters: SensorParameters, gear_ratio: f64, phase_rad: [f64; 1 + BOGIE_WHEELSETS]) -> Self {
        Self {
            parameters,
            gear_ratio,
            phase_rad,
            roller: PulseCounter::new(parameters.roller_pulses_per_rev, phase_rad[0]),
            wheels: [1, 2].map(|i| PulseCounter::new(parameters.wheel_pulses_per_rev, phase_rad[i])),
        }
    }

    /// Pulses of the rollers' counter since it was read last; the encoder turns with the motor.
    pub fn roller_pulses(&mut self, step: &BogieRigStep) -> f64 {
        self.roller.read(self.gear_ratio * step.state.roller_angle_rad + self.phase_rad[0])
    }

    /// Pulses of the wheelsets' counters since they were read last.
    pub fn wheel_pulses(&mut self, step: &BogieRigStep) -> [f64; BOGIE_WHEELSETS] {
        let angles = step.state.wheel_angle_rad;
        [0, 1].map(|i| self.wheels[i].read(angles[i] + self.phase_rad[i + 1]))
    }

    /// T_e as measured, N m.
    pub fn torque_nm(&self, step: &BogieRigStep, normal: f64) -> f64 {
        let torque = step.shaft_torque_nm;
        torque + self.parameters.torque_offset_nm + self.parameters.torque_sigma_nm(torque) * normal
    }

    /// Force of the link as measured, N, positive in braking.
    pub fn load_cell_n(&self, step: &BogieRigStep, normal: f64) -> f64 {
        let force = step.link_force_n();
        force + self.parameters.load_cell_offset_n + self.parameters.load_cell_sigma_n(force) * normal
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_carry_over() {
        let mut counter = PulseCounter::new(90.0, 0.3);
        let mut angle = 0.3;
        let mut sum = 0.0;
        for k in 0..80 {
            angle += 2.0 + 0.013 * f64::from(k);
            sum += counter.read(angle);
        }
        let exact = (angle - 0.3) * 90.0 / TAU;
        println!("{sum} pulses for {exact:.2}");
        assert!((sum - exact).abs() <= 1.0);
    }

    #[test]
    fn one_pulse_in_a_window_of_the_rollers_is_15_mm_per_second() {
        let p = SensorParameters::default();
        let v = TAU / p.roller_pulses_per_rev / p.roller_window_s / 7.68 * 0.2;
        println!("{v:.4} m/s");
        assert!((v - 0.01454).abs() < 1e-4);
    }
}
