//! Fits of candidates: nuisances refitted with every one, nonlinearly, from every start.

use crate::decide::criteria::{Acceptance, Pursuit};
use crate::fit::leaving;
use crate::fit::objective::Objective;
use crate::fit::solver::{self, Effort, Fit};
use crate::model::candidates::Candidate;
use crate::model::parameters::{FittedEffect, Shape};
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
    /// Half cost of each run where the last effect is fitted to the others, see [`leaving::leave_one_out`].
    pub left_out: Vec<f64>,
}

impl Fitted {
    /// Whether the strength of an effect sits on a bound that is not its neutral value and that is felt: to leave it costs something.
    pub(crate) fn is_on_bound(&self, effect: usize, acceptance: &Acceptance) -> bool {
        let Some(own) = self.shape.effects.get(effect) else { return false };
        let range = self.shape.range_of(effect);
        own.parameters.iter().zip(range).any(|(p, index)| {
            let neutral = own.spec.parameters.iter().find(|s| s.name == p.name).and_then(|s| s.neutral);
            let span = p.upper - p.lower;
            let is_at = |bound: f64| {
                (self.fit.theta[index] - bound).abs() < 1e-6 * span && neutral.is_some_and(|n| n != bound)
            };
            let inward =
                if is_at(p.lower) { acceptance.felt_share * span } else { -acceptance.felt_share * span };
            let cost = || leaving::cost_of_leaving(self.shape.parameters(), &self.fit, index, inward);
            (is_at(p.lower) || is_at(p.upper)) && cost().is_none_or(|cost| cost > acceptance.felt_cost)
        })
    }

    /// What the last effect gains over `base`, the model without it, on each run when it is fitted to the others.
    pub fn gains_left_out(&self, base: &Self) -> Vec<f64> {
        base.fit.blocks.iter().zip(&self.left_out).map(|(before, after)| before.cost - after).collect()
    }

    /// The same of all runs.
    pub fn predictive_gain(&self, base: &Self) -> f64 {
        self.gains_left_out(base).iter().sum()
    }
}

/// Effort of a fit that is carried to its end.
pub(super) const FULL: Effort = Effort { iterations: 10, slow_columns: 0, refresh: 3, tolerance: 0.2 };
/// Effort of a try on open-loop windows.
pub(super) const OPEN_LOOP: Effort = Effort { iterations: 3, slow_columns: 0, refresh: 100, tolerance: 0.5 };
/// Effort that tells a start that leads somewhere from one that does not.
pub(super) const FIRST: Effort = Effort { iterations: 1, slow_columns: 0, refresh: 100, tolerance: 0.5 };
/// Effort spent on each start that leads somewhere.
pub(super) const SHORT: Effort = Effort { iterations: 3, slow_columns: 0, refresh: 100, tolerance: 0.5 };
/// Effort of the starts that go on.
const LONG: Effort = Effort { iterations: 7, slow_columns: 0, refresh: 3, tolerance: 0.3 };
/// What candidates are ranked by: their gain on all runs and on left-out runs, the latter within limits.
pub fn score(gain: f64, predictive: f64, pursuit: &Pursuit) -> f64 {
    let size = gain.max(0.0);
    let [least, most] = pursuit.left_out_limits;
    gain + predictive.clamp(least * size, most * size)
}

/// Linearises at the solution of a fit and predicts each run from the others.
pub(super) fn close(objective: &dyn Objective, shape: &Shape, mut fit: Fit) -> Fitted {
    let problem = objective.of(shape);
    let (residuals, columns) = solver::linearise(&*problem, shape.parameters(), &mut fit);
    let left_out = leaving::leave_one_out(&*problem, shape.parameters(), &fit, shape.range_of_last());
    Fitted { shape: shape.clone(), fit, residuals, columns, left_out }
}

/// A fit of an effect of the library so far.
type Trial = (FittedEffect, Fit);

fn by_cost(a: &Trial, b: &Trial) -> std::cmp::Ordering {
    a.1.total().total_cmp(&b.1.total())
}

