//! Bounded nonlinear least squares (Levenberg–Marquardt) from several starts, and what it says about parameters.
//!
//! Source: Nocedal & Wright, Numerical Optimization, ch. 10; bounds by holding variables that press against them.

use crate::law_bench::data::point::Point;
use crate::law_bench::model::law::Model;
use nalgebra::{DMatrix, DVector};

/// Steps to the end.
const MOST_STEPS: usize = 80;

/// Steps that show which starts are worth finishing, and how many of them are.
const FIRST_STEPS: usize = 8;
const FINISHERS: usize = 2;

/// A fitted model.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Parameter values.
    pub values: Vec<f64>,
    /// Sum of squared residuals over sigma², without penalties.
    pub chi2: f64,
    /// The same with penalties: what the optimiser minimised.
    pub cost: f64,
    /// Whether the optimiser settled.
    pub converged: bool,
    /// Covariance of the inner variables (logarithms where [`crate::law_bench::model::law::Parameter::log`]), for sigma = 1.
    pub covariance: DMatrix<f64>,
}

/// Fits `model` to `points`: a few steps from each start, then the two best to the end.
pub fn fit_from(model: &Model, points: &[Point], sigma: f64, starts: &[Vec<f64>]) -> Option<Fit> {
    let descent = Descent { model, points, sigma };
    let mut tried: Vec<Fit> = starts.iter().map(|start| descent.run(start, FIRST_STEPS)).collect();
    tried.retain(|fit| fit.cost.is_finite());
    tried.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let ends = tried.iter().take(FINISHERS).map(|fit| descent.run(&fit.values, MOST_STEPS));
    ends.min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// Fits `model` to `points` from one start.
pub fn fit_once(model: &Model, points: &[Point], sigma: f64, start: &[f64]) -> Fit {
    Descent { model, points, sigma }.run(start, MOST_STEPS)
}

/// Names of parameters of forms that ended on a bound.
pub fn on_bound(model: &Model, values: &[f64]) -> Vec<&'static str> {
    let pressed = |lower: f64, upper: f64, value: f64| {
        let margin = 1e-4 * (upper - lower);
        value <= lower + margin.min(1e-3 * lower.abs().max(1e-12)) || value >= upper - margin
    };
    let pairs = model.parameters().iter().zip(values);
    pairs
        .filter(|(parameter, value)| {
            parameter.form.is_some() && pressed(parameter.lower, parameter.upper, **value)
        })
        .map(|(parameter, _)| parameter.name)
        .collect()
}

/// Inner variable of a value.
pub fn inner(log: bool, value: f64) -> f64 {
    if log { value.ln() } else { value }
}

/// Value of an inner variable.
pub fn outer(log: bool, z: f64) -> f64 {
    if log { z.exp() } else { z }
}

struct Descent<'a> {
    model: &'a Model,
    points: &'a [Point],
    sigma: f64,
}

