//! Whether the columns of a run can be in the units that they should be in: speeds of body and wheels must agree while the
//! wheels roll, and a brake must be strong enough for what it does. Only what no effect could do is refused: a vehicle may coast
//! against its engine, slide, crawl or weigh little.

use railgrip_recording::{Quantity, Recording};
use railgrip_vehicle::{GRAVITY_M_S2, VehicleParameters};
use std::f64::consts::TAU;

/// Slower than this, ratios of speeds say nothing, m/s.
const LEAST_SPEED_M_S: f64 = 3.0;
/// Time above that speed that a ratio needs, s.
const LEAST_TIME_S: f64 = 0.5;
/// Rim speed over vehicle speed: below and above it, units differ. Wheels that are locked now and then roll at other times.
const RATIO: [f64; 2] = [0.5, 2.0];
/// A ratio that never changes lies within these: no effect, worn wheel or speed sensor makes more of it.
const ROLLS: [f64; 2] = [0.8, 1.25];
/// Below this ratio, a wheelset stands.
const LOCKED: f64 = 0.1;
/// Share of the samples that must agree all the same.
const ROLLING_SHARE: f64 = 0.01;
/// Forces that, taken as N, slow the vehicle by less than this do not brake, m/s².
const IDLE_M_S2: f64 = 0.03;
/// Time over which slowing and forces are averaged, s.
const SPAN_S: f64 = 1.0;
/// Averages that are compared, at the least.
const LEAST_SPANS: usize = 20;
/// Averages that are compared among themselves: ten a span, a hundred spans.
const PIECE: usize = 1000;
/// Change of the slowing that a brake must explain, m/s².
const BRAKED_M_S2: f64 = 0.3;
/// Correlation of forces and slowing from which the forces are what slows.
const CORRELATION: f64 = 0.8;
/// What units other than m/s and rad/s, and a diameter, make of a ratio of one.
const KNOWN: [(f64, &str); 8] = [
    (1.0 / 3.6, "in km/h"),
    (0.447, "in miles/h"),
    (1.0 / TAU, "in revolutions a second"),
    (60.0 / TAU, "in rpm"),
    (DIAMETER, "with the diameter in place of the radius"),
    (1.0 / DIAMETER, "with half of the radius"),
    (0.514, "in knots"),
    (-1.0, "with the sign of the other direction"),
];
/// What the diameter makes of it, which is not beyond [`RATIO`].
const DIAMETER: f64 = 2.0;
/// A ratio that is steady stays within this share of what such a unit makes: no slide does.
const STEADY: f64 = 0.03;
/// A change of force counts from so many times its scatter from row to row.
const SCATTERS: f64 = 5.0;

/// Brakes and drives that, taken as N or N m, slow or speed the vehicle by more than this at one wheelset are none: the rail holds
/// less than half of it, and nobody builds a brake that presses for twice what locks its wheels, m/s².
const STRONGEST_M_S2: f64 = 12.0;
/// Pads press and do not pull: less than this is no noise and no offset, N.
const PULL_N: f64 = -2e3;
/// Forces that change by less show no unit, N.
const LEAST_SWING_N: f64 = 2e3;
/// Correlation of two columns that are one signal in two units: what an isolated brake picks up is noise beside it.
const THE_SAME: f64 = 0.95;
/// The steepest adhesion railways have less than 120 ‰; beyond this, a slope is not in rad.
const STEEPEST_RAD: f64 = 0.15;
/// Time for which a force must be impossible without a break, s; what spikes is the filter's business.
const LASTING_S: f64 = 0.5;

/// A column that cannot be in its unit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("column {column}: {why}")]
pub struct UnitError {
    /// Its name.
    pub column: String,
    /// Time of a row that gives it away, s.
    pub t_s: f64,
    /// What gives it away, and what is expected.
    pub why: String,
}

/// Refuses columns in the wrong unit.
///
/// # Errors
/// The column, and what gives it away.
pub fn check(run: &Recording, vehicle: &VehicleParameters) -> Result<(), UnitError> {
    let off: Vec<Option<f64>> =
        (0..run.wheelsets).map(|i| off_ratio(run, i, vehicle.wheelset.radius_m)).collect();
    let Some(first) = off.iter().position(Option::is_some) else {
        possible(run, vehicle)?;
        alike(run)?;
        return forces(run, vehicle);
    };
    let ratio = off[first].unwrap_or(1.0);
    // Where no wheelset ever agrees with the vehicle, its speed is to blame, unless they are far too fast.
    let of_vehicle = ratio < 1.0 && !(0..run.wheelsets).any(|i| agrees(run, i, vehicle.wheelset.radius_m));
    let column = if of_vehicle {
        Quantity::Speed.column(0, run.wheelsets)
    } else {
        Quantity::WheelSpeed.column(first, run.wheelsets)
    };
    let row = run.v_m_s.iter().position(|v| v.abs() > LEAST_SPEED_M_S).unwrap_or(0);
    Err(UnitError { column, t_s: run.t_s[row], why: disagreement(ratio) })
}

