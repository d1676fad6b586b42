//! The search: calibrate, try every candidate, accept the best, try again on top of it, delete what is not needed.

use crate::case::Case;
use crate::innovations::Clutter;
use crate::library::{self, Candidate};
use crate::parameters::{FittedEffect, Shape};
use crate::search::{self, Fitted, Level};
use rayon::prelude::*;

/// Most effects that are named together.
const MOST_EFFECTS: usize = 3;
/// Gain of log-likelihood that needs no confirmation by left-out runs: an effect may show in a single run.
const CERTAIN: f64 = 200.0;
/// Candidates of a round that are carried to their own best filter.
const FINALISTS: usize = 3;

/// Tolerance level from which a misfit is so gross that candidates are also tried with a filter that trusts the model.
const GROSS: usize = 2;
/// Of these tries, how many are carried to their own best filter.
const STRICT_FINALISTS: usize = 3;

/// What one round tried on top of the model before it.
#[derive(Debug)]
pub struct Round {
    /// Log-likelihood gained by each candidate over the round's base, in the order of the library.
    pub gains: Vec<Gain>,
}

impl Round {
    /// Without the large tables that only the test against chance needs.
    fn lighter(mut self) -> Self {
        for gain in &mut self.gains {
            gain.fitted.columns = Vec::new();
            gain.fitted.residuals = Vec::new();
        }
        self
    }
}

/// How a candidate did.
#[derive(Clone, Debug)]
pub struct Gain {
    /// Id.
    pub id: &'static str,
    /// Decrease of the cost.
    pub gain: f64,
    /// Decrease of the leave-one-run-out cost.
    pub predictive: f64,
    /// The same, run by run.
    pub by_run: Vec<f64>,
    /// Whether the fit settled.
    pub converged: bool,
    /// The fitted model.
    pub fitted: Fitted,
}

impl Gain {
    /// The candidate's effect and its fitted values.
    pub fn own(&self) -> Option<(&FittedEffect, Vec<f64>)> {
        let shape = &self.fitted.shape;
        let effect = shape.effects.last().filter(|effect| effect.spec.id == self.id)?;
        Some((effect, self.fitted.fit.theta.get(shape.range_of(shape.effects.len() - 1))?.to_vec()))
    }

    /// What candidates are ranked by: gain on all runs and on left-out runs. A prediction from one Newton step can go far
    /// astray where a run alone carries a parameter, hence the limits.
    pub fn score(&self) -> f64 {
        let gain = self.gain.max(0.0);
        self.gain + self.predictive.clamp(-0.5 * gain, 1.5 * gain)
    }
}

/// The outcome of the search.
#[derive(Debug)]
pub struct Found<'a> {
    /// Nuisances alone.
    pub base: Level<'a>,
    /// Nuisances and accepted effects, with a filter frozen at them.
    pub best: Level<'a>,
    /// Rounds of forward selection; the last one accepted nothing.
    pub rounds: Vec<Round>,
}

/// What decides whether one more effect is real.
#[derive(Clone, Copy, Debug)]
pub struct Acceptance {
    /// Least gain of log-likelihood.
    pub gain: f64,
    /// Least gain of the leave-one-run-out log-likelihood.
    pub predictive: f64,
}

impl Default for Acceptance {
    fn default() -> Self {
        Self { gain: 30.0, predictive: 15.0 }
    }
}

/// Searches the library (without the ids of `without`).
pub fn search<'a>(
    case: &'a Case,
    without: &[String],
    acceptance: Acceptance,
    progress: &(dyn Fn(&'static str) + Sync),
) -> Found<'a> {
    let clutter = Clutter::default();
    let shape = Shape::nominal(case);
    let library = library::candidates(case, without);
    let base = search::settle(case, &shape, &clutter, &shape.start(), 3);
    let mut best: Option<Level<'a>> = None;
    let mut rounds = Vec::new();
    for _ in 0..MOST_EFFECTS {
        let current = best.as_ref().unwrap_or(&base);
        let named = |c: &&Candidate| current.fitted.shape.effects.iter().all(|e| e.spec.id != c.spec.id);
        let mut candidates: Vec<Candidate> = library.iter().filter(named).cloned().collect();
        if let Some(before) = rounds.last() {
            candidates.iter_mut().for_each(|candidate| start_from(candidate, before));
        }
        if candidates.is_empty() {
            break;
        }
        let round = try_all(current, &candidates, progress);
        let next = carry_on(case, &clutter, current, &candidates, &round);
        let round = if rounds.is_empty() { round } else { round.lighter() };
        rounds.push(round);
        let Some(next) = next else { break };
        let gain = current.evidence_cost() - next.evidence_cost();
        let predictive = current.fitted.predictive_cost() - next.fitted.predictive_cost();
        let so_far = (base.evidence_cost() - current.evidence_cost()).max(0.0);
        let least = acceptance.gain.max(refinement_share(&next) * so_far);
        let predicts = predictive >= acceptance.predictive || gain > CERTAIN || next.level != current.level;
        if gain < least || !predicts {
            break;
        }
        best = Some(next);
    }
    let best = match best {
        Some(best) => delete_backwards(case, &clutter, acceptance, best),
        None => search::settle(case, &shape, &clutter, &base.fitted.fit.theta, base.level),
    };
    Found { base, best, rounds }
}

