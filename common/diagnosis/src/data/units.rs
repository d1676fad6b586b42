//! Whether the columns of a run can be in the units that they should be in: speeds of body and wheels must agree while the
//! wheels roll, and a train does not slow hard without brakes. Only what no effect could do is refused.

use crate::data::case::{Columns, WHEELSETS};
use railgrip_vehicle::VehicleParameters;

/// Slower than this, ratios of speeds say nothing, m/s.
const LEAST_SPEED_M_S: f64 = 3.0;
/// Samples above that speed that a ratio needs.
const LEAST_SAMPLES: usize = 50;
/// Rim speed over vehicle speed: below and above it, units differ. Wheels that are locked now and then roll at other times.
const RATIO: [f64; 2] = [0.5, 2.0];
/// Share of the samples that must agree all the same.
const ROLLING_SHARE: f64 = 0.01;
/// Pressing forces that never exceed this do not brake, N.
const IDLE_FORCE_N: f64 = 1000.0;
/// Slowing by more than this, beyond what the grade does, takes a brake, m/s².
const BRAKED_M_S2: f64 = 0.6;
/// Over this time, s.
const SLOWING_S: f64 = 3.0;

/// A column that cannot be in its unit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("column {column}: {why}")]
pub struct UnitError {
    /// Its name.
    pub column: &'static str,
    /// What gives it away, and what is expected.
    pub why: String,
}

const WHEEL_COLUMNS: [&str; WHEELSETS] = ["omega_f_rad_s", "omega_r_rad_s"];

/// Refuses columns in the wrong unit.
///
/// # Errors
/// The column, and what gives it away.
pub fn check(columns: &Columns, vehicle: &VehicleParameters) -> Result<(), UnitError> {
    let ratios: Vec<Option<[f64; 2]>> =
        (0..WHEELSETS).map(|i| extremes(columns, i, vehicle.wheelset.radius_m)).collect();
    let off = |i: usize| ratios[i].filter(|[low, high]| *high < RATIO[0] || *low > RATIO[1]);
    match (off(0), off(1)) {
        (Some(ratio), Some(_)) => {
            return Err(UnitError { column: "v_m_s", why: disagreement(ratio) });
        }
        (Some(ratio), None) => return Err(UnitError { column: WHEEL_COLUMNS[0], why: disagreement(ratio) }),
        (None, Some(ratio)) => return Err(UnitError { column: WHEEL_COLUMNS[1], why: disagreement(ratio) }),
        (None, None) => {}
    }
    forces(columns)
}

fn disagreement([low, high]: [f64; 2]) -> String {
    format!(
        "the wheels' rims run at {:.2} times the vehicle's speed throughout; expected are m/s (not km/h), rad/s (not rpm) and \
         the radius of the vehicle file",
        0.5 * (low + high)
    )
}

/// Rim speed over vehicle speed of a wheelset: what all but a hundredth of the samples exceed, and stay below.
fn extremes(columns: &Columns, wheelset: usize, radius_m: f64) -> Option<[f64; 2]> {
    let pairs = columns.v_m_s.iter().zip(&columns.wheel_speed_rad_s[wheelset]);
    let mut ratios: Vec<f64> =
        pairs.filter(|(v, _)| **v > LEAST_SPEED_M_S).map(|(v, omega)| radius_m * omega / v).collect();
    if ratios.len() < LEAST_SAMPLES {
        return None;
    }
    ratios.sort_by(f64::total_cmp);
    let at = |share: f64| ratios[((ratios.len() - 1) as f64 * share) as usize];
    Some([at(ROLLING_SHARE), at(1.0 - ROLLING_SHARE)])
}

/// Forces in kN look like brakes that are never applied on a train that stops.
fn forces(columns: &Columns) -> Result<(), UnitError> {
    let most = columns.pressing_force_n.iter().flatten().fold(0.0_f64, |most, force| most.max(*force));
    let driven = columns.drive_torque_nm.iter().flatten().any(|torque| torque.abs() > 1.0);
    let n = columns.t_s.len();
    if most > IDLE_FORCE_N || driven || n < 2 {
        return Ok(());
    }
    let dt_s = (columns.t_s[n - 1] - columns.t_s[0]) / (n - 1) as f64;
    let span = (SLOWING_S / dt_s).round() as usize;
    let uphill = columns.grade_rad.iter().fold(0.0_f64, |most, grade| most.max(*grade));
    let slowing = columns.v_m_s.iter().zip(columns.v_m_s.iter().skip(span));
    let hardest = slowing.map(|(before, after)| (before - after) / SLOWING_S).fold(0.0, f64::max);
    if hardest - railgrip_vehicle::GRAVITY_M_S2 * uphill < BRAKED_M_S2 {
        return Ok(());
    }
    Err(UnitError {
        column: "f_perp_f_n",
        why: format!(
            "at most {most:.0} N in either column while the vehicle slows by {hardest:.1} m/s²; expected is N, not kN or bar"
        ),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn braking() -> Columns {
        let n = 3000;
        let v = |k: usize| 30.0 - 0.008 * k as f64;
        Columns {
            t_s: (0..n).map(|k| 0.01 * k as f64).collect(),
            v_m_s: (0..n).map(v).collect(),
            // The front wheelset locks after a second.
            wheel_speed_rad_s: [
                (0..n).map(|k| if k < 100 { v(k) / 0.45 } else { 0.0 }).collect(),
                (0..n).map(|k| v(k) / 0.45).collect(),
            ],
            pressing_force_n: [vec![3e4; n], vec![3e4; n]],
            drive_torque_nm: [vec![0.0; n], vec![0.0; n]],
            ..Columns::default()
        }
    }

    fn vehicle() -> VehicleParameters {
        toml::from_str(
            "schema = 1\nname = \"x\"\nbody = { mass_kg = 40000.0, com_height_m = 1.6, wheelbase_m = 10.0 }\n\
             wheelset = { radius_m = 0.45, inertia_kg_m2 = 120.0 }\nbrake = { radius_m = 0.25, friction_coefficient = 0.35 }\n\
             resistance = { constant_n = 400.0, linear_n_s_per_m = 8.0, drag_n_s2_per_m2 = 4.0 }\n\
             contact = { stiffness_n = 6.0e6, k_a = 1.0, k_s = 0.4 }\nrail = { dry = 0.3, wet = 0.12, low = 0.06 }\n\
             sensors = { sample_rate_hz = 100.0, speed_sigma_m_s = 0.03, wheel_speed_sigma_rad_s = 0.03, \
             pressing_force_sigma_n = 150.0 }\n",
        )
        .expect("vehicle")
    }

    #[test]
    fn units_are_told_from_effects() {
        let column = |change: &dyn Fn(&mut Columns)| {
            let mut columns = braking();
            change(&mut columns);
            check(&columns, &vehicle()).err().map(|error| {
                println!("{error}");
                error.column
            })
        };
        let scale = |values: &mut Vec<f64>, factor: f64| values.iter_mut().for_each(|value| *value *= factor);
        assert_eq!(column(&|_| ()), None);
        assert_eq!(column(&|c| scale(&mut c.v_m_s, 1.1)), None);
        assert_eq!(column(&|c| scale(&mut c.v_m_s, 3.6)), Some("v_m_s"));
        assert_eq!(column(&|c| scale(&mut c.wheel_speed_rad_s[1], 9.55)), Some("omega_r_rad_s"));
        assert_eq!(
            column(&|c| c.pressing_force_n.iter_mut().for_each(|f| scale(f, 1e-3))),
            Some("f_perp_f_n")
        );
    }
}