/// The same of a few seconds, by speeds and by forces that no vehicle has: refuses a ratio that is the same at all wheelsets throughout,
/// and just what another unit makes.
///
/// # Errors
/// As [`check`].
pub fn check_early(run: &Recording, vehicle: &VehicleParameters) -> Result<(), UnitError> {
    possible(run, vehicle)?;
    let ratios: Option<Vec<_>> =
        (0..run.wheelsets).map(|i| ratios(run, i, vehicle.wheelset.radius_m)).collect();
    let Some(ratios) = ratios.filter(|ratios| !ratios.is_empty()) else { return Ok(()) };
    let steady = |factor: f64| {
        let within = |ratio: &f64| (ratio / factor - 1.0).abs() < STEADY;
        ratios.iter().all(|of_wheelset| of_wheelset.iter().all(within))
    };
    if KNOWN.iter().any(|(factor, _)| steady(*factor)) { check(run, vehicle) } else { Ok(()) }
}

/// Whether a run shows that its columns are in their units: that every wheelset rolls as fast as the vehicle, and, where `forces` were in
/// doubt, that they brake.
pub fn are_shown(run: &Recording, vehicle: &VehicleParameters, forces: bool) -> bool {
    let rolls = |i| ratios(run, i, vehicle.wheelset.radius_m).is_some();
    let lever = vehicle.brake.radius_m / vehicle.wheelset.radius_m / vehicle.body.mass_kg;
    let brakes = |k: usize| {
        let each = run.pressing_force_n.iter().zip(vehicle.pad_friction());
        each.map(|(column, pad)| pad * lever * column[k]).sum::<f64>() > IDLE_M_S2
    };
    (0..run.wheelsets).all(rolls) && (!forces || (0..run.len()).any(brakes))
}

fn disagreement(ratio: f64) -> String {
    let off = |factor: f64| (ratio / factor - 1.0).abs();
    let like =
        KNOWN.iter().min_by(|a, b| off(a.0).total_cmp(&off(b.0))).filter(|(factor, _)| off(*factor) < 0.1);
    let like = like.map_or(String::new(), |(_, why)| format!(", as {why}"));
    format!(
        "the wheels' rims run at {ratio:.2} times the vehicle's speed throughout{like}; expected are m/s (not km/h), rad/s \
         (not rpm) and the radius of the vehicle file"
    )
}

/// Rim speed over vehicle speed of a wheelset, in order of size, where the vehicle runs; nothing of too short a run.
fn ratios(run: &Recording, wheelset: usize, radius_m: f64) -> Option<Vec<f64>> {
    let pairs = run.v_m_s.iter().zip(&run.wheel_speed_rad_s[wheelset]);
    let mut ratios: Vec<f64> = pairs
        .filter(|(v, omega)| v.abs() > LEAST_SPEED_M_S && omega.is_finite())
        .map(|(v, omega)| radius_m * omega / v)
        .collect();
    ratios.sort_by(f64::total_cmp);
    (!ratios.is_empty() && ratios.len() as f64 >= LEAST_TIME_S * run.sample_rate_hz()).then_some(ratios)
}

/// Whether a wheelset rolls as fast as the vehicle in more than a hundredth of the samples.
fn agrees(run: &Recording, wheelset: usize, radius_m: f64) -> bool {
    ratios(run, wheelset, radius_m).is_some_and(|ratios| {
        let rolling = ratios.iter().filter(|ratio| (ROLLS[0]..=ROLLS[1]).contains(*ratio)).count();
        rolling as f64 > ROLLING_SHARE * ratios.len() as f64
    })
}

/// The ratio of a wheelset where all but a hundredth of the samples are beyond what a rolling wheelset can have.
fn off_ratio(run: &Recording, wheelset: usize, radius_m: f64) -> Option<f64> {
    let ratios = ratios(run, wheelset, radius_m)?;
    let at = |share: f64| ratios[((ratios.len() - 1) as f64 * share) as usize];
    let (low, high) = (at(ROLLING_SHARE), at(1.0 - ROLLING_SHARE));
    let middle = at(0.5);
    let near = |ratio: f64, factor: f64| (ratio / factor - 1.0).abs() < STEADY;
    // A wheelset that slides or spins does not keep to one ratio for half of the time and stay below it for the rest; nor does one that
    // never rolls keep to any.
    let keeps_to = |factor: f64| near(at(0.25), factor) && near(at(0.75), factor) && near(high, factor);
    let never_else = near(low, middle) && near(high, middle) && !(ROLLS[0]..=ROLLS[1]).contains(&middle);
    let backwards = at(0.75) < -LOCKED;
    if keeps_to(DIAMETER) || keeps_to(1.0 / DIAMETER) || backwards || (never_else && middle.abs() > LOCKED) {
        return Some(middle);
    }
    match (LOCKED..RATIO[0]).contains(&high) {
        true => Some(high),
        false => (low > RATIO[1]).then(|| at(0.5)),
    }
}

