//! Where the gap of a model lies: over speed, slip, disc temperature, brake force, time since brake onset,
//! position, wheel angle and frequency.

use crate::answer::schema::Regime;
use crate::answer::supplement::{HeatGroup, HeatMap};
use crate::data::case::{Case, OUTPUTS, Run};
use crate::model::discrepancy::{Covariate, along};
use crate::model::parameters::Built;
use crate::predict::open_loop::{self, sigmas};
use crate::words::findings::AMBIENT_C;
use railgrip_vehicle::effects::Term;

/// Variables over which the gap is cut.
const VARIABLES: [Covariate; 6] = [
    Covariate::Speed,
    Covariate::BrakeForce,
    Covariate::Temperature,
    Covariate::TimeInBraking,
    Covariate::SlipPower,
    Covariate::Position,
];
/// Regions of each variable.
const REGIONS: usize = 5;
/// Least width of a region, as a share of what the variable spans: a plateau of full braking is one place, not a range.
const LEAST_WIDTH: f64 = 0.05;
/// Factor by which the gap inside must exceed that outside for the variable of the answer itself to be told: brake force,
/// time since onset and temperature rise together in every stop, so that another one may stand out a little more.
const STANDS_OUT: f64 = 1.2;
/// How much more a place on the track must stand out than what the vehicle does there: runs pass each place once.
const PLACE_FACTOR: f64 = 2.0;

/// Squared errors of each sample of the windows, by output.
struct Errors {
    outputs: usize,
    squares: Vec<[f64; OUTPUTS]>,
    from: Vec<(usize, usize)>,
}

fn errors(case: &Case, built: &Built) -> Errors {
    let sigma = sigmas(&case.vehicle.sensors);
    let (mut squares, mut from) = (Vec::new(), Vec::new());
    for (r, run) in case.fit.iter().enumerate() {
        for window in open_loop::predict(built, run) {
            for (k, predicted) in window.range.clone().zip(&window.outputs) {
                let innovation = run.samples[k].innovation(predicted);
                let square = |j: usize| (innovation[j] / sigma[j]).powi(2).min(1e12);
                squares.push(std::array::from_fn(square));
                from.push((r, k));
            }
        }
    }
    Errors { outputs: case.outputs(), squares, from }
}

/// The variable over which an effect of the catalogue acts, where it is one of those that the gap is cut by.
pub fn variable_of(id: &str) -> Option<Covariate> {
    match id {
        "brake_fade" => Some(Covariate::Temperature),
        "brake_friction_pressure" | "pressing_force_offset" | "rigging_hysteresis" => {
            Some(Covariate::BrakeForce)
        }
        "brake_lag" => Some(Covariate::TimeInBraking),
        "falling_friction" | "self_cleaning" => Some(Covariate::SlipPower),
        "low_adhesion_patch" | "grade" => Some(Covariate::Position),
        "brake_friction_speed"
        | "adhesion_speed"
        | "speed_scale"
        | "speed_latency"
        | "wheel_radius"
        | "running_resistance"
        | "headwind" => Some(Covariate::Speed),
        _ => None,
    }
}

/// Whether a variable can say something about an answer in this term: that the gap is larger with a warm disc says nothing
/// of a sensor.
fn tells(variable: Covariate, term: Term) -> bool {
    match variable {
        Covariate::Temperature => term == Term::BrakeFriction,
        Covariate::SlipPower => matches!(term, Term::Adhesion | Term::LoadDistribution),
        Covariate::Position => matches!(term, Term::Adhesion | Term::Resistance),
        Covariate::BrakeForce | Covariate::TimeInBraking => !matches!(
            term,
            Term::Adhesion | Term::Resistance | Term::Kinematics | Term::SensorSpeed | Term::SensorWheelSpeed
        ),
        _ => true,
    }
}

/// What was found or is missing, as far as it guides where to look: its term and the variable over which it acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answer {
    /// The term of the equations.
    pub term: Term,
    /// The variable, where it is one of those that the gap is cut by.
    pub variable: Option<Covariate>,
}