impl Descent<'_> {
    fn run(&self, start: &[f64], steps: usize) -> Fit {
        let parameters = self.model.parameters();
        let bounds: Vec<(f64, f64)> =
            parameters.iter().map(|p| (inner(p.log, p.lower), inner(p.log, p.upper))).collect();
        let mut z: Vec<f64> = parameters
            .iter()
            .zip(start)
            .zip(&bounds)
            .map(|((p, &value), &(low, high))| inner(p.log, value.clamp(p.lower, p.upper)).clamp(low, high))
            .collect();
        let mut residuals = self.residuals(&z);
        let mut cost = square(&residuals);
        let mut damping = 1e-3;
        let mut converged = false;
        let mut calm = 0;
        for _ in 0..steps {
            let jacobian = self.jacobian(&z, &residuals, &bounds);
            let Some((next, next_residuals, next_cost)) =
                self.step(&z, &residuals, cost, &jacobian, &bounds, &mut damping)
            else {
                converged = true;
                break;
            };
            calm = if cost - next_cost < 1e-7 * cost.max(1.0) { calm + 1 } else { 0 };
            (z, residuals, cost) = (next, next_residuals, next_cost);
            if calm >= 2 {
                converged = true;
                break;
            }
        }
        self.finish(&z, &residuals, cost, converged, &bounds)
    }

    /// A step that lowers the cost, or `None` where there is none.
    #[allow(clippy::type_complexity)]
    fn step(
        &self,
        z: &[f64],
        residuals: &DVector<f64>,
        cost: f64,
        jacobian: &DMatrix<f64>,
        bounds: &[(f64, f64)],
        damping: &mut f64,
    ) -> Option<(Vec<f64>, DVector<f64>, f64)> {
        let normal = jacobian.tr_mul(jacobian);
        let gradient = jacobian.tr_mul(residuals);
        let held: Vec<bool> = (0..z.len())
            .map(|i| (z[i] <= bounds[i].0 && gradient[i] > 0.0) || (z[i] >= bounds[i].1 && gradient[i] < 0.0))
            .collect();
        for _ in 0..14 {
            let mut system = normal.clone();
            let mut right = -&gradient;
            for i in 0..z.len() {
                system[(i, i)] += *damping * normal[(i, i)].max(1e-12);
                if held[i] {
                    system.row_mut(i).fill(0.0);
                    system.column_mut(i).fill(0.0);
                    (system[(i, i)], right[i]) = (1.0, 0.0);
                }
            }
            let delta = system.cholesky().map(|factor| factor.solve(&right));
            if let Some(delta) = delta {
                let next: Vec<f64> =
                    (0..z.len()).map(|i| (z[i] + delta[i]).clamp(bounds[i].0, bounds[i].1)).collect();
                let next_residuals = self.residuals(&next);
                let next_cost = square(&next_residuals);
                if next_cost < cost {
                    *damping = (*damping * 0.2).max(1e-9);
                    return Some((next, next_residuals, next_cost));
                }
            }
            *damping *= 5.0;
            if *damping > 1e8 {
                break;
            }
        }
        *damping = 1e-3;
        None
    }

    fn residuals(&self, z: &[f64]) -> DVector<f64> {
        let values = self.values(z);
        let mut all: Vec<f64> = self
            .points
            .iter()
            .map(|point| (self.model.predict(point, &values) - point.measured) / self.sigma)
            .collect();
        self.model.penalties(&values, &mut all);
        DVector::from_vec(all)
    }

    fn jacobian(&self, z: &[f64], residuals: &DVector<f64>, bounds: &[(f64, f64)]) -> DMatrix<f64> {
        let mut jacobian = DMatrix::zeros(residuals.len(), z.len());
        let mut moved = z.to_vec();
        for i in 0..z.len() {
            let range = bounds[i].1 - bounds[i].0;
            let mut h = 1e-6 * range.min(z[i].abs().max(1e-3 * range)).max(1e-9 * range);
            if z[i] + h > bounds[i].1 {
                h = -h;
            }
            moved[i] = z[i] + h;
            let column = (self.residuals(&moved) - residuals) / h;
            jacobian.set_column(i, &column);
            moved[i] = z[i];
        }
        jacobian
    }

    fn values(&self, z: &[f64]) -> Vec<f64> {
        self.model.parameters().iter().zip(z).map(|(p, &z)| outer(p.log, z)).collect()
    }

    fn finish(
        &self,
        z: &[f64],
        residuals: &DVector<f64>,
        cost: f64,
        converged: bool,
        bounds: &[(f64, f64)],
    ) -> Fit {
        let jacobian = self.jacobian(z, residuals, bounds);
        let chi2 = residuals.rows(0, self.points.len()).norm_squared();
        let covariance = covariance(&jacobian);
        Fit { values: self.values(z), chi2, cost, converged, covariance }
    }
}

fn square(residuals: &DVector<f64>) -> f64 {
    let sum = residuals.norm_squared();
    if sum.is_finite() { sum } else { f64::INFINITY }
}

/// Inverse of JᵀJ, with directions that the data do not see cut off.
fn covariance(jacobian: &DMatrix<f64>) -> DMatrix<f64> {
    let normal = jacobian.tr_mul(jacobian);
    let n = normal.nrows();
    let scale: Vec<f64> = (0..n).map(|i| normal[(i, i)].sqrt().max(1e-12)).collect();
    let scaled = DMatrix::from_fn(n, n, |i, j| normal[(i, j)] / (scale[i] * scale[j]));
    let eigen = scaled.symmetric_eigen();
    let mut inverse = DMatrix::zeros(n, n);
    for k in 0..n {
        let vector = eigen.eigenvectors.column(k);
        inverse += vector * vector.transpose() / eigen.eigenvalues[k].max(1e-9);
    }
    DMatrix::from_fn(n, n, |i, j| inverse[(i, j)] / (scale[i] * scale[j]))
}