/// Refuses pads that pull, and forces and torques that are far beyond what any vehicle brakes or drives with.
fn possible(run: &Recording, vehicle: &VehicleParameters) -> Result<(), UnitError> {
    let mass_kg = vehicle.body.mass_kg;
    let lever = vehicle.brake.radius_m / vehicle.wheelset.radius_m / mass_kg;
    let rows = ((LASTING_S * run.sample_rate_hz()).ceil() as usize).max(2);
    let refuse = |quantity: Quantity, wheelset: usize, row: usize, why: String| UnitError {
        column: quantity.column(wheelset, run.wheelsets),
        t_s: run.t_s[row],
        why,
    };
    if let Some(column) = &run.grade_rad
        && let Some(row) = lasting(column, rows, |grade| grade.abs() > STEEPEST_RAD)
    {
        let why = format!(
            "{:.3} rad for {LASTING_S} s or longer; no railway is steeper than {STEEPEST_RAD} rad: expected is rad, not ‰, % or °",
            column[row]
        );
        return Err(refuse(Quantity::Grade, 0, row, why));
    }
    for (wheelset, (column, pad)) in run.pressing_force_n.iter().zip(vehicle.pad_friction()).enumerate() {
        if let Some(row) = lasting(column, rows, |force| force < PULL_N) {
            let why = format!(
                "{:.0} N for {LASTING_S} s or longer; pads cannot pull: expected is N, positive",
                column[row]
            );
            return Err(refuse(Quantity::PressingForce, wheelset, row, why));
        }
        if let Some(row) = lasting(column, rows, |force| pad * lever * force > STRONGEST_M_S2) {
            let why = format!(
                "{:.3e} N for {LASTING_S} s or longer would slow the vehicle by {:.0} m/s²; expected is N, not mN, and no kN that \
                 were N before",
                column[row],
                pad * lever * column[row]
            );
            return Err(refuse(Quantity::PressingForce, wheelset, row, why));
        }
    }
    for (wheelset, column) in run.drive_torque_nm.iter().enumerate() {
        let speeding = |torque: f64| torque.abs() / vehicle.wheelset.radius_m / mass_kg;
        if let Some(row) = lasting(column, rows, |torque| speeding(torque) > STRONGEST_M_S2) {
            let why = format!(
                "{:.3e} N m for {LASTING_S} s or longer would change the speed by {:.0} m/s every second; expected is N m",
                column[row],
                speeding(column[row])
            );
            return Err(refuse(Quantity::DriveTorque, wheelset, row, why));
        }
    }
    Ok(())
}

/// Refuses a column of forces that does what another does, a thousand times smaller: one in kN beside one in N.
fn alike(run: &Recording) -> Result<(), UnitError> {
    let Some(reference) = run.pressing_force_n.iter().max_by(|a, b| swing(a).total_cmp(&swing(b))) else {
        return Ok(());
    };
    if swing(reference) < LEAST_SWING_N {
        return Ok(());
    }
    for (wheelset, column) in run.pressing_force_n.iter().enumerate() {
        let pairs: Vec<(f64, f64)> = column
            .iter()
            .zip(reference)
            .filter(|(own, other)| own.is_finite() && other.is_finite())
            .map(|(own, other)| (*own, *other))
            .collect();
        let n = pairs.len().max(1) as f64;
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / n;
        let (own, other) = (mean(&|pair| pair.0), mean(&|pair| pair.1));
        let product = |of: &dyn Fn(f64, f64) -> f64| mean(&|pair| of(pair.0 - own, pair.1 - other));
        let (together, alone) = (product(&|a, b| a * b), product(&|_, b| b * b));
        let correlation = together / (alone * product(&|a, _| a * a)).sqrt();
        let times = alone / together;
        if correlation > THE_SAME && (500.0..2000.0).contains(&times) {
            let row = (0..run.len()).max_by(|a, b| column[*a].total_cmp(&column[*b])).unwrap_or(0);
            return Err(UnitError {
                column: Quantity::PressingForce.column(wheelset, run.wheelsets),
                t_s: run.t_s[row],
                why: format!(
                    "does what another wheelset's column does, {times:.0} times smaller; expected is N, not kN"
                ),
            });
        }
    }
    Ok(())
}

/// Largest minus least finite value.
fn swing(column: &[f64]) -> f64 {
    let finite = || column.iter().copied().filter(|value| value.is_finite());
    finite().fold(f64::NEG_INFINITY, f64::max) - finite().fold(f64::INFINITY, f64::min)
}

