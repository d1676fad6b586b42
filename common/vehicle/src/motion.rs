//! The equations of motion of a wagon, each once. Every model, integrator and filter of speeds uses these.
//!
//! Schwarz & Keck (1) and (6) in the sign convention of this crate (forces forward positive, a brake torque
//! positive against forward rotation). With (2) and (4) follows `v̇ = μ_W g + …`; the paper's (5) has `g/2`, which is wrong.
//!
//! ```text
//! wheelset  J ω̇ = M − T_B − r F_x
//! body      m v̇ = Σ F_x − R(v) + F_other
//! ```
//!
//! | symbol | meaning | from |
//! | --- | --- | --- |
//! | `F_x = μ_W F_z` | contact force on the wagon, N | [`crate::adhesion`], or a state of a filter |
//! | `F_z` | normal load, N | [`crate::load`] |
//! | `T_B = μ_B F_⊥ r_B` | brake torque, N m | [`crate::brake::pad_torque_nm`] |
//! | `R(v)` | running resistance, N | [`crate::resistance`] |
//! | `F_other` | grade, couplers and effects, N | [`crate::resistance::grade_force`], [`crate::effects`] |
//!
//! Valid for longitudinal motion of a rigid body with rigid wheelsets; elasticity comes as an effect.

/// Angular acceleration of a wheelset, rad/s²: `ω̇ = (M − T_B − r F_x) / J`.
///
/// `brake_torque_nm` is the torque as it acts: negative against backward rotation, and at standstill what holds.
#[inline]
pub fn wheelset_acceleration_rad_s2(
    inertia_kg_m2: f64,
    wheel_radius_m: f64,
    drive_torque_nm: f64,
    brake_torque_nm: f64,
    contact_force_n: f64,
) -> f64 {
    (drive_torque_nm - wheel_radius_m * contact_force_n - brake_torque_nm) / inertia_kg_m2
}

/// The same equation solved for the contact force, N: that with which a wheelset turns at a given `ω̇`.
#[inline]
pub fn contact_force_of_wheelset_n(
    inertia_kg_m2: f64,
    wheel_radius_m: f64,
    drive_torque_nm: f64,
    brake_torque_nm: f64,
    acceleration_rad_s2: f64,
) -> f64 {
    (drive_torque_nm - brake_torque_nm - inertia_kg_m2 * acceleration_rad_s2) / wheel_radius_m
}

/// Acceleration of the body, m/s²: `v̇ = (Σ F_x − R + F_other) / m`.
///
/// Where loads and acceleration must agree while the *adhesions* are given, see
/// [`crate::load::LoadDistribution::acceleration_m_s2`].
#[inline]
pub fn body_acceleration_m_s2(mass_kg: f64, contact_force_n: f64, resistance_n: f64, other_n: f64) -> f64 {
    (contact_force_n - resistance_n + other_n) / mass_kg
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wheelset_that_keeps_pace_transmits_what_its_torques_leave() {
        let (inertia, radius, drive, brake) = (120.0, 0.46, 300.0, 2500.0);
        for acceleration in [-2.0, 0.0, 0.7] {
            let force = contact_force_of_wheelset_n(inertia, radius, drive, brake, acceleration);
            let back = wheelset_acceleration_rad_s2(inertia, radius, drive, brake, force);
            assert!((back - acceleration).abs() < 1e-12);
        }
        let braked = contact_force_of_wheelset_n(inertia, radius, 0.0, brake, 0.0);
        assert!(braked < 0.0, "braking pulls the wagon back");
    }
}
