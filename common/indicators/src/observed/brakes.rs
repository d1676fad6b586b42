//! How the brakes behave: friction, standard friction, applications, dragging, isolation, sand.

use super::{Observed, STANDSTILL_M_S};
use crate::measure::dragging::Rolling;
use crate::measure::standard::conditions;
use railgrip_messages::{Estimate, MAX_WHEELSETS, Sample, valid};

impl Observed {
    /// Pad friction of the wagon and of each wheelset, and front against rear.
    pub(super) fn brakes(&mut self, estimate: &Estimate, dt_s: f64) {
        let settings = &self.settings.brake_friction;
        let count = estimate.wheelset_count();
        let brakes = |wheelset: usize| estimate.pressing_force_n[wheelset] >= settings.min_pressing_force_n;
        let moving = estimate.v_m_s > STANDSTILL_M_S;
        if !moving || !(0..count).any(brakes) {
            return;
        }
        self.state.braking_s += dt_s;
        let (block_s, memory_s) = (settings.correlation_s, settings.memory_s);
        self.state.friction.add(dt_s, estimate.mu_b_mean, estimate.mu_b_mean_sigma, block_s, memory_s);
        let observed = |wheelset: usize| brakes(wheelset) && estimate.observable & (1 << wheelset) != 0;
        for wheelset in (0..count).filter(|wheelset| observed(*wheelset)) {
            let (value, sigma) = (estimate.mu_b[wheelset], estimate.mu_b_sigma[wheelset]);
            self.state.wheelset[wheelset].friction.add(dt_s, value, sigma, block_s, memory_s);
        }
        if count >= 2 && (0..count).all(observed) {
            let half = count / 2;
            let mean = |of: &[f64]| of.iter().sum::<f64>() / of.len() as f64;
            let (front, rear) = (0..half, count - half..count);
            let value = mean(&estimate.mu_b[front.clone()]) - mean(&estimate.mu_b[rear.clone()]);
            // The errors of front and rear are opposite where only their sum is known: they add up.
            let sigma = mean(&estimate.mu_b_sigma[front]) + mean(&estimate.mu_b_sigma[rear]);
            self.state.difference.add(dt_s, value, sigma, block_s, memory_s);
        }
    }

    /// Pad friction under the conditions of now, for the fit.
    pub(super) fn standard(&mut self, estimate: &Estimate, dt_s: f64) {
        let (settings, standard) = (&self.settings.brake_friction, &self.settings.standard);
        let count = estimate.wheelset_count();
        let nominal = self.nominal.brake_friction;
        let (mut force_sum_n, mut rise_sum_k, mut braking) = (0.0, 0.0, 0.0);
        for i in 0..count {
            let force_n = estimate.pressing_force_n[i];
            let rim_rad_s = estimate.v_m_s * (1.0 + estimate.slip[i]).max(0.0) / self.nominal.wheel_radius_m;
            let power_w = estimate.mu_b[i] * force_n * self.nominal.brake_radius_m * rim_rad_s;
            let wheelset = &mut self.state.wheelset[i].standard;
            wheelset.heat(dt_s, power_w, standard);
            if force_n >= settings.min_pressing_force_n {
                force_sum_n += force_n;
                rise_sum_k += wheelset.rise_k;
                braking += 1.0;
            }
        }
        if braking == 0.0 || estimate.v_m_s <= STANDSTILL_M_S {
            return;
        }
        let at = conditions(estimate.v_m_s, force_sum_n / braking, rise_sum_k / braking, standard);
        let seen = (estimate.mu_b_mean, estimate.mu_b_mean_sigma);
        self.state.standard.add(dt_s, seen, at, nominal, settings.correlation_s, standard.memory_s);
        for i in 0..count {
            let force_n = estimate.pressing_force_n[i];
            let observed = estimate.observable & (1 << i) != 0 && force_n >= settings.min_pressing_force_n;
            if observed {
                let at =
                    conditions(estimate.v_m_s, force_n, self.state.wheelset[i].standard.rise_k, standard);
                let (offset, sigma) = self.state.standard.offset(at, nominal);
                let (value, sigma) = (estimate.mu_b[i] - offset, estimate.mu_b_sigma[i].hypot(sigma));
                let mean = &mut self.state.wheelset[i].standard.mean;
                mean.add(dt_s, value, sigma, settings.correlation_s, settings.memory_s);
            }
        }
    }

    /// Applications, isolation, dragging and sand, from what the sensors say.
    pub(super) fn brake_behaviour(&mut self, sample: &Sample, estimate: &Estimate, dt_s: f64) {
        let least_n = self.settings.brake_friction.min_pressing_force_n;
        let count = sample.wheelset_count();
        let mut force_n = [f64::NAN; MAX_WHEELSETS];
        for i in 0..count {
            if sample.has(valid::pressing_force(i)) {
                force_n[i] = sample.pressing_force_n[i];
            }
        }
        let forces_n = &force_n[..count];
        let known = forces_n.iter().filter(|force_n| force_n.is_finite());
        let (sum_n, number) = known.fold((0.0, 0usize), |(sum, n), force_n| (sum + force_n, n + 1));
        let total_n = if number > 0 { sum_n * count as f64 / number as f64 } else { f64::NAN };
        let moving = estimate.v_m_s > STANDSTILL_M_S;
        let vented = estimate.wsp_active != 0;
        let state = &mut self.state;
        state.applications.add(dt_s, total_n, least_n * count as f64, vented, sample.acquired);
        if moving {
            let memory_s = self.settings.isolated.memory_s;
            state.isolation.add(dt_s, forces_n, estimate.wsp_active, least_n, memory_s);
        }
        let torque_nm =
            (0..count).filter(|i| sample.has(valid::drive_torque(*i))).map(|i| sample.drive_torque_nm[i]);
        let rolling = Rolling {
            v_m_s: if sample.has(valid::SPEED) { sample.v_m_s } else { f64::NAN },
            drive_torque_nm: torque_nm.sum(),
            grade_rad: if sample.has(valid::GRADE) { sample.grade_rad } else { f64::NAN },
            released: total_n < least_n && !vented && estimate.sliding == 0,
        };
        state.dragging.add(dt_s, rolling, &self.nominal, self.settings.dragging.memory_s);
        if sample.has(valid::SANDING) {
            let sliding = self.sliding_adhesion(estimate);
            let (now_ns, memory_s) = (sample.acquired.unix_ns, self.settings.sanding.memory_s);
            self.state.sanding.add(dt_s, sample.sanding, sliding, now_ns, memory_s);
        }
    }

    /// Mean adhesion of the wheelsets that slide.
    fn sliding_adhesion(&self, estimate: &Estimate) -> Option<f64> {
        let sliding = (0..estimate.wheelset_count()).filter(|i| self.slides(*i, estimate));
        let (sum, number) =
            sliding.fold((0.0, 0.0), |(sum, n), i| (sum + estimate.mu_w_wheelset[i].abs(), n + 1.0));
        (number > 0.0 && f64::is_finite(sum)).then(|| sum / number)
    }
}
