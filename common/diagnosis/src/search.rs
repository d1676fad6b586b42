//! Fits of candidates: nuisances refitted with every one, nonlinearly, from every start.

use crate::case::Case;
use crate::innovations::Clutter;
use crate::library::Candidate;
use crate::objective::{INNOVATION_HUBER, Innovations, Whitening};
use crate::parameters::{FittedEffect, Shape};
use crate::solver::{self, Effort, Fit, Problem};
use rayon::prelude::*;

/// A fitted model and how well it predicts.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The shape.
    pub shape: Shape,
    /// The fit, with the normal equations of each run.
    pub fit: Fit,
    /// Residuals at the solution.
    pub residuals: Vec<f64>,
    /// Their derivatives.
    pub columns: Vec<Vec<f64>>,
    /// Predicted half cost of each run from a fit to the others.
    pub left_out: Vec<f64>,
}

impl Fitted {
    /// Sum of the predicted half costs.
    pub fn predictive_cost(&self) -> f64 {
        self.left_out.iter().sum()
    }
}

/// Effort of a fit that is carried to its end.
const FULL: Effort = Effort { iterations: 10, slow_columns: 0, refresh: 3, tolerance: 0.2 };
/// Effort that tells a start that leads somewhere from one that does not.
const FIRST: Effort = Effort { iterations: 1, slow_columns: 0, refresh: 100, tolerance: 0.5 };
/// Effort spent on each start that leads somewhere.
const SHORT: Effort = Effort { iterations: 3, slow_columns: 0, refresh: 100, tolerance: 0.5 };
/// Effort of the starts that go on.
const LONG: Effort = Effort { iterations: 7, slow_columns: 0, refresh: 3, tolerance: 0.3 };
/// Gain of a short fit below which a candidate is not pursued further: a tenth of what raises an alarm.
const WORTHWHILE: f64 = 3.0;
/// Candidates whose short fit gained more than this share of the best one's get another short fit.
const PURSUED_SHARE: f64 = 0.12;
/// Candidates that have gained this share of the best one's after that are carried to the end.
const FINISHED_SHARE: f64 = 0.4;
/// Starts that get more than one step.
const PROMISING: usize = 3;
/// Starts that go on.
const SURVIVORS: usize = 2;

/// Linearises at the solution of a fit and predicts each run from the others.
fn close(whitening: &Whitening, shape: &Shape, mut fit: Fit) -> Fitted {
    let problem = Innovations { whitening, shape };
    let (residuals, columns) = solver::linearise(&problem, shape.parameters(), &mut fit);
    let left_out = solver::leave_one_out(&problem, shape.parameters(), &fit);
    Fitted { shape: shape.clone(), fit, residuals, columns, left_out }
}

/// Short fits of one candidate on top of `base`, from all its starts; those that may still win, best first.
fn trials(whitening: &Whitening, base: &Fitted, candidate: &Candidate) -> Vec<(FittedEffect, Fit)> {
    let by_cost = |a: &(FittedEffect, Fit), b: &(FittedEffect, Fit)| a.1.total().total_cmp(&b.1.total());
    let first =
        |effect: &FittedEffect| (effect.clone(), go_on(whitening, base, effect, &start(base, effect), FIRST));
    let mut trials: Vec<(FittedEffect, Fit)> = candidate.starts.iter().map(first).collect();
    trials.sort_by(by_cost);
    trials.truncate(PROMISING);
    for (effect, fit) in &mut trials {
        *fit = go_on(whitening, base, effect, &fit.theta, SHORT);
    }
    trials.sort_by(by_cost);
    trials.truncate(SURVIVORS);
    let best = trials.first().map_or(0.0, |(_, fit)| fit.total());
    let span = 0.3 * (base.fit.total() - best).max(0.0) + 5.0;
    trials.retain(|(_, fit)| fit.total() < best + span);
    trials
}

/// Where a fit of an effect on top of `base` starts.
fn start(base: &Fitted, effect: &FittedEffect) -> Vec<f64> {
    base.fit.theta.iter().copied().chain(effect.parameters.iter().map(|p| p.start)).collect()
}

/// Fits on from `start`, at first with the nuisances' columns of `base`.
fn go_on(whitening: &Whitening, base: &Fitted, effect: &FittedEffect, start: &[f64], effort: Effort) -> Fit {
    let shape = base.shape.with(effect);
    let problem = Innovations { whitening, shape: &shape };
    let effort = Effort { slow_columns: base.columns.len(), ..effort };
    solver::fit(&problem, shape.parameters(), start, effort, Some(&base.columns))
}

/// The best of some trials as far as it is.
fn settle_best(whitening: &Whitening, base: &Fitted, trials: Vec<(FittedEffect, Fit)>) -> Fitted {
    let best = trials.into_iter().min_by(|a, b| a.1.total().total_cmp(&b.1.total()));
    best.map_or_else(|| base.clone(), |(effect, fit)| settle_short(whitening, base, &effect, fit))
}