/// An effect whose law has another form than the plant's leaves a rest that a neighbour can mend: the last effect must
/// gain this share of what the ones before it gained, more if it stands at the same place of the equations.
fn refinement_share(level: &Level) -> f64 {
    let effects = &level.fitted.shape.effects;
    let Some((last, before)) = effects.split_last() else { return 0.0 };
    match before.iter().any(|e| e.spec.term == last.spec.term) {
        true => 0.15,
        false if before.is_empty() => 0.0,
        false => 0.04,
    }
}

/// Later rounds start from where a candidate ended before, and from its first start.
fn start_from(candidate: &mut Candidate, before: &Round) {
    let ended = before.gains.iter().find(|gain| gain.id == candidate.spec.id);
    let Some((effect, values)) = ended.and_then(Gain::own) else { return };
    let mut effect = effect.clone();
    for (parameter, value) in effect.parameters.iter_mut().zip(values) {
        parameter.start = value;
    }
    candidate.starts.truncate(1);
    candidate.starts.push(effect);
}

fn try_all(current: &Level, candidates: &[Candidate], progress: &(dyn Fn(&'static str) + Sync)) -> Round {
    let fits = search::fit_all(&current.whitening, &current.fitted, candidates, progress);
    let gains = candidates.iter().zip(fits).map(|(candidate, fitted)| {
        let by_run: Vec<f64> = current
            .fitted
            .left_out
            .iter()
            .zip(&fitted.left_out)
            .map(|(before, after)| before - after)
            .collect();
        Gain {
            id: candidate.spec.id,
            gain: current.fitted.fit.total() - fitted.fit.total(),
            predictive: by_run.iter().sum(),
            by_run,
            converged: fitted.fit.converged,
            fitted,
        }
    });
    Round { gains: gains.collect() }
}

/// Gives the best candidates of a round filters frozen at themselves, and returns the most likely one.
fn carry_on<'a>(
    case: &'a Case,
    clutter: &Clutter,
    current: &Level,
    candidates: &[Candidate],
    round: &Round,
) -> Option<Level<'a>> {
    let mut order: Vec<&Gain> = round.gains.iter().collect();
    order.sort_by(|a, b| b.score().total_cmp(&a.score()));
    let best = order.first()?;
    // A tolerant filter separates candidates less sharply than the one it leads to.
    let share = if current.level > 0 { 0.5 } else { 0.85 };
    let worth = |g: &&&Gain| g.gain > 5.0 && g.score() > share * best.score();
    let finalists: Vec<&Gain> = order.iter().filter(worth).take(FINALISTS).copied().collect();
    let settle =
        |g: &&Gain| search::settle(case, &g.fitted.shape, clutter, &g.fitted.fit.theta, current.level);
    let mut settled: Vec<Level<'a>> = finalists.par_iter().map(settle).collect();
    if current.level >= GROSS {
        let strict = search::strict_trials(case, &current.fitted, clutter, candidates, STRICT_FINALISTS);
        let settle = |(shape, theta): &(Shape, Vec<f64>)| {
            search::settle_upwards(case, shape, clutter, theta, current.level)
        };
        settled.extend(strict.par_iter().map(settle).collect::<Vec<_>>());
    }
    settled.into_iter().min_by(|a, b| a.evidence_cost().total_cmp(&b.evidence_cost()))
}

/// Drops effects that the others have made superfluous.
fn delete_backwards<'a>(
    case: &'a Case,
    clutter: &Clutter,
    acceptance: Acceptance,
    best: Level<'a>,
) -> Level<'a> {
    let mut best = best;
    while best.fitted.shape.effects.len() > 1 {
        let effects = &best.fitted.shape.effects;
        let reduced: Vec<Level<'a>> = (0..effects.len())
            .into_par_iter()
            .map(|drop| {
                let keep: Vec<FittedEffect> = without_one(effects, drop);
                let theta = without_range(&best.fitted.fit.theta, best.fitted.shape.range_of(drop));
                search::settle(case, &best.fitted.shape.with_all(&keep), clutter, &theta, best.level)
            })
            .collect();
        let cheapest = reduced.into_iter().min_by(|a, b| a.evidence_cost().total_cmp(&b.evidence_cost()));
        match cheapest {
            Some(smaller) if smaller.evidence_cost() < best.evidence_cost() + acceptance.gain => {
                best = smaller
            }
            _ => break,
        }
    }
    best
}

fn without_one(effects: &[FittedEffect], drop: usize) -> Vec<FittedEffect> {
    effects.iter().enumerate().filter(|(i, _)| *i != drop).map(|(_, e)| e.clone()).collect()
}

fn without_range(theta: &[f64], range: std::ops::Range<usize>) -> Vec<f64> {
    theta.iter().enumerate().filter(|(i, _)| !range.contains(i)).map(|(_, t)| *t).collect()
}
