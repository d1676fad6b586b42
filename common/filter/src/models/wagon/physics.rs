//! The wagon's equations as the default filter predicts with them, and their derivative.
//!
//! State, `W` wheelsets, `N = 6 + 4 W` components:
//!
//! | index | component | unit |
//! | --- | --- | --- |
//! | 0 | speed v | m/s |
//! | 1 + i | wheelset speed ω_i | rad/s |
//! | 1 + W + i | adhesion utilised μ_W,i, signed | – |
//! | 1 + 2W | lag: brake torque that nothing else explains and that fades, as adhesion | – |
//! | 2 + 2W | disturbance: wind, error of grade and resistance, in units of its own expected size | – |
//! | 3 + 2W + i | pad friction μ_B,i | – |
//! | 3 + 3W + i | radius of wheel i against nominal, as seen by the speed sensor, relative | – |
//! | 3 + 4W | mass against nominal, relative | – |
//! | 4 + 4W | slope of adhesion over slip velocity in sliding, d ln μ / d ln u, the same for all wheelsets | – |
//! | 5 + 4W | delay of the pads behind the measured pressing force, in units of `brake_lag_s` | – |
//!
//! While a wheelset rolls, its adhesion is not free: creep carries it within milliseconds to the value at which the
//! wheelset keeps pace with the wagon, so the pad force sets it. While it slides, contact saturates and adhesion is
//! whatever the rail gives. Both are one law: with slip velocity u = r ω − v and the target
//! μ*_i = (M_i − μ_B,i F_i r_B − J v̇/r)/(r F_z,i), the deviation μ_W,i − μ*_i decays at the rate
//! λ_i = (∂F_x/∂u) r²/J, and u̇ = −(r² F_z,i/J)(μ_W,i − μ*_i). Rolling: λ is hundreds per second. Sliding: λ → 0 and
//! the wheelset integrates its torque balance, Schwarz & Keck (6). What slope remains in sliding, rising (Polach) or
//! falling with slip, is not known beforehand but lasts: it is a state, because as noise it would be averaged away
//! over the cycles of a slide protection and feign knowledge of the pads.

use super::layout::Layout;
use nalgebra::{SMatrix, SVector};
use railgrip_vehicle::resistance::running_resistance;
use railgrip_vehicle::{MAX_WHEELSETS, Resistance, WagonModel};
use std::f64::consts::FRAC_2_PI;

/// Constants of the equations for `W` wheelsets.
#[derive(Clone, Debug)]
pub struct WagonPhysics<const W: usize> {
    /// Mass m, kg.
    pub mass_kg: f64,
    /// Rolling radius of each wheelset, m.
    pub wheel_radius_m: [f64; W],
    /// Moment of inertia of each wheelset, kg m².
    pub inertia_kg_m2: [f64; W],
    /// Friction radius r_B, m.
    pub brake_radius_m: f64,
    /// Nominal pad friction of each wheelset.
    pub brake_friction: [f64; W],
    /// Load of each wheelset at rest, N.
    pub static_load_n: [f64; W],
    /// Change of load per acceleration, N/(m/s²).
    pub load_transfer_kg: [f64; W],
    /// Running resistance.
    pub resistance: Resistance,
    /// Slope of contact force over creepage where creepage is small, N.
    pub creep_slope_n: f64,
}

/// What acts during one step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepInput<const W: usize> {
    /// Length, s.
    pub dt_s: f64,
    /// Brake torque per pad friction of each wheelset, N m.
    pub torque_per_friction_nm: [f64; W],
    /// Part of it that came of late and is not at the pads if they are delayed, N m.
    pub late_torque_nm: [f64; W],
    /// Drive torque, N m.
    pub drive_torque_nm: [f64; W],
    /// Grade, couplers and effects, N, forward positive.
    pub other_force_n: f64,
    /// Headwind, m/s.
    pub wind_m_s: f64,
    /// Size of one unit of disturbance, m/s².
    pub disturbance_m_s2: f64,
    /// Share of the lag that remains after the step.
    pub lag_kept: f64,
    /// Share of the disturbance that remains after the step.
    pub disturbance_kept: f64,
    /// Rate at which adhesion follows its target, 1/s.
    pub relaxation_per_s: [f64; W],
    /// Derivative of that rate with respect to the slope state, 1/s.
    pub relaxation_per_slope: [f64; W],
}