/// Gap of both models by region, and the region in which the first one's stands out; it must hold a share of the samples
/// between the two of `region_share`.
pub fn locate(
    case: &Case,
    calibrated: &Built,
    extended: &Built,
    region_share: [f64; 2],
    answer: Option<Answer>,
) -> (HeatMap, Option<Regime>) {
    let (before, after) = (errors(case, calibrated), errors(case, extended));
    let mut groups = Vec::new();
    let mut best: Option<(f64, Regime)> = None;
    let mut of_its_own: Option<Regime> = None;
    for variable in VARIABLES {
        let columns: Vec<Vec<f64>> = case.fit.iter().map(|run: &Run| along(case, run, variable)).collect();
        let shift = if variable == Covariate::Temperature { AMBIENT_C } else { 0.0 };
        let values: Vec<f64> = before.from.iter().map(|&(r, k)| columns[r][k] + shift).collect();
        let Some(edges) = edges(&values) else { continue };
        let region = |x: f64| edges[1..edges.len() - 1].iter().filter(|edge| x >= **edge).count();
        let group = group(variable, &edges, &values, &region, &before, &after);
        if let Some((score, regime)) = stand_out(variable, &edges, &group, region_share) {
            if answer.and_then(|answer| answer.variable) == Some(variable)
                && regime.gap_inside > STANDS_OUT * regime.gap_outside
            {
                of_its_own = Some(regime.clone());
            }
            let score = if variable == Covariate::Position { score / PLACE_FACTOR } else { score };
            let tells = answer.is_none_or(|answer| tells(variable, answer.term));
            if tells && best.as_ref().is_none_or(|(s, _)| score > *s) {
                best = Some((score, regime));
            }
        }
        groups.push(group);
    }
    groups.extend(by_wheel_angle(case, &before, &after));
    groups.push(by_frequency(case, calibrated, extended));
    let signals = case.output_names().iter().map(|name| (*name).to_owned()).collect();
    (HeatMap { signals, groups }, of_its_own.or(best.map(|(_, regime)| regime)))
}

fn edges(values: &[f64]) -> Option<Vec<f64>> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| sorted.get(((sorted.len().max(1) - 1) as f64 * share) as usize).copied();
    let mut edges: Vec<f64> = (0..=REGIONS).filter_map(|k| at(k as f64 / REGIONS as f64)).collect();
    let span = edges.last()? - edges.first()?;
    let last = *edges.last()?;
    edges.dedup_by(|a, b| (*a - *b).abs() <= LEAST_WIDTH * span);
    // The last region ends where the recordings do, even if it takes up the one before it.
    if let Some(end) = edges.last_mut() {
        *end = last;
    }
    (edges.len() >= 3).then_some(edges)
}

fn group(
    variable: Covariate,
    edges: &[f64],
    values: &[f64],
    region: &dyn Fn(f64) -> usize,
    before: &Errors,
    after: &Errors,
) -> HeatGroup {
    let (count, outputs) = (edges.len() - 1, before.outputs);
    let mut samples = vec![0; count];
    let mut sums = [vec![vec![0.0; count]; outputs], vec![vec![0.0; count]; outputs]];
    for (n, value) in values.iter().enumerate() {
        let at = region(*value);
        samples[at] += 1;
        for j in 0..outputs {
            sums[0][j][at] += before.squares[n][j];
            sums[1][j][at] += after.squares[n][j];
        }
    }
    let rms = |sums: &Vec<Vec<f64>>| -> Vec<Vec<f64>> {
        let cell = |(sum, n): (&f64, &usize)| if *n > 0 { (sum / *n as f64).sqrt() } else { f64::NAN };
        sums.iter().map(|row| row.iter().zip(&samples).map(cell).collect()).collect()
    };
    HeatGroup {
        variable: variable.name().into(),
        unit: variable.unit().into(),
        edges: edges.to_vec(),
        calibrated: rms(&sums[0]),
        extended: rms(&sums[1]),
        samples,
    }
}

/// The contiguous regions whose gap stands out most from the rest.
fn stand_out(
    variable: Covariate,
    edges: &[f64],
    group: &HeatGroup,
    [least, most]: [f64; 2],
) -> Option<(f64, Regime)> {
    let count = group.samples.len();
    let square = |k: usize| {
        group.calibrated.iter().map(|row| row[k] * row[k]).sum::<f64>() / group.calibrated.len() as f64
            * group.samples[k] as f64
    };
    let (total, n): (f64, usize) = ((0..count).map(square).sum(), group.samples.iter().sum());
    let mut best: Option<(f64, Regime)> = None;
    for from in 0..count {
        for to in from..count {
            let inside: usize = group.samples[from..=to].iter().sum();
            let held = inside as f64 / n as f64;
            if held < least || held > most {
                continue;
            }
            let sum: f64 = (from..=to).map(square).sum();
            let (gap_inside, gap_outside) =
                ((sum / inside as f64).sqrt(), ((total - sum).max(0.0) / (n - inside) as f64).sqrt());
            let score = (gap_inside - gap_outside) * (held * (1.0 - held)).sqrt();
            if best.as_ref().is_none_or(|(s, _)| score > *s) {
                let range = [edges[from], edges[to + 1]];
                let variable = variable.name().to_owned();
                best = Some((score, Regime { variable, range, gap_inside, gap_outside }));
            }
        }
    }
    best.filter(|(score, _)| score.is_finite() && *score > 0.0)
}

