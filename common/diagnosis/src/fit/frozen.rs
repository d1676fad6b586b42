//! Frozen fits: a model fitted with the one-step filter frozen at itself, at the tolerance that makes it most likely.

use crate::data::case::Case;
use crate::fit::candidate::{FIRST, FULL, Fitted, OPEN_LOOP, SHORT, close};
use crate::fit::objective::{Innovations, Whitening, Windows};
use crate::fit::solver::{self, Effort, Fit, Problem};
use crate::fit::windows;
use crate::model::candidates::Candidate;
use crate::model::parameters::{FittedEffect, Parameter, Shape};
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

/// Fits a shape at the tolerance that makes its innovations most likely, from the tolerance `from` down.
pub fn freeze<'a>(
    case: &'a Case,
    shape: &Shape,
    disturbances: &DisturbanceModel,
    start: &[f64],
    from: usize,
) -> FrozenFit<'a> {
    freeze_along(case, shape, disturbances, start, (from, (0..from).rev()))
}

/// Fits a shape at the tolerance that makes its innovations most likely, from the least tolerant one up.
pub fn freeze_upwards<'a>(
    case: &'a Case,
    shape: &Shape,
    disturbances: &DisturbanceModel,
    start: &[f64],
    to: usize,
) -> FrozenFit<'a> {
    freeze_along(case, shape, disturbances, start, (0, 1..=to))
}

/// Fits a shape at one tolerance after the other while that makes its innovations more likely: in short fits, of which the last
/// is carried to its end.
fn freeze_along<'a>(
    case: &'a Case,
    shape: &Shape,
    disturbances: &DisturbanceModel,
    start: &[f64],
    (first, further): (usize, impl Iterator<Item = usize>),
) -> FrozenFit<'a> {
    let begin = |tolerance: usize, start: &[f64]| {
        let (whitening, begun) = begin_at(case, shape, &disturbances.tolerant(tolerance), start);
        (begun.fit.total() + whitening.half_log_determinant(), begun)
    };
    let mut tolerance = first;
    let (mut cost, mut begun) = begin(first, start);
    for next in further {
        let (next_cost, next_begun) = begin(next, &begun.fit.theta);
        if next_cost >= cost {
            break;
        }
        (tolerance, cost, begun) = (next, next_cost, next_begun);
    }
    let (whitening, fit) = end_at(case, shape, &disturbances.tolerant(tolerance), begun);
    let fitted = close(&whitening, shape, fit);
    FrozenFit { case, tolerance, whitening, fitted }
}

/// Effort of a fit that tells how likely a tolerance is.
const BEGINNING: Effort = Effort { iterations: 5, ..SHORT };

/// Rate to which recordings are thinned to try candidates on open-loop windows, Hz: what is left of an open-loop error within a window
/// drifts slowly. Effort.
const TRIAL_RATE_HZ: f64 = 25.0;
/// Of the candidates tried on open-loop windows, so many times those that are asked for get more than a first step. Effort.
const GOING_ON: usize = 4;

/// Short fits of all candidates on open-loop windows on top of a model, each from its first start and from where `led` says, if it
/// does: indices, shapes and parameters of the best `count`, and of the best that is `wanted` if it is not among them. A stretch of
/// track starts where the windows ask for it, see [`Scan`]: a tolerant filter leads it anywhere.
///
/// Where the model is grossly wrong, a tolerant filter follows the measurements so closely that a late or smoothed sensor in
/// its feedback unsettles it, and a form that is not quite right looks like any other. Open loop there is no feedback, and
/// what pads and wind add is small beside what is wrong.
///
/// All take a first step, on recordings thinned to `TRIAL_RATE_HZ`; `GOING_ON` times `count` of them, and those `wanted`, are
/// fitted further.
pub fn open_loop_trials(
    case: &Case,
    (shape, theta): (&Shape, &[f64]),
    candidates: &[Candidate],
    led: &[Option<FittedEffect>],
    count: usize,
    wanted: &dyn Fn(&Shape, &[f64]) -> bool,
) -> Vec<(usize, Shape, Vec<f64>)> {
    let thinned = case.thinned(TRIAL_RATE_HZ);
    let case = thinned.as_ref().unwrap_or(case);
    let (problem, base) = windows::reweighted(case, shape, theta);
    let residuals = problem.residuals(&base);
    let columns = problem.columns(shape.parameters(), &base, &residuals, 0..base.len());
    let fit_as = |effect: &FittedEffect, effort: Effort| {
        let with = shape.with(effect);
        let start: Vec<f64> = base.iter().copied().chain(effect.parameters.iter().map(|p| p.start)).collect();
        let effort = Effort { slow_columns: base.len(), ..effort };
        let fit = solver::fit(&problem.with(&with), with.parameters(), &start, effort, Some(&columns));
        (fit.total(), with, fit.theta)
    };
    let scan = Scan { problem: &problem, shape, base: &base, residuals: &residuals, columns: &columns };
    let begin = |(i, c): (usize, &Candidate)| {
        let first = scan
            .best(&c.scan(case))
            .or_else(|| c.nearest(&|effect| fit_as(effect, windows::NO_STEP).0))
            .or_else(|| c.starts.first().cloned());
        // A stretch has its place to find before its strength means anything.
        let effort = if c.is_stretch() { OPEN_LOOP } else { FIRST };
        let fit = |effect: &FittedEffect| fit_as(effect, effort);
        let starts = first.iter().chain(led.get(i).and_then(Option::as_ref));
        let fits = starts.map(fit).min_by(|a, b| a.0.total_cmp(&b.0));
        fits.map(|(cost, shape, theta)| Trial { cost, candidate: i, shape, theta })
    };
    let mut all: Vec<Trial> = candidates.par_iter().enumerate().filter_map(begin).collect();
    all.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let is_wanted = |trial: &Trial| wanted(&trial.shape, &trial.theta);
    let going_on: Vec<bool> =
        (all.iter().enumerate()).map(|(rank, trial)| rank < GOING_ON * count || is_wanted(trial)).collect();
    all.par_iter_mut().zip(going_on).filter(|(_, goes_on)| *goes_on).for_each(|(trial, _)| {
        let Trial { cost, candidate, shape, theta } = trial;
        let effort = if candidates[*candidate].is_stretch() { FULL } else { OPEN_LOOP };
        let effort = Effort { slow_columns: base.len(), ..effort };
        let fit = solver::fit(&problem.with(shape), shape.parameters(), theta, effort, Some(&columns));
        (*cost, *theta) = (fit.total(), fit.theta);
    });
    all.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let first = all.iter().position(is_wanted);
    let beyond = first.filter(|first| *first >= count);
    if let Some(first) = beyond {
        all.swap(count, first);
    }
    all.truncate(count + usize::from(beyond.is_some()));
    all.into_iter().map(|trial| (trial.candidate, trial.shape, trial.theta)).collect()
}