/// Carries short fits on to the end.
fn pursue(whitening: &Whitening, base: &Fitted, trials: &[(FittedEffect, Fit)]) -> Fitted {
    let fits = trials.iter().map(|(effect, fit)| (effect, go_on(whitening, base, effect, &fit.theta, LONG)));
    fits.min_by(|a, b| a.1.total().total_cmp(&b.1.total()))
        .map_or_else(|| base.clone(), |(effect, fit)| close(whitening, &base.shape.with(effect), fit))
}

/// Fits one candidate on top of `base`, from all its starts, to the end.
pub fn fit_candidate(whitening: &Whitening, base: &Fitted, candidate: &Candidate) -> Fitted {
    let trials = trials(whitening, base, candidate);
    if gain_of(base, &trials) < WORTHWHILE {
        return settle_best(whitening, base, trials);
    }
    pursue(whitening, base, &trials)
}

fn gain_of(base: &Fitted, trials: &[(FittedEffect, Fit)]) -> f64 {
    trials.iter().map(|(_, fit)| base.fit.total() - fit.total()).fold(0.0, f64::max)
}

/// Takes a short fit that gained next to nothing as it is: the nuisances stand where they stood, and so do their columns.
fn settle_short(whitening: &Whitening, base: &Fitted, effect: &FittedEffect, fit: Fit) -> Fitted {
    let shape = base.shape.with(effect);
    let problem = Innovations { whitening, shape: &shape };
    let residuals = problem.residuals(&fit.theta);
    let own = base.columns.len()..fit.theta.len();
    let mut columns = base.columns.clone();
    columns.extend(solver::columns(&problem, shape.parameters(), &fit.theta, &residuals, own));
    let blocks = solver::blocks_of(&residuals, &columns, problem.block_ends(), problem.huber());
    let fit = Fit { blocks, ..fit };
    let left_out = solver::leave_one_out(&problem, shape.parameters(), &fit);
    Fitted { shape, fit, residuals, columns, left_out }
}

/// Gain that a linearised candidate promises, from its first start, where it must do nothing yet.
pub fn linear_gain(whitening: &Whitening, base: &Fitted, candidate: &Candidate) -> f64 {
    let Some(effect) = candidate.starts.first() else { return 0.0 };
    let shape = base.shape.with(effect);
    let problem = Innovations { whitening, shape: &shape };
    let theta = start(base, effect);
    let own = base.columns.len()..theta.len();
    let own = solver::columns(&problem, shape.parameters(), &theta, &base.residuals, own);
    let all: Vec<&[f64]> = base.columns.iter().chain(&own).map(Vec::as_slice).collect();
    let blocks = solver::blocks_of(&base.residuals, &all, problem.block_ends(), problem.huber());
    let (gradient, curvature) = solver::assemble(shape.parameters(), &theta, &blocks);
    curvature.cholesky().map_or(0.0, |factor| 0.5 * gradient.dot(&factor.solve(&gradient)))
}

/// As [`fit_candidate`], from the first start and only as far as a ranking needs.
pub fn fit_briefly(whitening: &Whitening, base: &Fitted, candidate: &Candidate) -> Fitted {
    let Some(effect) = candidate.starts.first() else { return base.clone() };
    let fit = go_on(whitening, base, effect, &start(base, effect), SHORT);
    settle_short(whitening, base, effect, fit)
}

/// Fits every candidate on top of `base`; the order of the results is that of the candidates on any number of threads.
pub fn fit_all(
    whitening: &Whitening,
    base: &Fitted,
    candidates: &[Candidate],
    progress: &(dyn Fn(&'static str) + Sync),
) -> Vec<Fitted> {
    let mut short: Vec<Vec<(FittedEffect, Fit)>> =
        candidates.par_iter().map(|candidate| trials(whitening, base, candidate)).collect();
    let best = |short: &[Vec<(FittedEffect, Fit)>]| {
        short.iter().map(|trials| gain_of(base, trials)).fold(0.0, f64::max)
    };
    let worthwhile = (PURSUED_SHARE * best(&short)).max(WORTHWHILE);
    short.par_iter_mut().filter(|trials| gain_of(base, trials) >= worthwhile).for_each(|trials| {
        for (effect, fit) in trials {
            *fit = go_on(whitening, base, effect, &fit.theta, SHORT);
        }
    });
    let least = (FINISHED_SHARE * best(&short)).max(WORTHWHILE);
    short
        .into_par_iter()
        .zip(candidates)
        .map(|(trials, candidate)| {
            let fitted = if gain_of(base, &trials) >= least {
                pursue(whitening, base, &trials)
            } else {
                settle_best(whitening, base, trials)
            };
            progress(candidate.spec.id);
            fitted
        })
        .collect()
}

/// A filter frozen at one tolerance, and the model fitted with it.
#[derive(Debug)]
pub struct Level<'a> {
    /// Index of the tolerance.
    pub level: usize,
    /// The frozen filter.
    pub whitening: Whitening<'a>,
    /// The fit.
    pub fitted: Fitted,
}

impl Level<'_> {
    /// Minus the log-likelihood up to a constant, comparable between levels.
    pub fn evidence_cost(&self) -> f64 {
        self.fitted.fit.total() + self.whitening.half_log_determinant()
    }
}

