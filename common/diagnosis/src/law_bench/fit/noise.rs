//! Sensor sigma and noise: as declared, from repeated points, or from the scatter about the richest smooth model.

use super::fitted::FittedModel;
use super::solver::fit_once;
use crate::law_bench::data::case::LawCase;
use crate::law_bench::data::point::{Covariate, Point};
use crate::law_bench::decide::criteria::Criteria;
use crate::law_bench::model::discrepancy::{Discrepancy, Tangent, discrepancies, residuals, union};
use crate::law_bench::model::law::Model;
use nalgebra::DVector;
use std::collections::BTreeMap;

/// Noise of the measured column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// Sensor sigma by which gaps are divided, in the column's unit.
    pub sigma: f64,
    /// Scatter about the richest smooth model over sigma; at least 1.
    pub excess: f64,
    /// Correlation of neighbouring points of a file.
    pub correlation: f64,
}

impl Noise {
    /// Squared residuals in units of sigma that count as one independent degree of freedom.
    pub fn unit(&self) -> f64 {
        self.excess * self.excess * (1.0 + self.correlation) / (1.0 - self.correlation)
    }
}

/// Noise of the bench around `around`, or around the calibrated model, and where its sigma comes from.
pub fn estimate(case: &LawCase, around: Option<&FittedModel>, criteria: &Criteria) -> (Noise, &'static str) {
    let points = &case.fit.points;
    let replicates = from_replicates(points, criteria);
    let provisional = case.sigma.or(replicates).unwrap_or(1.0);
    let plain = Model::new(case.nominal, &[]);
    let values = fit_once(&plain, points, provisional, &plain.nominal_values()).values;
    let (model, values) = around.map_or((&plain, &values), |fitted| (&fitted.model, &fitted.fit.values));
    let tangent = Tangent::of(model, points, values, provisional);
    let smooth = discrepancies(case.kind, points, &tangent);
    let left = residuals(model, points, values, provisional);
    let (scatter, correlation) = scatter(points, left, &smooth, &tangent, criteria);
    let scatter = provisional * scatter;
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

/// Scatter of `residuals` about the richest smooth model, in their own unit, and correlation of neighbours.
fn scatter(
    points: &[Point],
    residuals: DVector<f64>,
    smooth: &[Discrepancy],
    tangent: &Tangent,
    criteria: &Criteria,
) -> (f64, f64) {
    let rich = union(smooth, tangent, |one| one.covariate == Covariate::Sequence);
    let rest = &residuals - &tangent.basis * tangent.basis.tr_mul(&residuals);
    let rest = &rest - &rich * rich.tr_mul(&rest);
    let used = rich.ncols() + tangent.basis.ncols();
    let freedom = points.len().saturating_sub(used).max(3) as f64;
    let (mut product, mut pairs) = (0.0, 0usize);
    for i in 1..points.len() {
        if points[i].file == points[i - 1].file {
            product += rest[i] * rest[i - 1];
            pairs += 1;
        }
    }
    let variance = rest.norm_squared() / points.len() as f64;
    let raw = product / (pairs.max(1) as f64 * variance.max(1e-300));
    // A smooth fit makes neighbours look opposed by about its degrees of freedom over the points.
    let correlation = raw + used as f64 / points.len() as f64;
    let chance = criteria.correlation_standard_errors / (pairs.max(1) as f64).sqrt();
    let correlation = if correlation > chance { correlation.min(criteria.most_correlation) } else { 0.0 };
    ((rest.norm_squared() / freedom).sqrt(), correlation)
}

/// Pooled standard deviation of points whose variables agree.
fn from_replicates(points: &[Point], criteria: &Criteria) -> Option<f64> {
    let of: [fn(&Point) -> f64; 5] =
        [|p| p.creepage, |p| p.load_n, |p| p.speed_m_s, |p| p.temperature_c, |p| p.pressing_force_n];
    let cells = 1.0 / criteria.replicate_tolerance;
    let size = of.map(|f| points.iter().map(|p| f(p).abs()).fold(0.0, f64::max).max(1e-12));
    let mut repeated: BTreeMap<[i64; 5], Vec<f64>> = BTreeMap::new();
    for point in points {
        let mut cell = [0; 5];
        for (slot, (f, size)) in cell.iter_mut().zip(of.iter().zip(size)) {
            *slot = (f(point) / size * cells).round() as i64;
        }
        repeated.entry(cell).or_default().push(point.measured);
    }
    let (mut sum, mut freedom) = (0.0, 0);
    for values in repeated.values().filter(|values| values.len() > 1) {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        sum += values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
        freedom += values.len() - 1;
    }
    (freedom >= criteria.fewest_replicates && sum > 0.0).then(|| (sum / freedom as f64).sqrt())
}
