//! Torque of a disc brake: what pads pressed on discs hold, and its inversions.
//!
//! Schwarz & Keck (6) and (7): `T_B = μ_B F_⊥ r_B`, with μ_B the coefficient between pad and disc (dimensionless), F_⊥ the
//! force that presses the pads of one wheelset (N, counted so that one μ_B stands for both faces of a disc) and r_B the mean
//! friction radius (m). Valid while the disc turns; at standstill it is the largest torque that holds.

/// Brake torque of a wheelset, N m: `μ_B F_⊥ r_B`.
#[inline]
pub fn pad_torque_nm(brake_friction: f64, pad_force_n: f64, brake_radius_m: f64) -> f64 {
    brake_friction * pad_force_n * brake_radius_m
}

/// Pressing force, N, at which the pads of a rolling wheelset hold `brake_force_n` at its rim:
/// `F_⊥ = F_x r_W / (μ_B r_B)`, without the inertia of the wheelset.
#[inline]
pub fn pressing_force_for_n(
    brake_force_n: f64,
    wheel_radius_m: f64,
    brake_friction: f64,
    brake_radius_m: f64,
) -> f64 {
    brake_force_n * wheel_radius_m / (brake_friction * brake_radius_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pressing_force_for_a_brake_force_gives_its_torque() {
        let force_n = pressing_force_for_n(1.2e4, 0.46, 0.35, 0.25);
        assert!((pad_torque_nm(0.35, force_n, 0.25) - 1.2e4 * 0.46).abs() < 1e-9);
    }
}
