//! Running resistance and grade.

use crate::{GRAVITY_M_S2, Resistance};

/// Running resistance after Davis plus drag, `a + b v + k_d (v + w)|v + w|`, N, opposing forward motion.
///
/// `wind_m_s` is the headwind w, positive against the direction of travel. At standstill rolling resistance holds;
/// the constant part is therefore faded in over the first 0.1 m/s instead of jumping.
pub fn running_resistance(resistance: &Resistance, v_m_s: f64, wind_m_s: f64) -> f64 {
    let airspeed = v_m_s + wind_m_s;
    let rolling = (v_m_s / 0.1).clamp(-1.0, 1.0) * resistance.constant_n;
    rolling + resistance.linear_n_s_per_m * v_m_s + resistance.drag_n_s2_per_m2 * airspeed * airspeed.abs()
}

/// Force of a grade on the wagon, `−m g sin(grade)`, N; uphill is a positive grade.
pub fn grade_force(mass_kg: f64, grade_rad: f64) -> f64 {
    -mass_kg * GRAVITY_M_S2 * grade_rad.sin()
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
    fn uphill_pulls_back() {
        assert!(grade_force(4e4, 0.005) < 0.0);
    }
}
