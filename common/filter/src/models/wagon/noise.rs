//! Process noise of the default filter: how far each component may move on its own within a step.

use super::layout::Layout;
use super::pads::{pad_entry, pad_prior_variances};
use super::propagate::StepInput;
use super::{DrivenSample, WagonEkf};
use nalgebra::SVector;
use railgrip_vehicle::GRAVITY_M_S2;
use railgrip_vehicle::brake::pad_torque_nm;
use railgrip_vehicle::resistance::running_resistance;

impl<const W: usize, const N: usize> WagonEkf<W, N> {
    /// Size of one unit of disturbance, m/s²: what wind, errors of resistance and grade, and couplers may add.
    pub(super) fn disturbance_m_s2(&self, sample: &DrivenSample) -> f64 {
        let priors = &self.config.priors;
        let v_m_s = self.belief.mean[0];
        let resistance = &self.physics.resistance;
        let mass = self.physics.mass_kg;
        let davis = priors.resistance * running_resistance(resistance, v_m_s, 0.0) / mass;
        let wind = 2.0 * resistance.drag_n_s2_per_m2 * v_m_s * priors.wind_m_s / mass;
        let grade = GRAVITY_M_S2 * sample.grade_sigma_rad;
        let coupler = if self.coupled { priors.coupler_m_s2 } else { 0.0 };
        (davis * davis + wind * wind + grade * grade + coupler * coupler).sqrt().max(1e-5)
    }

    /// Diagonal of Q but for the pads, which [`Self::age_pads`] moves.
    pub(super) fn process_noise(
        &self,
        sample: &DrivenSample,
        input: &StepInput<W>,
        next: &SVector<f64, N>,
    ) -> SVector<f64, N> {
        let at = Layout::<W, N>::INDICES;
        let (rates, priors, physics) = (&self.config.rates, &self.config.priors, &self.physics);
        let (x, dt) = (&self.belief.mean, input.dt_s);
        let mut q = SVector::<f64, N>::zeros();
        q[0] = rates.speed_per_sqrt_s.powi(2) * dt;
        let mut late = 0.0;
        for i in 0..W {
            let radius = physics.wheel_radius_m[i];
            let sliding = 1.0 - self.contacts[i].rolling;
            let change = self.watches[i].certainty(dt);
            let torque_nm = |force_n: f64| pad_torque_nm(x[at.pad + i], force_n, physics.brake_radius_m);
            let per_force = torque_nm(sample.torque_factor[i]) / physics.inertia_kg_m2[i];
            let spin = next[at.wheel + i] - x[at.wheel + i] - (next[0] - x[0]) / radius;
            // Creep beyond the linear law is missing from the predicted slip: for a change that lasts, a share of the whole.
            let force = next[at.adhesion + i].abs() * physics.loads.static_load_n[i];
            let change_n =
                (next[at.adhesion + i] - x[at.adhesion + i]).abs() * physics.loads.static_load_n[i];
            let jitter_n = torque_nm(2.0 * self.sensors.pressing_force_n) / radius;
            let change_n = (change_n - jitter_n).max(0.0);
            let creep = physics.rolling_slip_m_s(force, x[0]) * physics.rolling_slip_m_s(change_n, x[0]);
            let unmodelled = (priors.creep_excess / radius).powi(2) * self.contacts[i].rolling * creep;
            q[at.wheel + i] = unmodelled
                + (rates.rim_speed_per_sqrt_s / radius).powi(2) * dt
                + (priors.inertia * spin).powi(2)
                + (sliding * per_force * self.sensors.pressing_force_n * dt).powi(2);
            let known = sample.knows_force(i);
            let per_sqrt_s = if known {
                rates.adhesion_rolling_per_sqrt_s
                    + sliding * (rates.adhesion_sliding_per_sqrt_s + sample.sanding.abs() * 0.02)
                    + change * rates.adhesion_changing_per_sqrt_s
            } else {
                rates.adhesion_changing_per_sqrt_s
            };
            q[at.adhesion + i] = per_sqrt_s.powi(2) * dt;
            late += torque_nm(self.late_force_n[i]) / (radius * physics.loads.static_load_n[i]);
            q[at.radius + i] = 1e-12 * dt;
        }
        let lagging = rates.brake_lag_share * late / W as f64;
        q[at.lag] = (1.0 - input.lag_kept * input.lag_kept) * (lagging * lagging + 1e-10);
        q[at.disturbance] = 1.0 - input.disturbance_kept * input.disturbance_kept;
        q[at.mass] = 1e-12 * dt;
        let forget = (2.0 * dt / rates.sliding_slope_s).min(1.0);
        let room = priors.sliding_slope.powi(2) - self.belief.covariance[(at.slope, at.slope)];
        q[at.slope] = forget * room.max(0.0);
        q
    }

    /// Lets the pads change over `dt_s`: slowly while they brake; while nothing shows them (`held`), towards the
    /// prior. Growth fades as the prior is reached, so that the belief never knows less than that.
    pub(super) fn age_pads(&mut self, held: &[bool; W], dt_s: f64) {
        let at = Layout::<W, N>::INDICES;
        let rates = &self.config.rates;
        let (common_prior, split_prior) =
            pad_prior_variances::<W>(&self.config.priors, self.physics.brake_friction[0]);
        let (mut trace, mut total) = (0.0, 0.0);
        for i in 0..W {
            for j in 0..W {
                let value = self.belief.covariance[(at.pad + i, at.pad + j)];
                total += value;
                if i == j {
                    trace += value;
                }
            }
        }
        let common = total / (W * W) as f64;
        let split = trace / W as f64 - common;
        let all_held = held.iter().all(|&held| held);
        let nominal = self.physics.brake_friction[0];
        let grow = |variance: f64, prior: f64, per_sqrt_s: f64| {
            let room = (1.0 - variance / prior.max(1e-12)).max(0.0);
            let rate = if all_held { 2.0 * prior / rates.pad_forget_s } else { 0.0 };
            room * (rate + (per_sqrt_s * nominal).powi(2)) * dt_s
        };
        let common_growth = grow(common, common_prior, rates.pad_common_per_sqrt_s);
        let split_growth = if W > 1 { grow(split, split_prior, rates.pad_split_per_sqrt_s) } else { 0.0 };
        for i in 0..W {
            for j in 0..W {
                self.belief.covariance[(at.pad + i, at.pad + j)] +=
                    pad_entry::<W>(common_growth, split_growth, i == j);
            }
        }
    }
}
