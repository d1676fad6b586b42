//! Creep force after Polach, with falling friction.
//!
//! Source: Polach, "Creep forces in simulations of traction vehicles running on adhesion limit", Wear 258 (2005),
//! in the longitudinal form and notation of Schwarz & Keck and of Zhao et al. (their Table 1 with rows B and D
//! exchanged back: the ratio A is 0.40 on all rails, the decay B is 0.60 / 0.20 / 0.20 / 0.10 s/m).

use crate::Contact;
use std::f64::consts::FRAC_2_PI;
use wide::f64x2;

/// A creep force and its slope.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactForce {
    /// Tangential force on the wagon, N, signed like the creepage.
    pub force_n: f64,
    /// Derivative of the force with respect to the rim speed r ω, N/(m/s).
    pub slope_n_s_per_m: f64,
}

/// Friction coefficient at slip velocity `slip_velocity_m_s` = |r ω − v|: `μ0 [(1 − A) e^(−B w) + A]`, and its
/// derivative with respect to w, s/m.
#[inline]
pub fn friction(contact: &Contact, adhesion_peak: f64, slip_velocity_m_s: f64) -> (f64, f64) {
    let ratio = contact.friction_ratio;
    if ratio >= 1.0 || contact.friction_decay_s_per_m == 0.0 {
        return (adhesion_peak, 0.0);
    }
    let decay = contact.friction_decay_s_per_m;
    let falling = (1.0 - ratio) * (-decay * slip_velocity_m_s).exp();
    (adhesion_peak * (falling + ratio), -adhesion_peak * decay * falling)
}

/// Slope of the creep force over creepage where creepage is small, N: `(2/π) (k_A + k_S) K`, whatever load and rail.
#[inline]
pub fn initial_creep_slope_n(contact: &Contact) -> f64 {
    FRAC_2_PI * (contact.k_a + contact.k_s) * contact.stiffness_n
}

/// Creep force of one wheelset, N, on the wagon:
/// `F = sign(s) (2 Q μ / π) [k_A ε / (1 + (k_A ε)²) + atan(k_S ε)]`, `ε = K |s| / (Q μ)`.
///
/// `rim_speed_m_s` = r ω, `normal_load_n` = Q, `adhesion_peak` = μ0. A wheelset without load transmits nothing.
#[inline]
pub fn creep_force(
    contact: &Contact,
    rim_speed_m_s: f64,
    v_m_s: f64,
    normal_load_n: f64,
    adhesion_peak: f64,
) -> ContactForce {
    let reference_speed = v_m_s.max(crate::CREEPAGE_SPEED_FLOOR_M_S);
    creep_force_at(contact, rim_speed_m_s - v_m_s, reference_speed, normal_load_n, adhesion_peak)
}

/// [`creep_force`] at a slip velocity r ω − v and the speed that its creepage is referred to: another contact
/// partner (a roller) may define that speed otherwise.
#[inline]
pub fn creep_force_at(
    contact: &Contact,
    slip_velocity_m_s: f64,
    reference_speed_m_s: f64,
    normal_load_n: f64,
    adhesion_peak: f64,
) -> ContactForce {
    let slip_velocity = slip_velocity_m_s;
    let (mu, mu_slope) = friction(contact, adhesion_peak, slip_velocity.abs());
    let limit = normal_load_n * mu;
    if limit <= 0.0 {
        return ContactForce::default();
    }
    let gain = contact.stiffness_n / (limit * reference_speed_m_s);
    let epsilon = gain * slip_velocity.abs();
    let adhesion_part = contact.k_a * epsilon;
    let slip_part = contact.k_s * epsilon;
    let denominator = 1.0 + adhesion_part * adhesion_part;
    let saturation = FRAC_2_PI * (adhesion_part / denominator + slip_part.atan());
    let saturation_slope = FRAC_2_PI
        * (contact.k_a * (1.0 - adhesion_part * adhesion_part) / (denominator * denominator)
            + contact.k_s / (1.0 + slip_part * slip_part));
    // ε itself depends on μ(w), hence the second term of the slope.
    let epsilon_slope = gain - epsilon * mu_slope / mu;
    ContactForce {
        force_n: slip_velocity.signum() * limit * saturation,
        slope_n_s_per_m: normal_load_n * mu_slope * saturation + limit * saturation_slope * epsilon_slope,
    }
}