/// The gap by angle of the front wheel within a revolution, where there is more than a revolution.
fn by_wheel_angle(case: &Case, before: &Errors, after: &Errors) -> Option<HeatGroup> {
    let turn = std::f64::consts::TAU;
    let angle = |&(r, k): &(usize, usize)| case.fit[r].samples[k].input.wheel_angle_rad[0];
    let most = before.from.iter().map(angle).fold(0.0, f64::max);
    let values: Vec<f64> = before.from.iter().map(|at| angle(at).rem_euclid(turn)).collect();
    let edges: Vec<f64> = (0..=REGIONS).map(|k| turn * k as f64 / REGIONS as f64).collect();
    let region = |x: f64| ((x / turn * REGIONS as f64) as usize).min(REGIONS - 1);
    (most > turn).then(|| group(Covariate::WheelAngle, &edges, &values, &region, before, after))
}

/// Limits of the bands into which errors are split, Hz.
const BANDS_HZ: [f64; 5] = [0.0, 0.2, 1.0, 5.0, 50.0];

/// The gap by frequency: errors within each window, split by differences of running means. The bands' squares do not add up
/// exactly to the squared gap, as running means overlap a little.
fn by_frequency(case: &Case, calibrated: &Built, extended: &Built) -> HeatGroup {
    let bands = BANDS_HZ.len() - 1;
    let mut samples = 0;
    let empty = || vec![vec![0.0; bands]; case.outputs()];
    let mut sums = [empty(), empty()];
    let sigma = sigmas(&case.vehicle.sensors);
    for run in &case.fit {
        for (sums, built) in sums.iter_mut().zip([calibrated, extended]) {
            for window in open_loop::predict(built, run) {
                for (j, sums) in sums.iter_mut().enumerate() {
                    let error = |(k, predicted): (usize, &[f64; OUTPUTS])| {
                        (-run.samples[k].innovation(predicted)[j] / sigma[j]).clamp(-1e6, 1e6)
                    };
                    let mut rest: Vec<f64> = window.range.clone().zip(&window.outputs).map(error).collect();
                    for band in (0..bands).rev() {
                        let slow = match band {
                            0 => vec![0.0; rest.len()],
                            // A running mean over 0.44 / f passes half of the power at f.
                            _ => running_mean(&rest, 0.44 / BANDS_HZ[band] / run.dt_s),
                        };
                        sums[band] += rest.iter().zip(&slow).map(|(x, s)| (x - s).powi(2)).sum::<f64>();
                        rest = slow;
                    }
                }
            }
        }
        samples += open_loop::windows(run).iter().map(|range| range.len()).sum::<usize>();
    }
    let rms = |sums: &Vec<Vec<f64>>| -> Vec<Vec<f64>> {
        let cell = |sum: &f64| if samples > 0 { (sum / samples as f64).sqrt() } else { f64::NAN };
        sums.iter().map(|row| row.iter().map(cell).collect()).collect()
    };
    HeatGroup {
        variable: "frequency".into(),
        unit: "Hz".into(),
        edges: BANDS_HZ.to_vec(),
        calibrated: rms(&sums[0]),
        extended: rms(&sums[1]),
        samples: vec![samples; bands],
    }
}

/// Mean over about `width` samples around each, over fewer at the ends.
fn running_mean(values: &[f64], width: f64) -> Vec<f64> {
    let half = (0.5 * width).round().max(1.0) as usize;
    let mut sums = vec![0.0; values.len() + 1];
    for (k, value) in values.iter().enumerate() {
        sums[k + 1] = sums[k] + value;
    }
    let mean = |k: usize| {
        let (from, to) = (k.saturating_sub(half), (k + half + 1).min(values.len()));
        (sums[to] - sums[from]) / (to - from) as f64
    };
    (0..values.len()).map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn running_means_split_slow_from_fast() {
        let wave = |period: f64| (0..1000).map(move |k| (std::f64::consts::TAU * k as f64 / period).sin());
        let power = |values: &[f64]| values.iter().map(|x| x * x).sum::<f64>() / values.len() as f64;
        let (slow, fast): (Vec<f64>, Vec<f64>) = (wave(500.0).collect(), wave(10.0).collect());
        let (kept, passed) = (power(&running_mean(&slow, 44.0)), power(&running_mean(&fast, 44.0)));
        println!("power left: {kept:.3} of a slow wave, {passed:.4} of a fast one, of 0.5 each");
        assert!(kept > 0.45 && passed < 0.01);
    }
}
