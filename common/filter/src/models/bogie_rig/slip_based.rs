//! The paper's slip-based adhesion: slip (2) and adhesion (3) from either sensor, positive in braking.
//!
//! (3) reads `T_b/(N R_r) = i T_e/(N R_r)`. `T_b` comes from the load cell: the link carries the contact forces, so
//! `T_b = F R_r`, in motion as at rest. `T_e` also accelerates what turns beyond the transducer and feeds its losses,
//! so the right-hand side holds in steady state only:
//!
//! ```text
//! μ = (i T_e − J_r' ω̇_r − loss) / (N R_r) ,              J_r' = J_r + i² J_s
//! μ = (i T_m − (J_r' + i² J_m) ω̇_r − loss) / (N R_r)     from the torque that the motor makes
//! ```

use super::BogieSample;
use railgrip_vehicle::bogie_rig::{BOGIE_WHEELSETS, BogieParameters};
use std::f64::consts::TAU;

/// Slip λ (2); nothing if the rollers stand.
pub fn slip(parameters: &BogieParameters, roller_speed_rad_s: f64, wheel_speed_rad_s: f64) -> Option<f64> {
    let v = parameters.roller_radius_m * roller_speed_rad_s;
    (v > 0.0).then(|| (v - parameters.wheel_radius_m * wheel_speed_rad_s) / v)
}

/// Adhesion from the load cell, left of (3); nothing without load.
pub fn by_load_cell(load_cell_n: f64, load_n: f64) -> Option<f64> {
    (load_n > 0.0).then(|| load_cell_n / load_n)
}

/// Adhesion from the transducer, right of (3) as printed; nothing without load.
pub fn by_torque(parameters: &BogieParameters, shaft_torque_nm: f64, load_n: f64) -> Option<f64> {
    (load_n > 0.0).then(|| parameters.gear_ratio * shaft_torque_nm / (load_n * parameters.roller_radius_m))
}

/// Adhesion from the transducer with inertia and loss of what turns beyond it; nothing without load.
pub fn by_torque_with_inertia(
    parameters: &BogieParameters,
    shaft_torque_nm: f64,
    roller_speed_rad_s: f64,
    roller_acceleration_rad_s2: f64,
    load_n: f64,
) -> Option<f64> {
    let inertia = parameters.inertia_beyond_transducer_kg_m2();
    let taken = inertia * roller_acceleration_rad_s2 + parameters.loss_at_nm(roller_speed_rad_s);
    balance(parameters, shaft_torque_nm, taken, load_n)
}

/// Adhesion from the torque that the motor makes, where there is no transducer: its own inertia belongs in the balance.
pub fn by_motor_torque(
    parameters: &BogieParameters,
    motor_torque_nm: f64,
    roller_speed_rad_s: f64,
    roller_acceleration_rad_s2: f64,
    load_n: f64,
) -> Option<f64> {
    let inertia = parameters.inertia_beyond_motor_kg_m2();
    let taken = inertia * roller_acceleration_rad_s2 + parameters.loss_at_nm(roller_speed_rad_s);
    balance(parameters, motor_torque_nm, taken, load_n)
}

fn balance(parameters: &BogieParameters, torque_nm: f64, taken_nm: f64, load_n: f64) -> Option<f64> {
    (load_n > 0.0)
        .then(|| (parameters.gear_ratio * torque_nm - taken_nm) / (load_n * parameters.roller_radius_m))
}

/// Speed and acceleration of the rollers from the counts of their 8 Hz windows alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollerCounts {
    /// Length of the present window so far, s; NaN where its beginning is not known.
    window_s: f64,
    /// Mean speed over the last window, rad/s; NaN after one of unknown length.
    pub speed_rad_s: f64,
    /// Difference of the last two over a window, rad/s²; 0 before them.
    pub acceleration_rad_s2: f64,
}

impl RollerCounts {
    /// Nothing counted yet.
    pub const NEW: Self = Self { window_s: f64::NAN, speed_rad_s: f64::NAN, acceleration_rad_s2: 0.0 };

    /// Samples are missing: nobody knows how long the present window is.
    pub const fn tear(&mut self) {
        self.window_s = f64::NAN;
    }

    /// Takes a sample, `dt_s` after the last; the length of the window that it ended, if it ended one.
    pub fn take(&mut self, parameters: &BogieParameters, sample: &BogieSample, dt_s: f64) -> Option<f64> {
        self.window_s += dt_s;
        if !sample.roller_pulses.is_finite() {
            return None;
        }
        let pulse_rad = TAU / (parameters.sensors.roller_pulses_per_rev * parameters.gear_ratio);
        let window_s = std::mem::take(&mut self.window_s);
        let speed = sample.roller_pulses * pulse_rad / window_s;
        let acceleration = (speed - self.speed_rad_s) / window_s;
        self.acceleration_rad_s2 = if acceleration.is_finite() { acceleration } else { 0.0 };
        self.speed_rad_s = speed;
        Some(window_s)
    }
}