/// One step of one candidate on top of `base` from each of its starts; those that promise most, best first.
fn first_steps(
    objective: &dyn Objective,
    base: &Fitted,
    candidate: &Candidate,
    pursuit: &Pursuit,
) -> Vec<Trial> {
    let first =
        |effect: &FittedEffect| (effect.clone(), go_on(objective, base, effect, &start(base, effect), FIRST));
    let cost = |effect: &FittedEffect| {
        let shape = base.shape.with(effect);
        let problem = objective.of(&shape);
        solver::cost_of(&problem.residuals(&start(base, effect)), problem.huber())
    };
    let mut trials: Vec<Trial> =
        candidate.nearest(&cost).iter().chain(&candidate.starts).map(first).collect();
    trials.sort_by(by_cost);
    trials.truncate(pursuit.promising_starts);
    trials
}

/// Carries first steps on to short fits; those that may still win, best first.
fn short_fits(
    objective: &dyn Objective,
    base: &Fitted,
    mut trials: Vec<Trial>,
    pursuit: &Pursuit,
) -> Vec<Trial> {
    for (effect, fit) in &mut trials {
        *fit = go_on(objective, base, effect, &fit.theta, SHORT);
    }
    trials.sort_by(by_cost);
    trials.truncate(pursuit.surviving_starts);
    let best = trials.first().map_or(0.0, |(_, fit)| fit.total());
    let span = pursuit.start_span_share * (base.fit.total() - best).max(0.0) + pursuit.start_span;
    trials.retain(|(_, fit)| fit.total() < best + span);
    trials
}

/// Where a fit of an effect on top of `base` starts.
fn start(base: &Fitted, effect: &FittedEffect) -> Vec<f64> {
    base.fit.theta.iter().copied().chain(effect.parameters.iter().map(|p| p.start)).collect()
}

/// Fits on from `start`, at first with the nuisances' columns of `base`.
fn go_on(
    objective: &dyn Objective,
    base: &Fitted,
    effect: &FittedEffect,
    start: &[f64],
    effort: Effort,
) -> Fit {
    let shape = base.shape.with(effect);
    let problem = objective.of(&shape);
    let effort = Effort { slow_columns: base.columns.len(), ..effort };
    solver::fit(&*problem, shape.parameters(), start, effort, Some(&base.columns))
}

/// The best of some trials as far as it is.
fn settle_best(objective: &dyn Objective, base: &Fitted, trials: Vec<Trial>) -> Fitted {
    let best = trials.into_iter().min_by(|a, b| a.1.total().total_cmp(&b.1.total()));
    best.map_or_else(|| base.clone(), |(effect, fit)| settle_short(objective, base, &effect, fit))
}

/// Carries short fits on to the end.
fn pursue(objective: &dyn Objective, base: &Fitted, trials: &[Trial]) -> Fitted {
    let fits = trials.iter().map(|(effect, fit)| (effect, go_on(objective, base, effect, &fit.theta, LONG)));
    fits.min_by(|a, b| a.1.total().total_cmp(&b.1.total()))
        .map_or_else(|| base.clone(), |(effect, fit)| close(objective, &base.shape.with(effect), fit))
}

/// Fits on from where `led` ended, with another objective.
pub(super) fn settle(objective: &dyn Objective, led: &Fitted) -> Fitted {
    let problem = objective.of(&led.shape);
    let effort = Effort { slow_columns: led.shape.nuisance_count(), ..LONG };
    let nuisances = led.columns.get(..led.shape.nuisance_count());
    let fit = solver::fit(&*problem, led.shape.parameters(), &led.fit.theta, effort, nuisances);
    close(objective, &led.shape, fit)
}

/// Fits one candidate on top of `base`, from all its starts, to the end.
pub fn fit_candidate(
    objective: &dyn Objective,
    base: &Fitted,
    candidate: &Candidate,
    pursuit: &Pursuit,
) -> Fitted {
    let first = first_steps(objective, base, candidate, pursuit);
    let trials = short_fits(objective, base, first, pursuit);
    if gain_of(base, &trials) < pursuit.worthwhile_gain {
        return settle_best(objective, base, trials);
    }
    pursue(objective, base, &trials)
}

