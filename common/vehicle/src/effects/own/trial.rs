//! Whether an expression ever gives a number: one that never does would leave its effect out without a word.

use super::expression::Expression;
use super::law::Law;
use crate::effects::Operating;

/// What is said of an expression that gives none.
pub(super) const NEVER: &str = "gives no number, neither at rest nor running, braking, driving or sliding";

/// Speeds that are tried, m/s.
const SPEEDS_M_S: [f64; 4] = [0.0, 3.0, 20.0, 60.0];
/// Radius of the wheels that are tried, m.
const RADIUS_M: f64 = 0.45;

/// Whether an expression gives a finite number at any of some operating points, with parameters at their default, lower or upper
/// values.
pub(super) fn gives_a_number(law: Law, expression: &Expression, parameters: &[[f64; 3]], state: f64) -> bool {
    (0..3).any(|which| {
        let values: Vec<f64> = parameters.iter().map(|of| of[which]).collect();
        points().iter().any(|at| {
            let value = nominal(law, at);
            [state, state + 1.0].iter().any(|state| expression.at(at, 0, &values, *state, value).is_finite())
        })
    })
}

/// Rolling, braking, driving and sliding at some speeds, at the start of a run and later.
fn points() -> Vec<Operating> {
    let mut points = Vec::new();
    for v_m_s in SPEEDS_M_S {
        for (force_n, drive_nm, rolls) in
            [(0.0, 0.0, 1.0), (2e4, 0.0, 0.98), (6e4, 0.0, 0.5), (0.0, 4e3, 1.02)]
        {
            for later in [0.0, 1.0] {
                let wheel_rad_s = rolls * v_m_s / RADIUS_M;
                points.push(Operating {
                    wheelsets: 2,
                    time_s: 100.0 * later,
                    v_m_s,
                    acceleration_m_s2: drive_nm * 1e-4 - force_n * 2e-5,
                    position_m: 1e3 * later,
                    wheelset_position_m: [8.0; _],
                    sanding: later,
                    grade_rad: 0.01 * later,
                    adhesion_peak: [if later > 0.0 { 0.1 } else { 0.3 }; _],
                    wheel_speed_rad_s: [wheel_rad_s; _],
                    pressing_force_n: [force_n; _],
                    drive_torque_nm: [drive_nm; _],
                    brake_power_w: [0.2 * force_n * v_m_s; _],
                    slip_power_w: [1e3 * (1.0 - rolls).abs() * v_m_s; _],
                    wheel_acceleration_rad_s2: [-force_n * 4e-5; _],
                    wheel_angle_rad: [2e3 * later; _],
                    ..Operating::default()
                });
            }
        }
    }
    points
}

/// What a law gives without the effect, about.
fn nominal(law: Law, at: &Operating) -> f64 {
    match law {
        Law::PadForce => at.pressing_force_n[0],
        Law::BrakeFriction => 0.35,
        Law::BrakeTorque => 0.35 * 0.25 * at.pressing_force_n[0],
        Law::DriveTorque => at.drive_torque_nm[0],
        Law::Adhesion => at.adhesion_peak[0],
        Law::Headwind => 5.0 * at.sanding,
        Law::BodyForce => 1e3 * at.sanding,
        Law::SpeedReading => at.v_m_s,
        Law::WheelSpeedReading => at.wheel_speed_rad_s[0],
    }
}
