//! Sensor sigma and noise: as declared, from replicates, or from the scatter about the richest smooth model.

use super::chance::{Noise, scatter};
use super::fit::fit_once;
use super::flexible::{Tangent, groups};
use super::input::BenchCase;
use super::model::Model;
use super::points::Point;
use super::search::Trial;
use std::collections::BTreeMap;

/// Degrees of freedom that replicates must offer.
const FEWEST_REPLICATES: usize = 8;

/// Cells into which each variable's range is cut to find replicates.
const CELLS: f64 = 1e4;

/// Noise of the bench around `around`, or around the calibrated model, and where its sigma comes from.
pub fn estimate(case: &BenchCase, around: Option<&Trial>) -> (Noise, &'static str) {
    let points = &case.fit.points;
    let replicates = from_replicates(points);
    let provisional = case.sigma.or(replicates).unwrap_or(1.0);
    let plain = Model::new(case.nominal, &[]);
    let values = fit_once(&plain, points, provisional, &plain.nominal_values()).values;
    let (model, values) = around.map_or((&plain, &values), |trial| (&trial.model, &trial.fit.values));
    let tangent = Tangent::of(model, points, values, provisional);
    let smooth = groups(case.kind, points, &tangent);
    let (scatter, correlation) = scatter(model, points, values, provisional, &smooth, &tangent);
    let (sigma, source) = match (case.sigma, replicates) {
        (Some(sigma), _) => (sigma, "declared in bench.toml"),
        (None, Some(sigma)) => (sigma, "estimated from replicates: points at the same operating point"),
        (None, None) => (
            scatter,
            "estimated from the scatter about a smooth model of all variables, because there are no replicates",
        ),
    };
    let sigma = sigma.max(1e-12);
    (Noise { sigma, excess: (scatter / sigma).max(1.0), correlation }, source)
}

/// Pooled standard deviation of points whose variables agree.
fn from_replicates(points: &[Point]) -> Option<f64> {
    let of: [fn(&Point) -> f64; 5] =
        [|p| p.creepage, |p| p.load_n, |p| p.speed_m_s, |p| p.temperature_c, |p| p.pressing_force_n];
    let size = of.map(|f| points.iter().map(|p| f(p).abs()).fold(0.0, f64::max).max(1e-12));
    let mut cells: BTreeMap<[i64; 5], Vec<f64>> = BTreeMap::new();
    for point in points {
        let mut cell = [0; 5];
        for (slot, (f, size)) in cell.iter_mut().zip(of.iter().zip(size)) {
            *slot = (f(point) / size * CELLS).round() as i64;
        }
        cells.entry(cell).or_default().push(point.measured);
    }
    let (mut sum, mut freedom) = (0.0, 0);
    for values in cells.values().filter(|values| values.len() > 1) {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        sum += values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
        freedom += values.len() - 1;
    }
    (freedom >= FEWEST_REPLICATES && sum > 0.0).then(|| (sum / freedom as f64).sqrt())
}