fn gain_of(base: &Fitted, trials: &[Trial]) -> f64 {
    trials.iter().map(|(_, fit)| base.fit.total() - fit.total()).fold(0.0, f64::max)
}

/// Takes a short fit that gained next to nothing as it is: the nuisances stand where they stood, and so do their columns.
fn settle_short(objective: &dyn Objective, base: &Fitted, effect: &FittedEffect, fit: Fit) -> Fitted {
    let shape = base.shape.with(effect);
    let problem = objective.of(&shape);
    let residuals = problem.residuals(&fit.theta);
    let own = base.columns.len()..fit.theta.len();
    let mut columns = base.columns.clone();
    columns.extend(problem.columns(shape.parameters(), &fit.theta, &residuals, own));
    let blocks = solver::blocks_of(&residuals, &columns, problem.block_ends(), problem.huber());
    let fit = Fit { blocks, ..fit };
    let left_out = leaving::leave_one_out(&*problem, shape.parameters(), &fit, shape.range_of_last());
    drop(problem);
    Fitted { shape, fit, residuals, columns, left_out }
}

/// Gain that a linearised candidate promises, from its first start, where it must do nothing yet.
pub fn linear_gain(objective: &dyn Objective, base: &Fitted, candidate: &Candidate) -> f64 {
    let Some(effect) = candidate.starts.first() else { return 0.0 };
    let shape = base.shape.with(effect);
    let problem = objective.of(&shape);
    let theta = start(base, effect);
    let own = base.columns.len()..theta.len();
    let own = problem.columns(shape.parameters(), &theta, &base.residuals, own);
    let all: Vec<&[f64]> = base.columns.iter().chain(&own).map(Vec::as_slice).collect();
    let blocks = solver::blocks_of(&base.residuals, &all, problem.block_ends(), problem.huber());
    let (gradient, curvature) = solver::assemble(shape.parameters(), &theta, &blocks);
    curvature.cholesky().map_or(0.0, |factor| 0.5 * gradient.dot(&factor.solve(&gradient)))
}

/// As [`fit_candidate`], from the first start and only as far as a ranking needs.
pub fn fit_briefly(objective: &dyn Objective, base: &Fitted, candidate: &Candidate) -> Fitted {
    let Some(effect) = candidate.starts.first() else { return base.clone() };
    let fit = go_on(objective, base, effect, &start(base, effect), SHORT);
    settle_short(objective, base, effect, fit)
}

/// Fits every candidate on top of `base`; the order of the results is that of the candidates on any number of threads.
pub fn fit_all(
    objective: &dyn Objective,
    base: &Fitted,
    candidates: &[Candidate],
    pursuit: &Pursuit,
    progress: &(dyn Fn(&'static str) + Sync),
) -> Vec<Fitted> {
    let best = |all: &[Vec<Trial>]| all.iter().map(|trials| gain_of(base, trials)).fold(0.0, f64::max);
    let first: Vec<Vec<Trial>> =
        candidates.par_iter().map(|candidate| first_steps(objective, base, candidate, pursuit)).collect();
    let promising = pursuit.first_fit_share * best(&first);
    let mut short: Vec<Vec<Trial>> = first
        .into_par_iter()
        .map(|trials| match gain_of(base, &trials) < promising {
            true => trials,
            false => short_fits(objective, base, trials, pursuit),
        })
        .collect();
    let worthwhile = (pursuit.second_fit_share * best(&short)).max(pursuit.worthwhile_gain);
    short.par_iter_mut().filter(|trials| gain_of(base, trials) >= worthwhile).for_each(|trials| {
        for (effect, fit) in trials {
            *fit = go_on(objective, base, effect, &fit.theta, SHORT);
        }
    });
    let least = (pursuit.full_fit_share * best(&short)).max(pursuit.worthwhile_gain);
    short
        .into_par_iter()
        .zip(candidates)
        .map(|(trials, candidate)| {
            let fitted = if gain_of(base, &trials) >= least {
                pursue(objective, base, &trials)
            } else {
                settle_best(objective, base, trials)
            };
            progress(candidate.spec.id);
            fitted
        })
        .collect()
}
