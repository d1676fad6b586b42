//! Where the gap of a model lies: over speed, slip, disc temperature, brake force, time since brake onset, position.

use crate::case::{Case, OUTPUTS, Run};
use crate::flexible::{Covariate, along};
use crate::html::detail::{HeatGroup, HeatMap};
use crate::metric::{self, sigmas};
use crate::parameters::Built;
use crate::report::Regime;

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
/// Ambient that temperatures in the report are counted from, °C.
const AMBIENT_C: f64 = 20.0;

/// Squared errors of each sample of the windows, by output.
struct Errors {
    squares: Vec<[f64; OUTPUTS]>,
    from: Vec<(usize, usize)>,
}

fn errors(case: &Case, built: &Built) -> Errors {
    let sigma = sigmas(&case.vehicle.sensors);
    let (mut squares, mut from) = (Vec::new(), Vec::new());
    for (r, run) in case.fit.iter().enumerate() {
        for window in metric::predict(built, run) {
            for (k, predicted) in window.range.clone().zip(&window.outputs) {
                let square =
                    |j: usize| ((predicted[j] - run.samples[k].outputs[j]) / sigma[j]).powi(2).min(1e12);
                squares.push(std::array::from_fn(square));
                from.push((r, k));
            }
        }
    }
    Errors { squares, from }
}

/// Gap of both models by region, and the region in which the first one's stands out.
pub fn locate(case: &Case, calibrated: &Built, extended: &Built) -> (HeatMap, Option<Regime>) {
    let (before, after) = (errors(case, calibrated), errors(case, extended));
    let mut groups = Vec::new();
    let mut best: Option<(f64, Regime)> = None;
    for variable in VARIABLES {
        let columns: Vec<Vec<f64>> = case.fit.iter().map(|run: &Run| along(case, run, variable)).collect();
        let shift = if variable == Covariate::Temperature { AMBIENT_C } else { 0.0 };
        let values: Vec<f64> = before.from.iter().map(|&(r, k)| columns[r][k] + shift).collect();
        let Some(edges) = edges(&values) else { continue };
        let region = |x: f64| edges[1..edges.len() - 1].iter().filter(|edge| x >= **edge).count();
        let group = group(variable, &edges, &values, &region, &before, &after);
        if let Some((score, regime)) = stand_out(variable, &edges, &group)
            && best.as_ref().is_none_or(|(s, _)| score > *s)
        {
            best = Some((score, regime));
        }
        groups.push(group);
    }
    let signals = crate::case::OUTPUT_NAMES.map(str::to_owned).to_vec();
    (HeatMap { signals, groups }, best.map(|(_, regime)| regime))
}

fn edges(values: &[f64]) -> Option<Vec<f64>> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| sorted.get(((sorted.len().max(1) - 1) as f64 * share) as usize).copied();
    let mut edges: Vec<f64> = (0..=REGIONS).filter_map(|k| at(k as f64 / REGIONS as f64)).collect();
    let span = edges.last()? - edges.first()?;
    edges.dedup_by(|a, b| (*a - *b).abs() <= 1e-3 * span);
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
    let count = edges.len() - 1;
    let mut samples = vec![0; count];
    let mut sums = [vec![vec![0.0; count]; OUTPUTS], vec![vec![0.0; count]; OUTPUTS]];
    for (n, value) in values.iter().enumerate() {
        let at = region(*value);
        samples[at] += 1;
        for j in 0..OUTPUTS {
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
fn stand_out(variable: Covariate, edges: &[f64], group: &HeatGroup) -> Option<(f64, Regime)> {
    let count = group.samples.len();
    let square = |k: usize| {
        group.calibrated.iter().map(|row| row[k] * row[k]).sum::<f64>() / OUTPUTS as f64
            * group.samples[k] as f64
    };
    let (total, n): (f64, usize) = ((0..count).map(square).sum(), group.samples.iter().sum());
    let mut best: Option<(f64, Regime)> = None;
    for from in 0..count {
        for to in from..count {
            let inside: usize = group.samples[from..=to].iter().sum();
            if inside * 10 < n || inside * 10 > 7 * n {
                continue;
            }
            let sum: f64 = (from..=to).map(square).sum();
            let (gap_inside, gap_outside) =
                ((sum / inside as f64).sqrt(), ((total - sum).max(0.0) / (n - inside) as f64).sqrt());
            let share = inside as f64 / n as f64;
            let score = (gap_inside - gap_outside) * (share * (1.0 - share)).sqrt();
            if best.as_ref().is_none_or(|(s, _)| score > *s) {
                let range = [edges[from], edges[to + 1]];
                let variable = variable.name().to_owned();
                best = Some((score, Regime { variable, range, gap_inside, gap_outside }));
            }
        }
    }
    best.filter(|(score, _)| score.is_finite() && *score > 0.0)
}
