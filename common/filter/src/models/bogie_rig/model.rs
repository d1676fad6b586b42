//! Equations of the filter: how its state moves and what each sensor should say.
//!
//! State: `[φ_r, ω_r, ω̇_r, φ_1, ω_1, φ_2, ω_2, μ_w, b_T, b_F]`. The angles φ are those since the last pulse that was
//! counted, so a counter measures its angle with the error of half a pulse, uniform and independent from count
//! to count; the differences that people form from counts are not.
//!
//! ```text
//! i (T_e − b_T) = J_r' ω̇_r − R N μ_w + loss(ω_r)
//! F_link − b_F  = −N μ_w
//! ```

use crate::core::{Gaussian, ScalarUpdate};
use nalgebra::{SMatrix, SVector};
use railgrip_vehicle::bogie_rig::{BOGIE_WHEELSETS, BogieParameters};
use std::f64::consts::TAU;

/// Number of states.
pub const STATES: usize = 10;

/// A state of the filter.
pub type BogieVector = SVector<f64, STATES>;

/// Where each state lies.
pub mod index {
    /// φ_r, rad.
    pub const ROLLER_ANGLE: usize = 0;
    /// ω_r, rad/s.
    pub const ROLLER_SPEED: usize = 1;
    /// ω̇_r, rad/s².
    pub const ROLLER_ACCELERATION: usize = 2;
    /// φ of each wheelset, rad.
    pub const WHEEL_ANGLE: [usize; 2] = [3, 5];
    /// ω of each wheelset, rad/s.
    pub const WHEEL_SPEED: [usize; 2] = [4, 6];
    /// μ_w.
    pub const ADHESION: usize = 7;
    /// b_T, N m.
    pub const TORQUE_OFFSET: usize = 8;
    /// b_F, N.
    pub const LOAD_CELL_OFFSET: usize = 9;
}

/// How fast the states wander, one sigma after one second, and what is known at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BogieNoise {
    /// Roller acceleration, rad/s² per √s.
    pub roller_acceleration: f64,
    /// Wheelset speed, rad/s per √s.
    pub wheel_speed: f64,
    /// Adhesion, per √s.
    pub adhesion: f64,
    /// Factor of all three where innovations show a change under way.
    pub changing: f64,
    /// Zero error of the transducer, N m per √s.
    pub torque_offset_nm: f64,
    /// Zero error of the load cell, N per √s.
    pub load_cell_offset_n: f64,
    /// Zero error of the transducer at the start, N m.
    pub torque_offset_prior_nm: f64,
    /// Zero error of the load cell at the start, N.
    pub load_cell_offset_prior_n: f64,
}

impl Default for BogieNoise {
    /// Chosen: what the rig does under a controller that holds its slip, and thirty times that where it locks.
    fn default() -> Self {
        Self {
            roller_acceleration: 2.0,
            wheel_speed: 0.4,
            adhesion: 0.02,
            changing: 30.0,
            torque_offset_nm: 0.002,
            load_cell_offset_n: 0.1,
            torque_offset_prior_nm: 0.5,
            load_cell_offset_prior_n: 25.0,
        }
    }
}

/// The equations.
#[derive(Clone, Debug, PartialEq)]
pub struct BogieModel {
    /// Constants of the rig.
    pub parameters: BogieParameters,
    /// Noise.
    pub noise: BogieNoise,
}

impl BogieModel {
    /// F of a step.
    pub fn transition(dt_s: f64) -> SMatrix<f64, STATES, STATES> {
        let mut f = SMatrix::<f64, STATES, STATES>::identity();
        f[(index::ROLLER_ANGLE, index::ROLLER_SPEED)] = dt_s;
        f[(index::ROLLER_ANGLE, index::ROLLER_ACCELERATION)] = 0.5 * dt_s * dt_s;
        f[(index::ROLLER_SPEED, index::ROLLER_ACCELERATION)] = dt_s;
        for i in 0..BOGIE_WHEELSETS {
            f[(index::WHEEL_ANGLE[i], index::WHEEL_SPEED[i])] = dt_s;
        }
        f
    }

    /// Diagonal of Q of a step; `changing` for the forces and for each wheelset.
    pub fn process_variance(
        &self,
        dt_s: f64,
        forces_changing: bool,
        wheel_changing: [bool; BOGIE_WHEELSETS],
    ) -> BogieVector {
        let n = &self.noise;
        let rate = |rate: f64, changing: bool| {
            let rate = if changing { rate * n.changing } else { rate };
            rate * rate * dt_s
        };
        let mut q = BogieVector::zeros();
        q[index::ROLLER_ACCELERATION] = rate(n.roller_acceleration, forces_changing);
        for i in 0..BOGIE_WHEELSETS {
            q[index::WHEEL_SPEED[i]] = rate(n.wheel_speed, wheel_changing[i]);
        }
        q[index::ADHESION] = rate(n.adhesion, forces_changing);
        q[index::TORQUE_OFFSET] = rate(n.torque_offset_nm, false);
        q[index::LOAD_CELL_OFFSET] = rate(n.load_cell_offset_n, false);
        q
    }