/// Creepage is referred to this speed below it, m/s.
const SPEED_FLOOR_M_S: f64 = railgrip_vehicle::CREEPAGE_SPEED_FLOOR_M_S;

impl<const W: usize> WagonPhysics<W> {
    /// The constants of `model`, which must have `W` wheelsets.
    pub fn new(model: &WagonModel) -> Self {
        let constants = model.constants();
        let loads = model.load_distribution();
        let (at_rest, moved) = (loads.loads_n(0.0), loads.loads_n(0.01));
        let first = |values: &[f64; MAX_WHEELSETS]| std::array::from_fn(|i| values[i]);
        Self {
            mass_kg: constants.mass_kg,
            wheel_radius_m: first(&constants.wheel_radius_m),
            inertia_kg_m2: first(&constants.inertia_kg_m2),
            brake_radius_m: constants.brake_radius_m,
            brake_friction: first(&constants.brake_friction),
            static_load_n: first(&at_rest),
            load_transfer_kg: std::array::from_fn(|i| (moved[i] - at_rest[i]) / 0.01),
            resistance: constants.resistance.clone(),
            creep_slope_n: FRAC_2_PI
                * (constants.contact.k_a + constants.contact.k_s)
                * constants.contact.stiffness_n,
        }
    }

    /// Acceleration of the body at these adhesions, m/s², and its derivative with respect to speed, 1/s. Loads and
    /// acceleration are consistent with each other (no term dropped as in Schwarz & Keck (11)).
    #[inline]
    pub fn acceleration(&self, v_m_s: f64, adhesion: &[f64; W], input: &StepInput<W>) -> (f64, f64, f64) {
        let mut force = input.other_force_n - running_resistance(&self.resistance, v_m_s, input.wind_m_s);
        let mut inertia = self.mass_kg;
        for i in 0..W {
            force += adhesion[i] * self.static_load_n[i];
            inertia -= adhesion[i] * self.load_transfer_kg[i];
        }
        let airspeed = v_m_s + input.wind_m_s;
        let constant_slope = if v_m_s.abs() < 0.1 { 10.0 * self.resistance.constant_n } else { 0.0 };
        let slope = constant_slope
            + self.resistance.linear_n_s_per_m
            + 2.0 * self.resistance.drag_n_s2_per_m2 * airspeed.abs();
        (force / inertia, -slope / inertia, inertia)
    }

    /// Load of each wheelset at an acceleration, N, kept above a tenth of that at rest.
    #[inline]
    pub fn loads_n(&self, acceleration_m_s2: f64) -> [f64; W] {
        std::array::from_fn(|i| {
            let load = self.static_load_n[i] + self.load_transfer_kg[i] * acceleration_m_s2;
            load.max(0.1 * self.static_load_n[i])
        })
    }

    /// Rate λ at which creep carries the adhesion of a rolling wheelset to its target, 1/s.
    #[inline]
    pub fn rolling_relaxation_per_s(&self, wheelset: usize, v_m_s: f64) -> f64 {
        let radius = self.wheel_radius_m[wheelset];
        self.creep_slope_n * radius * radius / (self.inertia_kg_m2[wheelset] * v_m_s.max(SPEED_FLOOR_M_S))
    }

    /// Slip velocity of a rolling wheelset that transmits `force_n`, m/s.
    #[inline]
    pub fn rolling_slip_m_s(&self, force_n: f64, v_m_s: f64) -> f64 {
        v_m_s.max(SPEED_FLOOR_M_S) * force_n / self.creep_slope_n
    }

