//! What recordings do not show, so that nobody takes silence about it for an answer.

use crate::data::case::{Case, Run, Sample};
use crate::data::dead::MOVES_FROM_M_S;

/// Recordings shorter than this say little of anything, s: six windows of ten seconds. Set by hand.
const SHORT_S: f64 = 60.0;
/// Least time in a situation for its effects to show, s. Set by hand: half a window.
const LEAST_S: f64 = 5.0;
/// Least range of speed that tells a law of speed from a constant, m/s. Set by hand.
const LEAST_RANGE_M_S: f64 = 5.0;
/// Pressing force of all wheelsets from which the brake acts, N.
const BRAKES_FROM_N: f64 = 2000.0;
/// Torque of all wheelsets from which the wagon is driven, N m.
const DRIVES_FROM_NM: f64 = 200.0;

/// What recordings do not show.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Lack {
    /// In words, to be read after *the recording does not show*.
    pub words: String,
    /// Whether nothing that is found in them can be relied on.
    pub grave: bool,
}

/// What the runs of a case to fit on do not show; empty where they show enough.
pub fn of(case: &Case) -> Vec<Lack> {
    let total_s = seconds(case, |_| true);
    let braking_s = seconds(case, |sample| moves(sample) && brakes(sample));
    let coasting_s = seconds(case, |sample| moves(sample) && !brakes(sample) && !drives(sample));
    let speeds = || case.fit.iter().flat_map(|run| &run.samples).map(|sample| sample.smooth[0]);
    let (least, most) = (speeds().fold(f64::INFINITY, f64::min), speeds().fold(0.0, f64::max));
    let range_m_s = (most - least.max(0.0)).max(0.0);
    let mut recordings: Vec<&str> = case.fit.iter().map(|run| run.name.as_str()).collect();
    recordings.dedup();
    let mut lacks = Vec::new();
    let mut add = |words: String, grave: bool| lacks.push(Lack { words, grave });
    if total_s < SHORT_S {
        add(format!("it is only {total_s:.0} s long"), true);
    }
    if braking_s < LEAST_S {
        add(
            format!(
                "the brake acts for {braking_s:.0} s only: what pads, cylinders and rigging do can hardly be seen"
            ),
            false,
        );
    }
    if coasting_s < LEAST_S {
        add(
            format!(
                "the wagon coasts for {coasting_s:.0} s only: resistance, gradient and mass can hardly be told apart"
            ),
            false,
        );
    }
    if range_m_s < LEAST_RANGE_M_S {
        add(
            format!(
                "the speed varies by {range_m_s:.0} m/s only: laws that depend on speed cannot be told from constant ones"
            ),
            false,
        );
    }
    if recordings.len() < 2 {
        add("it is one run: no finding is confirmed by runs that were left out".to_owned(), false);
    }
    lacks
}

fn seconds(case: &Case, counts: impl Fn(&Sample) -> bool) -> f64 {
    let of = |run: &Run| run.samples.iter().filter(|sample| counts(sample)).count() as f64 * run.dt_s;
    case.fit.iter().map(of).sum()
}

fn moves(sample: &Sample) -> bool {
    sample.smooth[0] >= MOVES_FROM_M_S
}

fn brakes(sample: &Sample) -> bool {
    sample.input.pressing_force_n.iter().sum::<f64>() >= BRAKES_FROM_N
}

fn drives(sample: &Sample) -> bool {
    sample.input.mid_drive_torque_nm.iter().map(|torque| torque.abs()).sum::<f64>() >= DRIVES_FROM_NM
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::case::Columns;
    use crate::data::noise::SensorNoise;
    use railgrip_vehicle::{RailClass, VehicleParameters};

    /// A run of so many seconds at 20 Hz with these speeds and forces over time.
    fn run(name: &str, length_s: f64, speed: impl Fn(f64) -> f64, force: impl Fn(f64) -> f64) -> Run {
        let t_s: Vec<f64> = (0..(20.0 * length_s) as usize).map(|k| k as f64 / 20.0).collect();
        let each = |of: &dyn Fn(f64) -> f64| t_s.iter().map(|t| of(*t)).collect::<Vec<f64>>();
        let columns = Columns {
            v_m_s: each(&speed),
            wheel_speed_rad_s: vec![each(&|t| speed(t) / 0.46); 2],
            pressing_force_n: vec![each(&force); 2],
            drive_torque_nm: vec![each(&|_| 0.0); 2],
            t_s: t_s.clone(),
            ..Columns::default()
        };
        Run::new(name.to_owned(), RailClass::Dry, &columns)
    }

    fn case(fit: Vec<Run>) -> Case {
        let text = include_str!("../../../../config/vehicle.toml");
        let vehicle: VehicleParameters = toml::from_str(text).expect("the vehicle of the project");
        let noise = SensorNoise::of_file(&vehicle.sensors);
        Case { vehicle, fit, holdout: Vec::new(), noise, notes: Vec::new() }
    }

    #[test]
    fn a_rich_case_lacks_nothing_and_a_poor_one_says_what() {
        let stop = |name| run(name, 40.0, |t| 20.0 - 0.4 * t, |t| if t > 20.0 { 9e3 } else { 0.0 });
        assert_eq!(of(&case(vec![stop("a"), stop("b")])), Vec::new());
        let poor = of(&case(vec![run("a", 30.0, |_| 15.0, |_| 0.0)]));
        println!("{poor:#?}");
        assert_eq!(poor.len(), 4, "short, never brakes, one speed, one run: {poor:?}");
        assert!(
            poor[0].grave && poor[1..].iter().all(|lack| !lack.grave),
            "nothing follows from half a minute"
        );
        let braked = of(&case(vec![run("a", 40.0, |t| 20.0 - 0.4 * t, |_| 9e3), stop("b")]));
        assert!(braked.is_empty(), "half of b coasts: {braked:?}");
        let standing = of(&case(vec![run("a", 80.0, |_| 0.0, |_| 9e3), run("b", 80.0, |_| 0.0, |_| 9e3)]));
        assert_eq!(standing.len(), 3, "it stands: {standing:?}");
    }
}
