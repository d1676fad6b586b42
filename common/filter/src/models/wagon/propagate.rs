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
use crate::models::physics::WagonPhysics;
use nalgebra::{SMatrix, SVector};
use railgrip_vehicle::motion::contact_force_of_wheelset_n;

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

impl<const W: usize> WagonPhysics<W> {
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
        let body = self.acceleration(x[0], &adhesion, input.other_force_n, input.wind_m_s);
        let pure = body.value;
        let loads = self.loads_n(pure);
        let mut d_pure = SVector::<f64, N>::zeros();
        d_pure[0] = body.slope;
        for i in 0..W {
            d_pure[at.adhesion + i] = loads[i] / body.mass_kg;
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
            let per_load = 1.0 / (load * mass_factor);
            let scale = per_load / radius;
            let per_friction = input.torque_per_friction_nm[i] - x[at.delay] * input.late_torque_nm[i];
            let pace = (pure + disturbance) / radius;
            let brake = x[at.pad + i] * per_friction;
            let balance = per_load
                * contact_force_of_wheelset_n(wheel_inertia, radius, input.drive_torque_nm[i], brake, pace);
            let mut d_target =
                d_pure * (-wheel_inertia / radius * scale - balance / load * self.loads.transfer_kg[i]);
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
        let mean = self.acceleration(x[0], &mean_adhesion, input.other_force_n, input.wind_m_s);
        let mean_loads = self.loads_n(mean.value);
        let mut d_speed = SVector::<f64, N>::zeros();
        d_speed[0] = mean.slope;
        d_speed[at.disturbance] = input.disturbance_m_s2;
        for i in 0..W {
            d_speed += d_mean[i] * (mean_loads[i] / mean.mass_kg);
        }
        d_speed *= dt;
        next[0] = x[0] + dt * (mean.value + disturbance);
        for i in 0..W {
            let (radius, load) = (self.wheel_radius_m[i], loads[i]);
            let whole = -dt * radius / self.inertia_kg_m2[i];
            let gain = whole * average[i];
            next[at.wheel + i] =
                x[at.wheel + i] + (next[0] - x[0]) / radius + gain * mass_factor * load * deviation[i];
            let mut row = d_speed / radius
                + d_deviation[i] * (gain * mass_factor * load)
                + d_pure * (gain * mass_factor * deviation[i] * self.loads.transfer_kg[i]);
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
