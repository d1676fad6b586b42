//! What rolling says about the wheelsets: their creepages differ as their forces and radii do.
//!
//! For neighbouring wheelsets i and j that both roll, `r(1+δ_i) ω_i − r(1+δ_j) ω_j = (v/C)(F_x,i − F_x,j)`, with C the
//! slope of the creep law at small creepage. While coasting this shows the difference of the radii, while braking
//! that of the brakes. The error of the creep law does not average out: it is the same for many seconds. A constant
//! error of size σ that lasts τ weighs like white noise of variance 2 σ² τ / Δt in updates every Δt.

use super::layout::Layout;
use super::{DrivenSample, WagonEkf};
use nalgebra::SVector;

/// Time between ties, s.
pub(super) const INTERVAL_S: f64 = 0.05;
/// Time over which the error of the creep law persists, s.
const PERSISTENCE_S: f64 = 10.0;
/// Difference of radii that comes and goes with the run of the wheel on the rail, relative.
const RADIUS_WANDER: f64 = 3e-5;
/// Delay between the sensors of wheel and vehicle speed that cannot be excluded, s.
const SENSOR_DELAY_S: f64 = 0.1;
/// Below this slope of the creep law a contact is too near its limit to compare forces by creepage.
const LEAST_ROLLING: f64 = 0.5;

impl<const W: usize, const N: usize> WagonEkf<W, N> {
    /// Ties neighbouring wheelsets by creepage, and each wheelset to the vehicle speed.
    pub(super) fn tie_creepages(&mut self, sample: &DrivenSample) {
        self.tied = 0;
        if self.belief.mean[0] < 3.0 {
            return;
        }
        let rolls = |filter: &Self, i: usize| {
            filter.contacts[i].rolling > LEAST_ROLLING
                && filter.watches[i].certainty(filter.step_s) == 0.0
                && sample.wheel_speed_rad_s[i].is_finite()
        };
        for i in 0..W {
            if rolls(self, i) && sample.v_m_s.is_finite() {
                self.tie_to_vehicle(i);
            }
            if i + 1 < W && rolls(self, i) && rolls(self, i + 1) {
                self.tie_neighbours(i);
                self.tied += 1;
            }
        }
    }

    /// Slip velocity of wheelset `i` minus that which its force asks for, m/s; its derivative; and that force's part.
    fn slip_residual(&self, i: usize) -> (f64, SVector<f64, N>, f64) {
        let at = Layout::<W, N>::INDICES;
        let (x, physics) = (&self.belief.mean, &self.physics);
        let radius = physics.wheel_radius_m[i];
        let compliance = x[0] / physics.creep_slope_n * physics.static_load_n[i];
        let asked = compliance * x[at.adhesion + i];
        let mut h = SVector::<f64, N>::zeros();
        h[0] = -1.0 - asked / x[0];
        h[at.wheel + i] = radius * (1.0 + x[at.radius + i]);
        h[at.radius + i] = radius * x[at.wheel + i];
        h[at.adhesion + i] = -compliance;
        (radius * (1.0 + x[at.radius + i]) * x[at.wheel + i] - x[0] - asked, h, asked)
    }

    fn tie_neighbours(&mut self, i: usize) {
        let (front, h_front, asked_front) = self.slip_residual(i);
        let (rear, h_rear, asked_rear) = self.slip_residual(i + 1);
        let secant = self.contacts[i].secant.min(self.contacts[i + 1].secant);
        let law = self.config.priors.creep_law + (1.0 / (secant * secant * secant) - 1.0);
        let systematic = law * (asked_front - asked_rear);
        let wander = RADIUS_WANDER * self.belief.mean[0];
        self.fuse_tie(&(h_front - h_rear), front - rear, systematic * systematic + wander * wander);
    }

    fn tie_to_vehicle(&mut self, i: usize) {
        let (residual, h, asked) = self.slip_residual(i);
        let law = 2.0 * self.config.priors.creep_law * asked;
        let acceleration = self.sensitivity_acceleration();
        let delay = SENSOR_DELAY_S * acceleration;
        let wander = RADIUS_WANDER * self.belief.mean[0];
        self.fuse_tie(&h, residual, law * law + delay * delay + wander * wander);
    }

    /// Acceleration at the present belief, m/s², resistance left out.
    fn sensitivity_acceleration(&self) -> f64 {
        let at = Layout::<W, N>::INDICES;
        (0..W).map(|i| self.belief.mean[at.adhesion + i] * self.physics.static_load_n[i]).sum::<f64>()
            / self.physics.mass_kg
    }

    /// Uses `h · x` = 0 with an error that persists.
    fn fuse_tie(&mut self, h: &SVector<f64, N>, residual: f64, systematic_variance: f64) {
        let r = systematic_variance * 2.0 * PERSISTENCE_S / INTERVAL_S + 1e-10;
        let update = self.belief.expect_row(h, -residual, r);
        let gate = self.config.hygiene.gate_sigma;
        if update.nis() < gate * gate {
            self.belief.update_row(h, &update, r);
        }
    }
}