/// A candidate fitted on open-loop windows so far.
struct Trial {
    cost: f64,
    /// Its index among the candidates.
    candidate: usize,
    shape: Shape,
    theta: Vec<f64>,
}

/// Looks for the place of an effect on the windows of a model: on each stretch its strength alone is fitted, in one step, because
/// the place means nothing before there is a strength.
struct Scan<'s, 'a> {
    problem: &'s Windows<'a>,
    shape: &'s Shape,
    base: &'s [f64],
    residuals: &'s [f64],
    columns: &'s [Vec<f64>],
}

impl Scan<'_, '_> {
    /// The stretch that promises most, with its strength.
    fn best(&self, stretches: &[FittedEffect]) -> Option<FittedEffect> {
        let steps: Vec<(f64, FittedEffect)> = stretches.par_iter().filter_map(|one| self.step(one)).collect();
        steps.into_iter().max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, effect)| effect)
    }

    /// What one step in the strength of an effect from none promises, and the effect with that strength.
    fn step(&self, effect: &FittedEffect) -> Option<(f64, FittedEffect)> {
        let strength = |name: &str| effect.spec.parameters.iter().find(|p| p.name == name)?.neutral;
        let own = effect.parameters.iter().position(|p| strength(&p.name).is_some())?;
        let mut effect = effect.clone();
        effect.parameters[own].start = strength(&effect.parameters[own].name)?;
        let with = self.shape.with(&effect);
        let index = self.base.len() + own;
        let theta: Vec<f64> =
            self.base.iter().copied().chain(effect.parameters.iter().map(|p| p.start)).collect();
        let problem = self.problem.with(&with);
        let column = problem.columns(with.parameters(), &theta, self.residuals, index..index + 1);
        let all: Vec<&[f64]> = self.columns.iter().chain(&column).map(Vec::as_slice).collect();
        let blocks = solver::blocks_of(self.residuals, &all, problem.block_ends(), problem.huber());
        let parameters: Vec<Parameter> =
            self.shape.parameters().iter().chain([&effect.parameters[own]]).cloned().collect();
        let at: Vec<f64> = self.base.iter().copied().chain([theta[index]]).collect();
        let (gradient, curvature) = solver::assemble(&parameters, &at, &blocks);
        let step = -curvature.cholesky()?.solve(&gradient);
        let gain = -0.5 * gradient.dot(&step);
        let strong = &mut effect.parameters[own];
        strong.start = (strong.start + step[self.base.len()]).clamp(strong.lower, strong.upper);
        Some((gain, effect))
    }
}

/// A short fit, and the derivatives with respect to the nuisances where it began.
struct Begun {
    fit: Fit,
    columns: Vec<Vec<f64>>,
}

/// Begins to fit a shape at one tolerance, with the filter frozen at `start`.
fn begin_at<'a>(
    case: &'a Case,
    shape: &Shape,
    disturbances: &DisturbanceModel,
    start: &[f64],
) -> (Whitening<'a>, Begun) {
    let whitening = Whitening::new(case, &shape.build(start), disturbances);
    let problem = Innovations { whitening: &whitening, shape };
    let effort = Effort { slow_columns: shape.nuisance_count(), ..BEGINNING };
    let (fit, columns) = solver::fit_keeping(&problem, shape.parameters(), start, effort);
    (whitening, Begun { fit, columns })
}

/// Carries on what was begun at the same tolerance to its end, with the filter frozen where that is: its gains depend on it.
fn end_at<'a>(
    case: &'a Case,
    shape: &Shape,
    disturbances: &DisturbanceModel,
    Begun { fit, columns }: Begun,
) -> (Whitening<'a>, Fit) {
    let whitening = Whitening::new(case, &shape.build(&fit.theta), disturbances);
    let problem = Innovations { whitening: &whitening, shape };
    let effort = Effort { slow_columns: shape.nuisance_count(), ..FULL };
    let fit = solver::fit(&problem, shape.parameters(), &fit.theta, effort, Some(&columns));
    (whitening, fit)
}

/// Robust cost of each stretch of so many residuals.
pub(crate) fn costs_of_stretches(residuals: &[f64], length: usize) -> Vec<f64> {
    residuals.chunks(length).map(|stretch| solver::cost_of(stretch, OUTLIER_SIGMA)).collect()
}