/// Fits a shape at the tolerance that makes its innovations most likely, from the most tolerant level down.
pub fn settle<'a>(case: &'a Case, shape: &Shape, clutter: &Clutter, start: &[f64], from: usize) -> Level<'a> {
    let (mut whitening, mut fit) = at_level(case, shape, &clutter.tolerant(from), start);
    let mut level = from;
    while level > 0 {
        let (next, closer) = at_level(case, shape, &clutter.tolerant(level - 1), &fit.theta);
        let cost = |whitening: &Whitening, fit: &Fit| fit.total() + whitening.half_log_determinant();
        if cost(&next, &closer) >= cost(&whitening, &fit) {
            break;
        }
        (whitening, fit, level) = (next, closer, level - 1);
    }
    let fitted = close(&whitening, shape, fit);
    Level { level, whitening, fitted }
}

/// Fits a shape at the tolerance that makes its innovations most likely, from the least tolerant level up.
pub fn settle_upwards<'a>(
    case: &'a Case,
    shape: &Shape,
    clutter: &Clutter,
    start: &[f64],
    to: usize,
) -> Level<'a> {
    let (mut whitening, mut fit) = at_level(case, shape, &clutter.tolerant(0), start);
    let mut level = 0;
    while level < to {
        let (next, looser) = at_level(case, shape, &clutter.tolerant(level + 1), &fit.theta);
        let cost = |whitening: &Whitening, fit: &Fit| fit.total() + whitening.half_log_determinant();
        if cost(&next, &looser) >= cost(&whitening, &fit) {
            break;
        }
        (whitening, fit, level) = (next, looser, level + 1);
    }
    let fitted = close(&whitening, shape, fit);
    Level { level, whitening, fitted }
}

/// Short fits of all candidates with a filter that tolerates nothing: indices, shapes and parameters of the best `count`.
///
/// Where the model is grossly wrong, a tolerant filter follows the measurements so closely that a late or smoothed
/// sensor in its feedback unsettles it; one that trusts the model sees such an effect for what it is.
pub fn strict_trials(
    case: &Case,
    current: &Fitted,
    clutter: &Clutter,
    candidates: &[Candidate],
    count: usize,
) -> Vec<(usize, Shape, Vec<f64>)> {
    let (whitening, fit) = at_level(case, &current.shape, &clutter.tolerant(0), &current.fit.theta);
    let base = close(&whitening, &current.shape, fit);
    let first = |(i, c): (usize, &Candidate)| {
        trials(&whitening, &base, c).into_iter().next().map(|(effect, fit)| (i, effect, fit))
    };
    let mut best: Vec<(usize, FittedEffect, Fit)> =
        candidates.par_iter().enumerate().filter_map(first).collect();
    best.sort_by(|a, b| a.2.total().total_cmp(&b.2.total()));
    best.truncate(count);
    best.into_iter().map(|(i, effect, fit)| (i, base.shape.with(&effect), fit.theta)).collect()
}

/// Fits a shape at one tolerance: twice, since the gains depend on the fit.
fn at_level<'a>(case: &'a Case, shape: &Shape, clutter: &Clutter, start: &[f64]) -> (Whitening<'a>, Fit) {
    let fit_with = |start: &[f64], effort: Effort| {
        let whitening = Whitening::new(case, &shape.build(start), clutter);
        let effort = Effort { slow_columns: shape.nuisance_count(), ..effort };
        let problem = Innovations { whitening: &whitening, shape };
        let fit = solver::fit(&problem, shape.parameters(), start, effort, None);
        (whitening, fit)
    };
    let (_, first) = fit_with(start, SHORT);
    fit_with(&first.theta, FULL)
}

/// Robust cost of each stretch of residuals, five seconds or so.
pub(crate) fn costs_of_stretches(residuals: &[f64]) -> Vec<f64> {
    residuals.chunks(STRETCH).map(|stretch| solver::cost_of(stretch, INNOVATION_HUBER)).collect()
}

/// Residuals of a stretch: five seconds of three outputs at 100 Hz.
const STRETCH: usize = 1500;

/// Number of residuals of a problem.
pub fn count(problem: &impl Problem) -> usize {
    problem.block_ends().last().copied().unwrap_or(0)
}