/// What the paper computes from one sample, without a filter; NaN where it is not defined. Positive in braking.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PaperReading {
    /// λ (2) of each wheelset over the last window of the rollers' counter.
    pub slip: [f64; BOGIE_WHEELSETS],
    /// Left of (3).
    pub by_load_cell: f64,
    /// Right of (3) as printed.
    pub by_torque: f64,
    /// The same with inertia and loss.
    pub by_torque_with_inertia: f64,
}

/// The paper's (2) and (3) sample by sample.
#[derive(Clone, Debug)]
pub struct PaperReader {
    parameters: BogieParameters,
    counts: RollerCounts,
    last_s: f64,
    wheel_pulses: [f64; BOGIE_WHEELSETS],
    slip: [f64; BOGIE_WHEELSETS],
}

impl PaperReader {
    /// For a rig with these constants.
    pub fn new(parameters: BogieParameters) -> Self {
        let slip = [f64::NAN; BOGIE_WHEELSETS];
        Self { parameters, counts: RollerCounts::NEW, last_s: f64::NAN, wheel_pulses: [0.0; 2], slip }
    }

    /// Reads a sample.
    pub fn read(&mut self, sample: &BogieSample) -> PaperReading {
        let p = &self.parameters;
        let dt_s = sample.time_s - self.last_s;
        self.last_s = sample.time_s;
        if dt_s > 1.5 * p.sensors.sample_period_s {
            self.counts.tear();
        }
        for (sum, pulses) in self.wheel_pulses.iter_mut().zip(sample.wheel_pulses) {
            *sum += pulses;
        }
        if let Some(window_s) = self.counts.take(p, sample, dt_s) {
            let turned = self.wheel_pulses.map(|pulses| pulses * TAU / p.sensors.wheel_pulses_per_rev);
            self.slip = turned
                .map(|angle_rad| slip(p, self.counts.speed_rad_s, angle_rad / window_s).unwrap_or(f64::NAN));
            self.wheel_pulses = [0.0; BOGIE_WHEELSETS];
        }
        let (torque, load) = (sample.shaft_torque_nm, sample.load_n);
        let (speed, acceleration) = (self.counts.speed_rad_s, self.counts.acceleration_rad_s2);
        let or_nan = |value: Option<f64>| value.unwrap_or(f64::NAN);
        PaperReading {
            slip: self.slip,
            by_load_cell: or_nan(by_load_cell(sample.load_cell_n, load)),
            by_torque: or_nan(by_torque(p, torque, load)),
            by_torque_with_inertia: or_nan(by_torque_with_inertia(p, torque, speed, acceleration, load)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_vehicle::bogie_rig::{BogieRig, ContactLaw, RailCondition};

    #[test]
    fn erratum_9_balances_with_inertia_meet_the_contact_in_motion() {
        let p = BogieParameters::default();
        let rig = BogieRig::new(p.clone());
        let law = ContactLaw::of(RailCondition::Dry);
        let (load, motor, dt_s) = (p.load_n(), 5.0, 1e-4);
        let mut state = rig.rolling(2.0);
        let mut worst = [0.0f64; 4];
        for k in 0..2000 {
            let step = rig.step(&state, motor, [60.0, 58.0], &law, [1.0; 2], dt_s);
            state = step.state;
            if k < 100 {
                continue;
            }
            let (speed, acceleration) = (state.roller_speed_rad_s, step.roller_acceleration_rad_s2);
            let truth = -step.mu_w(&p);
            let found = [
                by_load_cell(step.link_force_n(), load),
                by_torque(&p, step.shaft_torque_nm, load),
                by_torque_with_inertia(&p, step.shaft_torque_nm, speed, acceleration, load),
                by_motor_torque(&p, motor, speed, acceleration, load),
            ];
            for (worst, found) in worst.iter_mut().zip(found) {
                *worst = worst.max((found.unwrap() - truth).abs());
            }
        }
        println!("largest error of adhesion: load cell, (3), with inertia, from motor torque: {worst:.4?}");
        assert!(worst[0] < 1e-12 && worst[2] < 1e-3 && worst[3] < 1e-3);
        assert!(worst[1] > 0.05, "(3) as printed must be far off while the rollers slow down");
    }

    #[test]
    fn nothing_without_load_or_motion() {
        let p = BogieParameters::default();
        assert_eq!(slip(&p, 0.0, 3.0), None);
        assert_eq!(by_load_cell(100.0, 0.0), None);
        assert_eq!(by_torque(&p, 10.0, 0.0), None);
        assert!((slip(&p, 10.0, 18.0).unwrap() - 0.1).abs() < 1e-12);
    }
}
