//! Fits of candidates: nuisances refitted with every one, nonlinearly, from every start.

use crate::case::Case;
use crate::innovations::Clutter;
use crate::library::Candidate;
use crate::objective::{Innovations, Whitening};
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
const FULL: Effort = Effort { iterations: 10, slow_columns: 0, refresh: 4, tolerance: 0.2 };
/// Effort spent on each start before the best go on.
const SHORT: Effort = Effort { iterations: 3, slow_columns: 0, refresh: 100, tolerance: 0.5 };
/// Effort of the starts that go on.
const LONG: Effort = Effort { iterations: 7, slow_columns: 0, refresh: 3, tolerance: 0.3 };
/// Gain of a short fit below which a candidate is not pursued further: a tenth of what raises an alarm.
const WORTHWHILE: f64 = 3.0;
/// Candidates whose short fit gained less than this share of the best one's are not pursued further.
const PURSUED_SHARE: f64 = 0.12;
/// Starts that go on.
const SURVIVORS: usize = 2;

/// Fits a shape from `start` to the end and linearises there.
pub fn finish(whitening: &Whitening, shape: &Shape, start: &[f64], slow: Option<&[Vec<f64>]>) -> Fitted {
    let problem = Innovations { whitening, shape };
    let slow_columns = slow.map_or(0, <[Vec<f64>]>::len);
    let effort = Effort { slow_columns, ..FULL };
    let mut fit = solver::fit(&problem, shape.parameters(), start, effort, slow);
    let (residuals, columns) = solver::linearise(&problem, shape.parameters(), &mut fit);
    // Frozen nuisance columns may have stopped the fit short of the optimum: one more round with all fresh.
    if slow.is_some() {
        let (gradient, curvature) = solver::assemble(shape.parameters(), &fit.theta, &fit.blocks);
        let short = curvature.cholesky().map_or(0.0, |c| 0.5 * gradient.dot(&c.solve(&gradient)));
        if short > 0.2 {
            let again = solver::fit(&problem, shape.parameters(), &fit.theta, FULL, None);
            fit = Fit { converged: again.converged, ..again };
            let (residuals, columns) = solver::linearise(&problem, shape.parameters(), &mut fit);
            let left_out = solver::leave_one_out(&problem, shape.parameters(), &fit);
            return Fitted { shape: shape.clone(), fit, residuals, columns, left_out };
        }
    }
    let left_out = solver::leave_one_out(&problem, shape.parameters(), &fit);
    Fitted { shape: shape.clone(), fit, residuals, columns, left_out }
}

/// Short fits of one candidate on top of `base`, from all its starts; those that may still win, best first.
fn trials(whitening: &Whitening, base: &Fitted, candidate: &Candidate) -> Vec<(FittedEffect, Fit)> {
    let mut trials: Vec<(FittedEffect, Fit)> =
        candidate.starts.iter().map(|effect| (effect.clone(), short_fit(whitening, base, effect))).collect();
    trials.sort_by(|a, b| a.1.total().total_cmp(&b.1.total()));
    trials.truncate(SURVIVORS);
    let best = trials.first().map_or(0.0, |(_, fit)| fit.total());
    let span = 0.3 * (base.fit.total() - best).max(0.0) + 5.0;
    trials.retain(|(_, fit)| fit.total() < best + span);
    trials
}

/// Carries short fits on to the end, or takes the best as it is if it gained less than `worthwhile`.
fn pursue(
    whitening: &Whitening,
    base: &Fitted,
    mut trials: Vec<(FittedEffect, Fit)>,
    worthwhile: f64,
) -> Fitted {
    let best = trials.first().map_or(f64::INFINITY, |(_, fit)| fit.total());
    if base.fit.total() - best < worthwhile {
        trials.truncate(1);
        return trials
            .pop()
            .map_or_else(|| base.clone(), |(effect, fit)| settle_short(whitening, base, &effect, fit));
    }
    trials
        .iter()
        .map(|(effect, fit)| {
            let shape = base.shape.with(effect);
            let problem = Innovations { whitening, shape: &shape };
            let effort = Effort { slow_columns: base.columns.len(), ..LONG };
            let mut fit = solver::fit(&problem, shape.parameters(), &fit.theta, effort, Some(&base.columns));
            let (residuals, columns) = solver::linearise(&problem, shape.parameters(), &mut fit);
            let left_out = solver::leave_one_out(&problem, shape.parameters(), &fit);
            Fitted { shape, fit, residuals, columns, left_out }
        })
        .min_by(|a, b| a.fit.total().total_cmp(&b.fit.total()))
        .unwrap_or_else(|| base.clone())
}

