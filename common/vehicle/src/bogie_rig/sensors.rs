//! Sensors of the rig: pulse counters, torque transducer, load cell.
//!
//! Noise comes in as standard normal numbers, so that who simulates keeps the seed.

use super::{BOGIE_WHEELSETS, BogieRigStep, SensorParameters};
use std::f64::consts::TAU;

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
