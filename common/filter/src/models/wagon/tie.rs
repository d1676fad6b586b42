//! What rolling says about the wheelsets: their creepages differ as their forces and radii do.
//!
//! For neighbouring wheelsets i and j that both roll, `r(1+δ_i) ω_i − r(1+δ_j) ω_j = (v/(C φ))(F_x,i − F_x,j)`, with C the
//! slope of the creep law at small creepage and φ = χ³ how far it has fallen at this force (`schedule`). χ is at most what a
//! dry rail gives, and what the mean slip of the last second shows. While coasting this shows the difference of the radii, while braking
//! that of the brakes. The error of the creep law does not average out: it is the same for many seconds. A constant
//! error of size σ that lasts τ weighs like white noise of variance 2 σ² τ / Δt in updates every Δt.

use super::layout::Layout;
use super::{DrivenSample, WagonEkf};
use nalgebra::SVector;

/// Time between ties, s.
const INTERVAL_S: f64 = 0.05;
/// Time for which a tie counts as such, s.
const TIE_COUNTS_S: f64 = 1.0;
/// Time over which the error of the creep law persists in the difference of two wheelsets, s.
const PERSISTENCE_S: f64 = 10.0;
/// The same in the creepage of one wheelset, s: the stiffness of the contact is that of the rail and the day, and a level of
/// creepage that errs by as much in each braking would carry the pads further away each time.
const LEVEL_PERSISTENCE_S: f64 = 600.0;
/// Difference of radii that comes and goes with the run of the wheel on the rail, relative.
const RADIUS_WANDER: f64 = 3e-5;
/// Delay between the sensors of wheel and vehicle speed that cannot be excluded, s.
const SENSOR_DELAY_S: f64 = 0.1;
/// Below this ratio of force over creepage to that of small creepage, contacts are too near their limit to compare forces.
const LEAST_SECANT: f64 = 0.6;
/// How much the ratio seen in slip must fall short of a dry rail's before it counts: noise and delay of the speeds feign slip.
const SECANT_MARGIN: f64 = 0.1;

impl<const W: usize, const N: usize> WagonEkf<W, N> {
    /// Counts time, and ties the creepages when it is time to.
    pub(super) fn tie_when_due(&mut self, sample: &DrivenSample, dt_s: f64) {
        self.since_tie_s += dt_s;
        if self.since_tie_s >= INTERVAL_S {
            self.tie_creepages(sample);
            self.since_tie_s = 0.0;
        }
    }

    /// Ties neighbouring wheelsets by creepage, and each wheelset to the vehicle speed.
    fn tie_creepages(&mut self, sample: &DrivenSample) {
        self.untied_s += self.since_tie_s;
        if self.untied_s > TIE_COUNTS_S {
            self.tied = 0;
        }
        if self.belief.mean[0] < 3.0 {
            return;
        }
        let mut tied = 0;
        let rolls = |filter: &Self, i: usize| {
            filter.contacts[i].secant > LEAST_SECANT
                && filter.watches[i].certainty(filter.step_s) == 0.0
                && sample.wheel_speed_rad_s[i].is_finite()
        };
        for i in 0..W {
            if rolls(self, i) && sample.v_m_s.is_finite() {
                self.tie_to_vehicle(i);
            }
            if i + 1 < W && rolls(self, i) && rolls(self, i + 1) {
                tied += self.tie_neighbours(i);
            }
        }
        if tied > 0 {
            (self.tied, self.untied_s) = (tied, 0.0);
        }
    }

    /// Slip velocity of wheelset `i` minus that which its force asks for, m/s; its derivative; and that force's part.
    fn slip_residual(&self, i: usize) -> (f64, SVector<f64, N>, f64) {
        let at = Layout::<W, N>::INDICES;
        let (x, physics) = (&self.belief.mean, &self.physics);
        let radius = physics.wheel_radius_m[i];
        let compliance = x[0] / physics.creep_slope_n * physics.loads.static_load_n[i];
        let asked = compliance * x[at.adhesion + i];
        let mut h = SVector::<f64, N>::zeros();
        h[0] = -1.0 - asked / x[0];
        h[at.wheel + i] = radius * (1.0 + x[at.radius + i]);
        h[at.radius + i] = radius * x[at.wheel + i];
        h[at.adhesion + i] = -compliance;
        (radius * (1.0 + x[at.radius + i]) * x[at.wheel + i] - x[0] - asked, h, asked)
    }

    /// Ties wheelsets `i` and `i + 1`; says how many ties that were.
    fn tie_neighbours(&mut self, i: usize) -> u32 {
        let (front, h_front, asked_front) = self.slip_residual(i);
        let (rear, h_rear, asked_rear) = self.slip_residual(i + 1);
        let secant = self.secant(i).min(self.secant(i + 1));
        if secant < LEAST_SECANT {
            return 0;
        }
        let at = Layout::<W, N>::INDICES;
        let bend = 1.0 / (secant * secant * secant) - 1.0;
        let difference = asked_front - asked_rear;
        let mut h = h_front - h_rear;
        for k in [i, i + 1] {
            h[at.adhesion + k] *= 1.0 + bend;
        }
        let systematic = (self.config.priors.creep_law * (1.0 + bend) + 0.5 * bend) * difference;
        let wander = RADIUS_WANDER * self.belief.mean[0];
        let residual = front - rear - bend * difference;
        self.fuse_tie(&h, residual, systematic * systematic + wander * wander);
        1
    }

    /// Force over creepage of wheelset `i` against that of small creepage. Polach's law: about 1 − y² at the share y of
    /// the limit; no rail counts as better than dry.
    fn secant(&self, i: usize) -> f64 {
        let at = Layout::<W, N>::INDICES;
        let share = self.belief.mean[at.adhesion + i].abs() / self.dry_adhesion;
        (1.0 - share * share).max(0.0).min(self.mean_slips[i].secant() + SECANT_MARGIN)
    }

    fn tie_to_vehicle(&mut self, i: usize) {
        let (residual, h, asked) = self.slip_residual(i);
        let law = 2.0 * self.config.priors.creep_law * asked;
        let acceleration = self.sensitivity_acceleration();
        let delay = SENSOR_DELAY_S * acceleration;
        let wander = RADIUS_WANDER * self.belief.mean[0];
        let lasting = LEVEL_PERSISTENCE_S / PERSISTENCE_S;
        self.fuse_tie(&h, residual, lasting * law * law + delay * delay + wander * wander);
    }

    /// Acceleration at the present belief, m/s², resistance left out but where it is a part of the disturbance.
    fn sensitivity_acceleration(&self) -> f64 {
        let at = Layout::<W, N>::INDICES;
        (0..W).map(|i| self.belief.mean[at.adhesion + i] * self.physics.loads.static_load_n[i]).sum::<f64>()
            / self.physics.mass_kg
            + if self.coupled { self.disturbance_m_s2 * self.belief.mean[at.disturbance] } else { 0.0 }
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