/// Fits one candidate on top of `base`, from all its starts.
pub fn fit_candidate(whitening: &Whitening, base: &Fitted, candidate: &Candidate) -> Fitted {
    pursue(whitening, base, trials(whitening, base, candidate), WORTHWHILE)
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

fn short_fit(whitening: &Whitening, base: &Fitted, effect: &FittedEffect) -> Fit {
    let shape = base.shape.with(effect);
    let mut start = base.fit.theta.clone();
    start.extend(effect.parameters.iter().map(|p| p.start));
    let problem = Innovations { whitening, shape: &shape };
    let effort = Effort { slow_columns: base.columns.len(), ..SHORT };
    solver::fit(&problem, shape.parameters(), &start, effort, Some(&base.columns))
}

/// As [`fit_candidate`], from the first start and only as far as a ranking needs.
pub fn fit_briefly(whitening: &Whitening, base: &Fitted, candidate: &Candidate) -> Fitted {
    let Some(effect) = candidate.starts.first() else { return base.clone() };
    let fit = short_fit(whitening, base, effect);
    settle_short(whitening, base, effect, fit)
}

/// Fits every candidate on top of `base`; the order of the results is that of the candidates on any number of threads.
pub fn fit_all(
    whitening: &Whitening,
    base: &Fitted,
    candidates: &[Candidate],
    progress: &(dyn Fn(&'static str) + Sync),
) -> Vec<Fitted> {
    let short: Vec<Vec<(FittedEffect, Fit)>> =
        candidates.par_iter().map(|candidate| trials(whitening, base, candidate)).collect();
    let gain =
        |trials: &Vec<(FittedEffect, Fit)>| trials.first().map_or(0.0, |(_, f)| base.fit.total() - f.total());
    let worthwhile = (PURSUED_SHARE * short.iter().map(gain).fold(0.0, f64::max)).max(WORTHWHILE);
    short
        .into_par_iter()
        .zip(candidates)
        .map(|(trials, candidate)| {
            let fitted = pursue(whitening, base, trials, worthwhile);
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
    let mut best: Option<Level<'a>> = None;
    let mut theta = start.to_vec();
    for level in (0..=from).rev() {
        let next = at_level(case, shape, &clutter.tolerant(level), &theta, level);
        let worse = best.as_ref().is_some_and(|b| next.evidence_cost() >= b.evidence_cost());
        if worse && best.is_some() {
            break;
        }
        theta.clone_from(&next.fitted.fit.theta);
        best = Some(next);
    }
    best.unwrap_or_else(|| at_level(case, shape, clutter, start, 0))
}

/// Fits a shape at one tolerance: twice, since the gains depend on the fit.
fn at_level<'a>(case: &'a Case, shape: &Shape, clutter: &Clutter, start: &[f64], level: usize) -> Level<'a> {
    let whitening = Whitening::new(case, &shape.build(start), clutter);
    let problem = Innovations { whitening: &whitening, shape };
    let theta = solver::fit(&problem, shape.parameters(), start, SHORT, None).theta;
    let whitening = Whitening::new(case, &shape.build(&theta), clutter);
    let fitted = finish(&whitening, shape, &theta, None);
    Level { level, whitening, fitted }
}

/// Number of residuals of a problem.
pub fn count(problem: &impl Problem) -> usize {
    problem.block_ends().last().copied().unwrap_or(0)
}
