//! Frozen fits: a model fitted with the one-step filter frozen at itself, at the tolerance that makes it most likely.

use crate::data::case::Case;
use crate::fit::candidate::{FULL, Fitted, OPEN_LOOP, SHORT, close};
use crate::fit::objective::{Innovations, Whitening};
use crate::fit::solver::{self, Effort, Fit, Problem};
use crate::fit::windows;
use crate::model::candidates::Candidate;
use crate::model::parameters::{FittedEffect, Shape};
use crate::predict::disturbances::{DisturbanceModel, OUTLIER_SIGMA};
use rayon::prelude::*;

/// A filter frozen at one tolerance, and the model fitted with it.
#[derive(Debug)]
pub struct FrozenFit<'a> {
    /// The case with the recordings that were fitted.
    pub case: &'a Case,
    /// Index of the tolerance in [`TOLERANCES`](crate::predict::disturbances::TOLERANCES); 0 tolerates no error of the model.
    pub tolerance: usize,
    /// The frozen filter.
    pub whitening: Whitening<'a>,
    /// The fit.
    pub fitted: Fitted,
}

impl FrozenFit<'_> {
    /// Minus the log-likelihood up to a constant, comparable between tolerances.
    pub fn evidence_cost(&self) -> f64 {
        self.fitted.fit.total() + self.whitening.half_log_determinant()
    }
}

/// Fits a shape at the tolerance that makes its innovations most likely, from the most tolerant one down.
pub fn freeze<'a>(
    case: &'a Case,
    shape: &Shape,
    disturbances: &DisturbanceModel,
    start: &[f64],
    from: usize,
) -> FrozenFit<'a> {
    let (mut whitening, mut fit) = fit_at(case, shape, &disturbances.tolerant(from), start);
    let mut tolerance = from;
    while tolerance > 0 {
        let (next, closer) = fit_at(case, shape, &disturbances.tolerant(tolerance - 1), &fit.theta);
        let cost = |whitening: &Whitening, fit: &Fit| fit.total() + whitening.half_log_determinant();
        if cost(&next, &closer) >= cost(&whitening, &fit) {
            break;
        }
        (whitening, fit, tolerance) = (next, closer, tolerance - 1);
    }
    let fitted = close(&whitening, shape, fit);
    FrozenFit { case, tolerance, whitening, fitted }
}

/// Fits a shape at the tolerance that makes its innovations most likely, from the least tolerant one up.
pub fn freeze_upwards<'a>(
    case: &'a Case,
    shape: &Shape,
    disturbances: &DisturbanceModel,
    start: &[f64],
    to: usize,
) -> FrozenFit<'a> {
    let (mut whitening, mut fit) = fit_at(case, shape, &disturbances.tolerant(0), start);
    let mut tolerance = 0;
    while tolerance < to {
        let (next, looser) = fit_at(case, shape, &disturbances.tolerant(tolerance + 1), &fit.theta);
        let cost = |whitening: &Whitening, fit: &Fit| fit.total() + whitening.half_log_determinant();
        if cost(&next, &looser) >= cost(&whitening, &fit) {
            break;
        }
        (whitening, fit, tolerance) = (next, looser, tolerance + 1);
    }
    let fitted = close(&whitening, shape, fit);
    FrozenFit { case, tolerance, whitening, fitted }
}

/// Short fits of all candidates on open-loop windows on top of a model, each from its first start and from where `led` says, if it
/// does: indices, shapes and parameters of the best `count`, and of the best that is `wanted` if it is not among them.
///
/// Where the model is grossly wrong, a tolerant filter follows the measurements so closely that a late or smoothed sensor in
/// its feedback unsettles it, and a form that is not quite right looks like any other. Open loop there is no feedback, and
/// what pads and wind add is small beside what is wrong.
pub fn open_loop_trials(
    case: &Case,
    (shape, theta): (&Shape, &[f64]),
    candidates: &[Candidate],
    led: &[Option<FittedEffect>],
    count: usize,
    wanted: &dyn Fn(&Shape, &[f64]) -> bool,
) -> Vec<(usize, Shape, Vec<f64>)> {
    let (problem, base) = windows::reweighted(case, shape, theta);
    let residuals = problem.residuals(&base);
    let columns = problem.columns(shape.parameters(), &base, &residuals, 0..base.len());
    let fit = |effect: &FittedEffect| {
        let with = shape.with(effect);
        let start: Vec<f64> = base.iter().copied().chain(effect.parameters.iter().map(|p| p.start)).collect();
        let effort = Effort { slow_columns: base.len(), ..OPEN_LOOP };
        let fit = solver::fit(&problem.with(&with), with.parameters(), &start, effort, Some(&columns));
        (fit.total(), with, fit.theta)
    };
    let best = |(i, c): (usize, &Candidate)| {
        let starts = c.starts.iter().take(1).chain(led.get(i).and_then(Option::as_ref));
        let fits = starts.map(fit).min_by(|a, b| a.0.total_cmp(&b.0));
        fits.map(|(cost, shape, theta)| (cost, i, shape, theta))
    };
    let mut all: Vec<(f64, usize, Shape, Vec<f64>)> =
        candidates.par_iter().enumerate().filter_map(best).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let first = all.iter().position(|(_, _, shape, theta)| wanted(shape, theta));
    let beyond = first.filter(|first| *first >= count);
    if let Some(first) = beyond {
        all.swap(count, first);
    }
    all.truncate(count + usize::from(beyond.is_some()));
    all.into_iter().map(|(_, i, shape, theta)| (i, shape, theta)).collect()
}

/// Fits a shape at one tolerance: twice, since the gains depend on the fit.
fn fit_at<'a>(
    case: &'a Case,
    shape: &Shape,
    disturbances: &DisturbanceModel,
    start: &[f64],
) -> (Whitening<'a>, Fit) {
    let fit_with = |start: &[f64], effort: Effort| {
        let whitening = Whitening::new(case, &shape.build(start), disturbances);
        let effort = Effort { slow_columns: shape.nuisance_count(), ..effort };
        let problem = Innovations { whitening: &whitening, shape };
        let fit = solver::fit(&problem, shape.parameters(), start, effort, None);
        (whitening, fit)
    };
    let (_, first) = fit_with(start, SHORT);
    fit_with(&first.theta, FULL)
}

/// Robust cost of each stretch of so many residuals.
pub(crate) fn costs_of_stretches(residuals: &[f64], length: usize) -> Vec<f64> {
    residuals.chunks(length).map(|stretch| solver::cost_of(stretch, OUTLIER_SIGMA)).collect()
}
