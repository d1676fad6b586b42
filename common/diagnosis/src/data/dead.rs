//! Sensors that do not measure, and recordings in which nothing happens.

use crate::data::units::UnitError;
use railgrip_recording::{Quantity, Recording};

/// Slower than this a wagon counts as standing, m/s.
pub const MOVES_FROM_M_S: f64 = 2.0;
/// Change of another speed from which one that never changes does not measure, m/s at the rim.
const RUNS_BY_M_S: f64 = 3.0;

/// Refuses a speed that reads one value from the first row to the last while another one changes.
///
/// # Errors
/// The column, what it reads, and what runs meanwhile.
pub fn check(run: &Recording, radius_m: f64) -> Result<(), UnitError> {
    let speeds = || {
        let wheels = run.wheel_speed_rad_s.iter().enumerate();
        let wheels =
            wheels.map(|(i, column)| (Quantity::WheelSpeed.column(i, run.wheelsets), column, radius_m));
        std::iter::once((Quantity::Speed.column(0, run.wheelsets), &run.v_m_s, 1.0)).chain(wheels)
    };
    let held = |column: &[f64]| range(column).filter(|[low, high]| low == high).map(|[low, _]| low);
    let Some((column, value)) = speeds().find_map(|(name, column, _)| Some((name, held(column)?))) else {
        return Ok(());
    };
    let swing = |column: &[f64], to_m_s: f64| range(column).map_or(0.0, |[low, high]| to_m_s * (high - low));
    match speeds().find(|(_, column, to_m_s)| swing(column, *to_m_s) > RUNS_BY_M_S) {
        None => Ok(()),
        Some((other, values, to_m_s)) => Err(UnitError {
            column,
            t_s: run.t_s[0],
            why: format!(
                "reads {value} throughout while {other} changes by {:.0} m/s: a sensor that is dead, or a wheelset that never turns; \
                 leave this run out",
                swing(values, to_m_s)
            ),
        }),
    }
}

/// Whether the vehicle runs at all, by any of its speeds.
pub fn moves(run: &Recording, radius_m: f64) -> bool {
    let beyond =
        |column: &[f64], to_m_s: f64| column.iter().any(|value| to_m_s * value.abs() >= MOVES_FROM_M_S);
    beyond(&run.v_m_s, 1.0) || run.wheel_speed_rad_s.iter().any(|column| beyond(column, radius_m))
}

/// Least and largest of what was measured; `None` where nothing was.
fn range(column: &[f64]) -> Option<[f64; 2]> {
    let finite = column.iter().copied().filter(|value| value.is_finite());
    finite.map(|value| [value, value]).reduce(|[low, high], [value, _]| [low.min(value), high.max(value)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_recording::Optional;

    /// A stop from 20 m/s in 20 s, ten samples a second.
    fn stop() -> Recording {
        let mut run = Recording::empty("stop", None, 2, Optional::NONE);
        run.t_s = (0..200).map(|k| 0.1 * f64::from(k)).collect();
        run.v_m_s = run.t_s.iter().map(|t| 20.0 - t).collect();
        run.wheel_speed_rad_s = vec![run.v_m_s.iter().map(|v| v / 0.46).collect(); 2];
        run
    }

    #[test]
    fn a_speed_that_never_changes_while_another_does_is_told() {
        assert_eq!(check(&stop(), 0.46), Ok(()));
        for (column, value) in [(0, 20.0), (1, 0.0), (2, 17.25)] {
            let mut run = stop();
            match column {
                0 => run.v_m_s.fill(value),
                wheel => run.wheel_speed_rad_s[wheel - 1].fill(value),
            }
            // Nothing was measured here and there.
            run.v_m_s[7] = f64::NAN;
            let error = check(&run, 0.46).expect_err("dead");
            assert_eq!(error.column, ["v_m_s", "omega_f_rad_s", "omega_r_rad_s"][column]);
            assert!(error.why.starts_with(&format!("reads {value} throughout")), "{error}");
        }
    }

    #[test]
    fn a_vehicle_that_stands_or_rolls_evenly_has_no_dead_sensor() {
        let mut run = stop();
        run.v_m_s.fill(0.0);
        run.wheel_speed_rad_s.iter_mut().for_each(|column| column.fill(0.0));
        assert_eq!(check(&run, 0.46), Ok(()));
        assert!(moves(&stop(), 0.46) && !moves(&run, 0.46));
    }
}
