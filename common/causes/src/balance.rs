//! The balance of forces of a wagon that runs alone: no coupler hands force on, so its deceleration tells its brakes.

use crate::creepage::{Creep, Creepage};
use crate::input::WagonFile;
use crate::second::{SECOND_S, WagonSecond};

/// Standard gravity, m/s².
const GRAVITY_M_S2: f64 = 9.80665;

/// A second as the balance sees it, all over the weight: what accelerates, what the pads do by the file, what drives.
pub(crate) fn balance(
    file: &WagonFile,
    second: &WagonSecond,
    v_m_s: f64,
    a_m_s2: f64,
    samples: f64,
) -> Option<Creep> {
    let weight_n = file.mass_kg * GRAVITY_M_S2;
    let [constant, linear, drag] = file.resistance;
    let resistance_n = constant + linear * v_m_s + drag * v_m_s * v_m_s;
    let grade = if second.grade_rad.is_finite() { second.grade_rad.sin() } else { return None };
    let wheels = &second.wheel[..file.wheelsets];
    let pads_n: f64 = wheels
        .iter()
        .map(|wheel| file.pad_friction * wheel.press_n * file.pad_radius_m / file.radius_m)
        .sum();
    let drive_n: f64 = wheels.iter().map(|wheel| wheel.drive_nm / file.radius_m).sum();
    let turning_kg = file.wheelsets as f64 * file.inertia_kg_m2 / (file.radius_m * file.radius_m);
    let accelerated_n = (file.mass_kg + turning_kg) * a_m_s2 + weight_n * grade;
    let slope_variance = 12.0 * Creepage::of_mean(file.speed_sigma_m_s, samples) / (SECOND_S * SECOND_S);
    let creep = Creep {
        creepage: (accelerated_n + resistance_n) / weight_n,
        brake: pads_n / weight_n,
        drive: drive_n / weight_n,
        rate: accelerated_n / weight_n,
        variance: slope_variance / (GRAVITY_M_S2 * GRAVITY_M_S2),
    };
    creep.brake.is_finite().then_some(creep)
}