/// [`creep_force_at`] of two wheelsets at once, as wide as a processor's registers, for whoever simulates a wagon millions
/// of times: forces, N, and their slopes over rim speed, N/(m/s). The same to rounding.
#[inline]
pub(crate) fn creep_force_pair_at(
    contact: &Contact,
    slip_velocity_m_s: f64x2,
    reference_speed_m_s: f64,
    normal_load_n: f64x2,
    adhesion_peak: f64x2,
) -> (f64x2, f64x2) {
    let one = f64x2::ONE;
    let (size, load, peak) = (slip_velocity_m_s.abs(), normal_load_n, adhesion_peak);
    let (ratio, decay) = (contact.friction_ratio, contact.friction_decay_s_per_m);
    let (mu, mu_slope) = if ratio >= 1.0 || decay == 0.0 {
        (peak, f64x2::ZERO)
    } else {
        let falling = (1.0 - ratio) * (size * -decay).exp();
        (peak * (falling + ratio), peak * falling * -decay)
    };
    let limit = load * mu;
    // Divisions are what the law costs: reciprocals are shared.
    let per_limit = one / limit;
    let initial = contact.stiffness_n / reference_speed_m_s;
    let epsilon = per_limit * size * initial;
    let (adhesion_part, slip_part) = (epsilon * contact.k_a, epsilon * contact.k_s);
    let (square, slip_square) = (adhesion_part * adhesion_part, one + slip_part * slip_part);
    let denominator = one + square;
    let both = one / (denominator * slip_square);
    let per_denominator = both * slip_square;
    let saturation = (adhesion_part * per_denominator + slip_part.atan()) * FRAC_2_PI;
    let saturation_slope = ((one - square) * per_denominator * per_denominator * contact.k_a
        + both * denominator * contact.k_s)
        * FRAC_2_PI;
    let force = (limit * saturation) | (slip_velocity_m_s & f64x2::splat(-0.0));
    let slope = load * mu_slope * saturation
        + saturation_slope * (one - size * mu_slope * load * per_limit) * initial;
    // Also where the load is no number.
    let loaded = limit.simd_gt(f64x2::ZERO);
    (loaded & force, loaded & slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn contact() -> Contact {
        Contact { stiffness_n: 6e6, k_a: 1.0, k_s: 0.4, friction_ratio: 0.4, friction_decay_s_per_m: 0.6 }
    }

    #[test]
    fn initial_slope_is_polachs() {
        let constant = Contact { friction_ratio: 1.0, friction_decay_s_per_m: 0.0, ..contact() };
        let at = creep_force(&constant, 20.0 + 1e-9, 20.0, 1.8e5, 0.3);
        let expected = initial_creep_slope_n(&constant) / 20.0;
        assert!((expected / (FRAC_2_PI * 1.4 * 6e6 / 20.0) - 1.0).abs() < 1e-12);
        assert!((at.slope_n_s_per_m / expected - 1.0).abs() < 1e-6, "{at:?}");
    }

    #[test]
    fn saturates_at_the_friction_limit() {
        let constant = Contact { friction_ratio: 1.0, friction_decay_s_per_m: 0.0, ..contact() };
        let force = creep_force(&constant, 0.0, 20.0, 1.8e5, 0.05).force_n;
        assert!((force / (-0.05 * 1.8e5) - 1.0).abs() < 2e-3, "{force}");
    }

    #[test]
    fn slope_agrees_with_central_differences() {
        for slip in [-12.0, -2.0, -0.3, -0.02, 0.01, 0.2, 3.0] {
            for v in [0.1, 0.6, 15.0] {
                let f = |delta: f64| creep_force(&contact(), v + slip + delta, v, 1.1e5, 0.25).force_n;
                let h = 1e-6 * f64::max(1.0, slip.abs());
                let numeric = (f(h) - f(-h)) / (2.0 * h);
                let slope = creep_force(&contact(), v + slip, v, 1.1e5, 0.25).slope_n_s_per_m;
                assert!(
                    (slope - numeric).abs() < 1e-4 * (1.0 + numeric.abs()),
                    "{slip} {v}: {slope} {numeric}"
                );
            }
        }
    }

    #[test]
    fn two_wheelsets_at_once_are_two_wheelsets() {
        let constant = Contact { friction_ratio: 1.0, friction_decay_s_per_m: 0.0, ..contact() };
        let (mut worst, mut count) = (0.0, 0);
        for contact in [contact(), constant] {
            for slips in [[0.0, 1e-7], [-0.02, 0.3], [2.0, -9.0], [-15.0, 1e-4]] {
                for (v, loads) in [(0.0, [1.1e5, 0.9e5]), (0.3, [0.0, 1e5]), (22.0, [1.2e5, 0.8e5])] {
                    let peaks = [0.31, 0.07];
                    let reference = f64::max(v, crate::CREEPAGE_SPEED_FLOOR_M_S);
                    let (force, slope) = creep_force_pair_at(
                        &contact,
                        f64x2::from(slips),
                        reference,
                        f64x2::from(loads),
                        f64x2::from(peaks),
                    );
                    let (force, slope) = (force.to_array(), slope.to_array());
                    for i in 0..2 {
                        let one = creep_force_at(&contact, slips[i], reference, loads[i], peaks[i]);
                        let of = |a: f64, b: f64| (a - b).abs() / (1e-3 + b.abs());
                        worst = of(force[i], one.force_n).max(of(slope[i], one.slope_n_s_per_m)).max(worst);
                        count += 1;
                    }
                }
            }
        }
        println!("{count} forces and slopes, at worst {worst:.1e} apart");
        assert!(worst < 1e-11 && count == 48);
    }

    #[test]
    fn friction_falls_to_its_ratio() {
        let (at_rest, _) = friction(&contact(), 0.3, 0.0);
        let (far, _) = friction(&contact(), 0.3, 100.0);
        assert_eq!(at_rest, 0.3);
        assert!((far - 0.12).abs() < 1e-12);
    }
}
