//! Running resistance and grade.
//!
//! ```text
//! R(v)    = a + b v + k_d (v + w)|v + w|        N, against forward motion
//! F_grade = −m g sin(grade)                    N, forward positive
//! ```
//!
//! Davis (1926), in Schwarz & Keck (1) as F_TR + k_d v²: a rolling (N), b bearings and track (N s/m), k_d air (N s²/m²), w
//! headwind (m/s, positive against the direction of travel), grade in rad, uphill positive. Coast-down tests differ
//! from such figures by factors of 0.7 to 1.3; curves and tunnels are not in it.

use crate::{GRAVITY_M_S2, Resistance};

/// Speed over which the constant part fades in, m/s: at standstill rolling resistance holds and does not push.
pub const ROLLING_FADE_IN_M_S: f64 = 0.1;

/// The constant part of a resistance at a speed, N: `a` in motion, faded in over [`ROLLING_FADE_IN_M_S`] from standstill.
#[inline]
pub fn rolling_resistance(constant_n: f64, v_m_s: f64) -> f64 {
    (v_m_s / ROLLING_FADE_IN_M_S).clamp(-1.0, 1.0) * constant_n
}

/// Running resistance R(v), N, opposing forward motion.
#[inline]
pub fn running_resistance(resistance: &Resistance, v_m_s: f64, wind_m_s: f64) -> f64 {
    let airspeed = v_m_s + wind_m_s;
    rolling_resistance(resistance.constant_n, v_m_s)
        + resistance.linear_n_s_per_m * v_m_s
        + resistance.drag_n_s2_per_m2 * airspeed * airspeed.abs()
}

/// Derivative of [`running_resistance`] with respect to speed, N/(m/s): `b + 2 k_d |v + w|`, and `a` over the fade-in
/// near standstill.
#[inline]
pub fn running_resistance_slope(resistance: &Resistance, v_m_s: f64, wind_m_s: f64) -> f64 {
    let fade_in =
        if v_m_s.abs() < ROLLING_FADE_IN_M_S { resistance.constant_n / ROLLING_FADE_IN_M_S } else { 0.0 };
    fade_in + resistance.linear_n_s_per_m + 2.0 * resistance.drag_n_s2_per_m2 * (v_m_s + wind_m_s).abs()
}

/// Acceleration that a grade gives, `−g sin(grade)`, m/s²; uphill is a positive grade.
#[inline]
pub fn grade_acceleration(grade_rad: f64) -> f64 {
    -GRAVITY_M_S2 * grade_rad.sin()
}

/// Force of a grade on the wagon, `−m g sin(grade)`, N.
#[inline]
pub fn grade_force(mass_kg: f64, grade_rad: f64) -> f64 {
    mass_kg * grade_acceleration(grade_rad)
}

impl Resistance {
    /// The share of one of so many wheelsets.
    pub fn per_wheelset(&self, wheelsets: usize) -> Self {
        let share = 1.0 / wheelsets as f64;
        Self {
            constant_n: share * self.constant_n,
            linear_n_s_per_m: share * self.linear_n_s_per_m,
            drag_n_s2_per_m2: share * self.drag_n_s2_per_m2,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RESISTANCE: Resistance =
        Resistance { constant_n: 500.0, linear_n_s_per_m: 10.0, drag_n_s2_per_m2: 4.0 };

    #[test]
    fn davis_terms_add_up() {
        assert!((running_resistance(&RESISTANCE, 20.0, 0.0) - (500.0 + 200.0 + 1600.0)).abs() < 1e-9);
        assert!((running_resistance(&RESISTANCE, 20.0, 5.0) - (500.0 + 200.0 + 2500.0)).abs() < 1e-9);
        assert_eq!(running_resistance(&RESISTANCE, 0.0, 0.0), 0.0);
    }

    #[test]
    fn the_slope_is_that_of_the_law() {
        for (v, wind) in [(30.0, 3.0), (8.0, -20.0), (0.05, 0.0), (-0.03, 2.0), (-5.0, 1.0)] {
            let at = |step: f64| running_resistance(&RESISTANCE, v + step, wind);
            let numeric = (at(1e-5) - at(-1e-5)) / 2e-5;
            let slope = running_resistance_slope(&RESISTANCE, v, wind);
            assert!((slope - numeric).abs() < 1e-4 * (1.0 + slope), "{v} {wind}: {slope} {numeric}");
        }
    }

    #[test]
    fn uphill_pulls_back() {
        assert!(grade_force(4e4, 0.005) < 0.0);
    }
}