    /// Belief before the first pulse: nothing is known about the motion.
    pub fn prior(&self) -> Gaussian<STATES> {
        let mut mean = BogieVector::zeros();
        let mut sigma = BogieVector::zeros();
        for (slot, state) in
            [index::ROLLER_ANGLE, index::WHEEL_ANGLE[0], index::WHEEL_ANGLE[1]].into_iter().enumerate()
        {
            let pulse = self.pulse_rad(slot);
            mean[state] = 0.5 * pulse;
            sigma[state] = pulse / 12f64.sqrt();
        }
        sigma[index::ROLLER_SPEED] = 15.0;
        sigma[index::ROLLER_ACCELERATION] = 0.5;
        sigma[index::WHEEL_SPEED[0]] = 30.0;
        sigma[index::WHEEL_SPEED[1]] = 30.0;
        sigma[index::ADHESION] = 0.3;
        sigma[index::TORQUE_OFFSET] = self.noise.torque_offset_prior_nm;
        sigma[index::LOAD_CELL_OFFSET] = self.noise.load_cell_offset_prior_n;
        Gaussian::independent(mean, &sigma)
    }

    /// Angle of one pulse, rad: counter 0 is that of the rollers (at the roller shaft), 1 and 2 those of the wheelsets.
    pub fn pulse_rad(&self, counter: usize) -> f64 {
        let sensors = &self.parameters.sensors;
        if counter == 0 {
            TAU / (sensors.roller_pulses_per_rev * self.parameters.gear_ratio)
        } else {
            TAU / sensors.wheel_pulses_per_rev
        }
    }

    /// State that a counter measures.
    pub fn angle_of(counter: usize) -> usize {
        if counter == 0 { index::ROLLER_ANGLE } else { index::WHEEL_ANGLE[counter - 1] }
    }

    /// T_e that a state expects, N m.
    pub fn torque_nm(&self, x: &BogieVector, load_n: f64) -> f64 {
        let p = &self.parameters;
        let taken = p.inertia_beyond_transducer_kg_m2() * x[index::ROLLER_ACCELERATION]
            - p.roller_radius_m * load_n * x[index::ADHESION]
            + p.loss_at_nm(x[index::ROLLER_SPEED]);
        taken / p.gear_ratio + x[index::TORQUE_OFFSET]
    }

    /// Derivative of [`Self::torque_nm`] in motion.
    pub fn torque_row(&self, load_n: f64) -> BogieVector {
        let p = &self.parameters;
        let mut h = BogieVector::zeros();
        // The part of the loss that fades out at standstill is no measurement of speed.
        h[index::ROLLER_SPEED] = p.loss_nm_s / p.gear_ratio;
        h[index::ROLLER_ACCELERATION] = p.inertia_beyond_transducer_kg_m2() / p.gear_ratio;
        h[index::ADHESION] = -p.roller_radius_m * load_n / p.gear_ratio;
        h[index::TORQUE_OFFSET] = 1.0;
        h
    }

    /// Link force that a state expects, N.
    pub fn load_cell_n(x: &BogieVector, load_n: f64) -> f64 {
        -load_n * x[index::ADHESION] + x[index::LOAD_CELL_OFFSET]
    }

    /// Derivative of [`Self::load_cell_n`].
    pub fn load_cell_row(load_n: f64) -> BogieVector {
        let mut h = BogieVector::zeros();
        h[index::ADHESION] = -load_n;
        h[index::LOAD_CELL_OFFSET] = 1.0;
        h
    }

    /// What a torque would say: innovation with its row, and the sensor's variance.
    pub fn expect_torque(
        &self,
        belief: &Gaussian<STATES>,
        measured_nm: f64,
        load_n: f64,
    ) -> (ScalarUpdate, BogieVector, f64) {
        let expected = self.torque_nm(&belief.mean, load_n);
        let r = self.parameters.sensors.torque_sigma_nm(expected - belief.mean[index::TORQUE_OFFSET]).powi(2);
        let h = self.torque_row(load_n);
        (belief.expect_row(&h, measured_nm - expected, r), h, r)
    }

    /// What a link force would say: innovation with its row, and the sensor's variance.
    pub fn expect_load_cell(
        &self,
        belief: &Gaussian<STATES>,
        measured_n: f64,
        load_n: f64,
    ) -> (ScalarUpdate, BogieVector, f64) {
        let expected = Self::load_cell_n(&belief.mean, load_n);
        let unloaded_n = belief.mean[index::LOAD_CELL_OFFSET];
        let r = self.parameters.sensors.load_cell_sigma_n(expected - unloaded_n).powi(2);
        let h = Self::load_cell_row(load_n);
        (belief.expect_row(&h, measured_n - expected, r), h, r)
    }

    /// What a count would say, and the counter's variance.
    pub fn expect_count(
        &self,
        belief: &Gaussian<STATES>,
        counter: usize,
        pulses: f64,
    ) -> (ScalarUpdate, f64) {
        let pulse = self.pulse_rad(counter);
        let r = pulse * pulse / 12.0;
        (belief.expect_component(Self::angle_of(counter), (pulses + 0.5) * pulse, r), r)
    }

    /// Forgets the angle of a counter that was read for the first time: its window began at an unknown time.
    pub fn forget_angle(&self, belief: &mut Option<Gaussian<STATES>>, counter: usize) {
        let pulse = self.pulse_rad(counter);
        if let Some(belief) = belief {
            belief.reset_component(Self::angle_of(counter), 0.5 * pulse, pulse / 12f64.sqrt());
        }
    }

    /// Takes the counted angle out of a belief: the counter begins anew.
    pub fn begin_anew(&self, belief: &mut Gaussian<STATES>, counter: usize, pulses: f64) {
        belief.mean[Self::angle_of(counter)] -= pulses * self.pulse_rad(counter);
    }
}
