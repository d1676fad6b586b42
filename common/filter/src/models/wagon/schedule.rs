//! How each wheelset moves, and the noise that goes with it.

use crate::core::Gaussian;
use crate::models::physics::WagonPhysics;

/// Time over which innovations are averaged to see a change, s.
const CHANGE_WINDOW_S: f64 = 0.02;

/// Slip velocity beyond noise and creep from which a wheelset is said to slide, m/s.
const SLIDE_M_S: f64 = 0.1;
/// Slope of the creep law below which it is said to slide.
const SLIDE_ROLLING: f64 = 0.1;

/// How one wheelset moves at this instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Contact {
    /// Slope of contact force over creepage against that of small creepage: 1 rolling, 0 sliding.
    pub rolling: f64,
    /// Contact force over creepage against the same of small creepage.
    pub secant: f64,
    /// Slip velocity r ω − v, radius corrected, m/s.
    pub slip_m_s: f64,
    /// Part of it that is neither noise nor the creep of rolling, m/s.
    pub excess_m_s: f64,
}

impl Contact {
    /// True if the wheelset slides, and does not only creep.
    pub(crate) fn slides(&self) -> bool {
        self.rolling < SLIDE_ROLLING && self.excess_m_s > SLIDE_M_S
    }
}

/// Judges the contact of a wheelset. The slope of Polach's law follows from its secant, whatever the adhesion
/// available: with χ = F/(F'(0) s) the ratio F'(s)/F'(0) is χ³ within 0.03 (k_A = 1, k_S = 0.3 to 0.4, checked in
/// the tests). Two sigmas of the slip are given to noise, so that a rolling wheelset is not taken for a sliding one.
#[inline]
pub(crate) fn judge<const W: usize, const N: usize>(
    physics: &WagonPhysics<W>,
    belief: &Gaussian<N>,
    wheelset: usize,
) -> Contact {
    let at = super::layout::Layout::<W, N>::INDICES;
    let (x, p) = (&belief.mean, &belief.covariance);
    let radius = physics.wheel_radius_m[wheelset];
    let (wheel, wear) = (at.wheel + wheelset, at.radius + wheelset);
    let rim = radius * x[wheel];
    let slip = rim * (1.0 + x[wear]) - x[0];
    let variance = p[(0, 0)] + radius * radius * p[(wheel, wheel)] + rim * rim * p[(wear, wear)]
        - 2.0 * radius * p[(0, wheel)]
        - 2.0 * rim * p[(0, wear)]
        + 2.0 * radius * rim * p[(wheel, wear)];
    let force = x[at.adhesion + wheelset].abs() * physics.loads.static_load_n[wheelset];
    let expected = physics.rolling_slip_m_s(force, x[0]);
    let seen = slip.abs() - 2.0 * variance.max(0.0).sqrt();
    let secant = if seen <= expected { 1.0 } else { expected / seen };
    Contact {
        rolling: secant * secant * secant,
        secant,
        slip_m_s: slip,
        excess_m_s: (seen - expected).max(0.0),
    }
}

/// Watches the innovations of one wheelset speed: several of the same sign mean that adhesion changes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct ChangeWatch {
    /// Mean of normalised innovations over the window.
    pub mean: f64,
}

impl ChangeWatch {
    /// Takes one normalised innovation. One value alone never shows a change.
    #[inline]
    pub(crate) fn note(&mut self, normalised: f64, dt_s: f64) {
        let share = dt_s / (dt_s + CHANGE_WINDOW_S);
        self.mean += share * (normalised.clamp(-4.0, 4.0) - self.mean);
    }

    /// Certainty of a change, 0 to 1: none up to two sigmas of the mean, full from four.
    #[inline]
    pub(crate) fn certainty(&self, dt_s: f64) -> f64 {
        let share = dt_s / (dt_s + CHANGE_WINDOW_S);
        let sigma = (share / (2.0 - share)).sqrt();
        ((self.mean.abs() / sigma - 2.0) / 2.0).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slope_follows_from_the_secant() {
        let mut worst: f64 = 0.0;
        for k_s in [0.3, 0.4] {
            for step in 1..200 {
                let e = 0.05 * f64::from(step);
                let secant = (e / (1.0 + e * e) + (k_s * e).atan()) / ((1.0 + k_s) * e);
                let slope =
                    ((1.0 - e * e) / (1.0 + e * e).powi(2) + k_s / (1.0 + (k_s * e).powi(2))) / (1.0 + k_s);
                worst = worst.max((slope - secant.powi(3)).abs());
            }
        }
        println!("slope against cubed secant: within {worst:.3}");
        assert!(worst < 0.06);
    }

    #[test]
    fn one_outlier_is_no_change_and_three_alike_are() {
        let mut watch = ChangeWatch::default();
        watch.note(40.0, 0.01);
        assert!(watch.certainty(0.01) < 0.6);
        for _ in 0..2 {
            watch.note(4.0, 0.01);
        }
        assert!(watch.certainty(0.01) > 0.9);
    }
}