/// The first of so many rows in a row of which all are so.
fn lasting(column: &[f64], rows: usize, is: impl Fn(f64) -> bool) -> Option<usize> {
    let mut so_far = 0;
    column.iter().enumerate().find_map(|(row, value)| {
        so_far = if is(*value) { so_far + 1 } else { 0 };
        (so_far >= rows).then(|| row + 1 - rows)
    })
}

/// Forces in kN or bar look like brakes that hardly press while the vehicle slows as they rise.
fn forces(run: &Recording, vehicle: &VehicleParameters) -> Result<(), UnitError> {
    let each = || run.pressing_force_n.iter().zip(vehicle.pad_friction());
    // Slowing by the brakes if the columns are in N, m/s².
    let mass_kg = vehicle.body.mass_kg
        + run.wheelsets as f64 * vehicle.wheelset.inertia_kg_m2 / vehicle.wheelset.radius_m.powi(2);
    let lever = vehicle.brake.radius_m / vehicle.wheelset.radius_m / mass_kg;
    let braking: Vec<f64> =
        (0..run.len()).map(|k| each().map(|(column, pad)| pad * lever * column[k]).sum()).collect();
    if braking.iter().any(|slowing| *slowing > IDLE_M_S2) {
        return Ok(());
    }
    let span = ((SPAN_S * run.sample_rate_hz()).round() as usize).max(1);
    let ends = (0..run.len().saturating_sub(span)).step_by(span.div_ceil(10));
    let averages: Vec<(f64, f64)> = ends
        .filter_map(|k| {
            let mean = |value: &dyn Fn(usize) -> f64| (k..k + span).map(value).sum::<f64>() / span as f64;
            let grade = run.grade_rad.as_ref().map_or(0.0, |column| mean(&|k| column[k]));
            let drive = mean(&|k| run.drive_torque_nm.iter().map(|column| column[k]).sum());
            let duration_s = run.t_s[k + span] - run.t_s[k];
            let slowing = (run.v_m_s[k] - run.v_m_s[k + span]) / duration_s - GRAVITY_M_S2 * grade
                + drive / vehicle.wheelset.radius_m / mass_kg;
            slowing.is_finite().then(|| (mean(&|k| braking[k]), slowing))
        })
        .collect();
    let mut steps: Vec<f64> = braking.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    steps.sort_by(f64::total_cmp);
    let scatter = steps.get(steps.len() / 2).copied().unwrap_or(0.0);
    // What stands or rolls for long hides a stop in the middle of it.
    let pieces = averages.chunks(PIECE).chain([&averages[..]]);
    let Some(times) = pieces.filter_map(|piece| slowed_by(piece, scatter)).next() else { return Ok(()) };
    let most = run.pressing_force_n.iter().flatten().fold(0.0_f64, |most, force| most.max(*force));
    let row = (0..run.len()).max_by(|a, b| braking[*a].total_cmp(&braking[*b])).unwrap_or(0);
    Err(UnitError {
        column: Quantity::PressingForce.column(0, run.wheelsets),
        t_s: run.t_s[row],
        why: format!(
            "at most {most:.0} N in any column while the vehicle slows {times:.0} times as hard as that can brake it; expected \
             is N, not kN or bar"
        ),
    })
}

/// How much harder a vehicle slows than its `(braking, slowing)` by forces taken as N; `None` where the forces are not what
/// slows it.
fn slowed_by(averages: &[(f64, f64)], scatter: f64) -> Option<f64> {
    if averages.len() < LEAST_SPANS {
        return None;
    }
    let n = averages.len() as f64;
    let range = |of: &dyn Fn(&(f64, f64)) -> f64| {
        let fold = |[low, high]: [f64; 2], x: f64| [low.min(x), high.max(x)];
        let [low, high] = averages.iter().map(of).fold([f64::INFINITY, f64::NEG_INFINITY], fold);
        high - low
    };
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| averages.iter().map(of).sum::<f64>() / n;
    let (braking, slowing) = (mean(&|a| a.0), mean(&|a| a.1));
    let product = |of: &dyn Fn(f64, f64) -> f64| mean(&|a| of(a.0 - braking, a.1 - slowing));
    let (together, alone) = (product(&|b, s| b * s), product(&|b, _| b * b));
    let correlation = together / (alone * product(&|_, s| s * s)).sqrt();
    let varies = range(&|a| a.0) > SCATTERS * scatter && range(&|a| a.1) > BRAKED_M_S2;
    if varies && correlation > CORRELATION {
        return Some(together / alone);
    }
    // A brake that presses alike throughout: only if the slowing is what the forces make when taken as kN.
    let times = slowing / braking;
    (braking > SCATTERS * scatter && slowing > BRAKED_M_S2 && (500.0..2000.0).contains(&times))
        .then_some(times)
}
