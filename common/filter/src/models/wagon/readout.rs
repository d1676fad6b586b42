//! From the belief of the default filter to an estimate.

use super::layout::Layout;
use super::{DrivenSample, WagonEkf};
use crate::EstimatorOutput;
use crate::observability::scaled_rank;
use nalgebra::{SMatrix, SVector};

/// Expected range of adhesion, to judge what is observable.
const ADHESION_RANGE: f64 = 0.05;

impl<const W: usize, const N: usize> WagonEkf<W, N> {
    pub(super) fn read_out(&self, sample: &DrivenSample, out: &mut EstimatorOutput) {
        let at = Layout::<W, N>::INDICES;
        let x = &self.belief.mean;
        let adhesion: [f64; W] = std::array::from_fn(|i| x[at.adhesion + i]);
        let input = self.step_input(sample, 0.0);
        let loads = self
            .physics
            .loads_n(self.physics.acceleration(x[0], &adhesion, input.other_force_n, input.wind_m_s).value);
        let total: f64 = loads.iter().sum();
        // Below the least force of any pad, noise would be the weight.
        let brakes = (0..W).any(|i| sample.pressing_force_n[i] > self.force_floor_n(i));
        let weight = |i: usize| if brakes { sample.pressing_force_n[i] } else { 1.0 };
        let pressing: f64 = (0..W).map(weight).sum();
        let (mut wagon, mut pads) = (SVector::<f64, N>::zeros(), SVector::<f64, N>::zeros());
        out.wheelsets = W as u32;
        out.v_m_s = x[0];
        for i in 0..W {
            wagon[at.adhesion + i] = loads[i] / total;
            let force = sample.pressing_force_n[i].max(1.0);
            let arrived = (1.0 - x[at.delay] * self.late_force_n[i] / force).clamp(0.0, 2.0);
            let effective = if force > self.force_floor_n(i) {
                arrived * sample.torque_factor[i]
            } else {
                sample.torque_factor[i]
            };
            pads[at.pad + i] = effective * weight(i) / pressing;
            out.mu_w_wheelset[i] = adhesion[i];
            out.mu_w_wheelset_sigma[i] = self.belief.sigma(at.adhesion + i);
            out.mu_b[i] = effective * x[at.pad + i];
            out.mu_b_sigma[i] = effective * self.belief.sigma(at.pad + i);
            out.slip[i] = railgrip_vehicle::creepage(self.contacts[i].slip_m_s + x[0], x[0]);
            out.normal_load_n[i] = loads[i] * (1.0 + x[at.mass]);
            if self.contacts[i].slides() {
                out.sliding |= 1 << i;
            }
            let braking = sample.pressing_force_n[i] > self.force_floor_n(i);
            if braking && out.mu_b_sigma[i] < self.config.priors.observable_sigma && sample.knows_force(i) {
                out.observable |= 1 << i;
            }
        }
        out.mu_w = wagon.dot(x);
        out.mu_w_sigma = self.belief.sigma_along(&wagon);
        out.mu_b_mean = pads.dot(x);
        out.mu_b_mean_sigma = self.belief.sigma_along(&pads);
        out.observability_rank = self.rank();
    }

    /// Rank of (speeds, their derivatives) with respect to (speeds, adhesions, pads): the equations of `physics` without
    /// relaxation. While all brake, a creepage tie adds the difference that these leave open.
    fn rank(&self) -> u32 {
        let priors = &self.config.priors;
        let physics = &self.physics;
        let pad = priors.pad_common * physics.brake_friction[0];
        let (speed, wheel) = (self.sensors.speed_m_s, self.sensors.wheel_speed_rad_s);
        let mut scaled = SMatrix::<f64, 5, 8>::zeros();
        for i in 0..W {
            let (load, inertia) = (physics.loads.static_load_n[i], physics.inertia_kg_m2[i]);
            // What couplers do to the speed hides what adhesion does to it.
            scaled[(0, i)] = if self.coupled { 0.0 } else { load / physics.mass_kg * ADHESION_RANGE / speed };
            scaled[(1 + i, i)] = physics.wheel_radius_m[i] * load / inertia * ADHESION_RANGE / wheel;
            scaled[(1 + i, W + i)] = self.brake_torque_nm[i] / inertia * pad / wheel;
        }
        let all_brake = (0..W).all(|i| scaled[(1 + i, W + i)] > 1.0);
        let tied = if all_brake { self.tied } else { 0 };
        1 + W as u32 + scaled_rank(scaled, 1 + W, 2 * W) + tied
    }
}