    /// State after a step, and its derivative with respect to the state before. `input` counts as constant.
    #[inline]
    pub fn propagate<const N: usize>(
        &self,
        x: &SVector<f64, N>,
        input: &StepInput<W>,
    ) -> (SVector<f64, N>, SMatrix<f64, N, N>) {
        let at = Layout::<W, N>::INDICES;
        let dt = input.dt_s;
        let mass_factor = 1.0 + x[at.mass];
        let adhesion: [f64; W] = std::array::from_fn(|i| x[at.adhesion + i]);
        let (pure, slope, inertia) = self.acceleration(x[0], &adhesion, input);
        let loads = self.loads_n(pure);
        let mut d_pure = SVector::<f64, N>::zeros();
        d_pure[0] = slope;
        for i in 0..W {
            d_pure[at.adhesion + i] = loads[i] / inertia;
        }
        let disturbance = input.disturbance_m_s2 * x[at.disturbance];
        let mut next = *x;
        let mut f = SMatrix::<f64, N, N>::identity();
        let mut mean_adhesion = [0.0; W];
        let mut d_mean = [SVector::<f64, N>::zeros(); W];
        let mut deviation = [0.0; W];
        let mut d_deviation = [SVector::<f64, N>::zeros(); W];
        let (mut average, mut d_average) = ([0.0; W], [0.0; W]);
        for i in 0..W {
            let (radius, wheel_inertia, load) = (self.wheel_radius_m[i], self.inertia_kg_m2[i], loads[i]);
            let scale = 1.0 / (radius * load * mass_factor);
            let per_friction = input.torque_per_friction_nm[i] - x[at.delay] * input.late_torque_nm[i];
            let torque = input.drive_torque_nm[i]
                - x[at.pad + i] * per_friction
                - wheel_inertia / radius * (pure + disturbance);
            let balance = torque * scale;
            let mut d_target =
                d_pure * (-wheel_inertia / radius * scale - balance / load * self.load_transfer_kg[i]);
            d_target[at.disturbance] -= wheel_inertia / radius * input.disturbance_m_s2 * scale;
            d_target[at.pad + i] -= per_friction * scale;
            d_target[at.delay] += x[at.pad + i] * input.late_torque_nm[i] * scale;
            d_target[at.mass] -= balance / mass_factor;
            d_target[at.lag] += 1.0;
            deviation[i] = adhesion[i] - (balance + x[at.lag]);
            d_deviation[i] = -d_target;
            d_deviation[i][at.adhesion + i] += 1.0;
            let exponent = (input.relaxation_per_s[i] + x[at.slope] * input.relaxation_per_slope[i]) * dt;
            let kept = (-exponent).exp();
            let small = exponent.abs() < 1e-4;
            average[i] = if small { 1.0 - 0.5 * exponent } else { (1.0 - kept) / exponent };
            let per_slope = input.relaxation_per_slope[i] * dt;
            d_average[i] = per_slope * if small { -0.5 } else { (kept - average[i]) / exponent };
            mean_adhesion[i] = adhesion[i] - (1.0 - average[i]) * deviation[i];
            d_mean[i] = d_deviation[i] * (average[i] - 1.0);
            d_mean[i][at.adhesion + i] += 1.0;
            d_mean[i][at.slope] += d_average[i] * deviation[i];
            next[at.adhesion + i] = adhesion[i] - (1.0 - kept) * deviation[i];
            let mut row = d_deviation[i] * (kept - 1.0);
            row[at.adhesion + i] += 1.0;
            row[at.slope] -= kept * per_slope * deviation[i];
            f.set_row(at.adhesion + i, &row.transpose());
        }
        let (mean_pure, mean_slope, mean_inertia) = self.acceleration(x[0], &mean_adhesion, input);
        let mean_loads = self.loads_n(mean_pure);
        let mut d_speed = SVector::<f64, N>::zeros();
        d_speed[0] = mean_slope;
        d_speed[at.disturbance] = input.disturbance_m_s2;
        for i in 0..W {
            d_speed += d_mean[i] * (mean_loads[i] / mean_inertia);
        }
        d_speed *= dt;
        next[0] = x[0] + dt * (mean_pure + disturbance);
        for i in 0..W {
            let (radius, load) = (self.wheel_radius_m[i], loads[i]);
            let whole = -dt * radius / self.inertia_kg_m2[i];
            let gain = whole * average[i];
            next[at.wheel + i] =
                x[at.wheel + i] + (next[0] - x[0]) / radius + gain * mass_factor * load * deviation[i];
            let mut row = d_speed / radius
                + d_deviation[i] * (gain * mass_factor * load)
                + d_pure * (gain * mass_factor * deviation[i] * self.load_transfer_kg[i]);
            row[at.mass] += gain * load * deviation[i];
            row[at.slope] += whole * d_average[i] * mass_factor * load * deviation[i];
            row[at.wheel + i] += 1.0;
            f.set_row(at.wheel + i, &row.transpose());
        }
        d_speed[0] += 1.0;
        f.set_row(0, &d_speed.transpose());
        next[at.lag] *= input.lag_kept;
        f[(at.lag, at.lag)] = input.lag_kept;
        next[at.disturbance] *= input.disturbance_kept;
        f[(at.disturbance, at.disturbance)] = input.disturbance_kept;
        (next, f)
    }
}
