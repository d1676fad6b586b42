//! The selection: calibrate, try every candidate, accept the best, try again on top of it, delete what is not needed.

use crate::data::case::Case;
use crate::fit::candidate::{self, Fitted};
use crate::fit::frozen::{self, FrozenFit, GROSS};
use crate::model::candidates::{self, Candidate};
use crate::model::parameters::{FittedEffect, Shape};
use crate::predict::localise::{self, PlaceEvidence};
use crate::predict::one_step::{DisturbanceModel, TOLERANCES};
use rayon::prelude::*;

/// Most effects that are named together.
const MOST_EFFECTS: usize = 3;
/// Gain of log-likelihood that needs no confirmation by left-out runs: an effect may show in a single run.
const CERTAIN: f64 = 200.0;
/// Candidates of a round that are carried to their own best filter.
const FINALISTS: usize = 3;

/// Of these tries, how many are carried to their own best filter.
const STRICT_FINALISTS: usize = 3;

/// What one round tried on top of the model before it.
#[derive(Debug)]
pub struct Round {
    /// Log-likelihood gained by each candidate over the round's base, in the order of the library.
    pub gains: Vec<Gain>,
    /// Evidence that those carried to a filter of their own gained over the round's base.
    pub own_filter_gains: Vec<(&'static str, f64)>,
}

impl Round {
    /// Evidence that a candidate gained with a filter of its own, if it was carried so far.
    pub fn own_filter_gain(&self, id: &str) -> Option<f64> {
        let own = self.own_filter_gains.iter().filter(|(settled, _)| *settled == id);
        own.map(|(_, gain)| *gain).max_by(f64::total_cmp)
    }

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

/// The outcome of the selection.
#[derive(Debug)]
pub struct Selection<'a> {
    /// Nuisances alone.
    pub base: FrozenFit<'a>,
    /// Nuisances and accepted effects, with a filter frozen at them.
    pub best: FrozenFit<'a>,
    /// Rounds of forward selection.
    pub rounds: Vec<Round>,
    /// What freeing each place gains over the base, most first.
    pub places: Vec<PlaceEvidence>,
    /// The same over the best model.
    pub rest: Vec<PlaceEvidence>,
    /// Evidence that the best model loses without each of its effects, if it has several.
    pub lost_without: Vec<f64>,
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

/// Fits the nuisances alone, from the filter that tolerates most errors of the model.
pub fn calibrate(case: &Case) -> FrozenFit<'_> {
    let shape = Shape::nominal(case);
    frozen::freeze(case, &shape, &DisturbanceModel::default(), &shape.start(), TOLERANCES.len() - 1)
}

/// Frees each place of the equations on top of a frozen fit.
pub fn localise(case: &Case, frozen: &FrozenFit) -> Vec<PlaceEvidence> {
    free_places(case, &DisturbanceModel::default(), frozen)
}

/// Selects effects on top of the calibrated model `base`, with what freeing places gains over it, from the library (without the ids of `without`).
pub fn select<'a>(
    case: &'a Case,
    base: FrozenFit<'a>,
    places: Vec<PlaceEvidence>,
    without: &[String],
    acceptance: Acceptance,
    progress: &(dyn Fn(&'static str) + Sync),
) -> Selection<'a> {
    let disturbances = DisturbanceModel::default();
    let library = candidates::all(case, without);
    let (mut base, mut places) = (base, places);
    let mut best: Option<(FrozenFit<'a>, Vec<PlaceEvidence>)> = None;
    let mut rounds: Vec<Round> = Vec::new();
    let mut accepted: Vec<f64> = Vec::new();
    let mut restarts = 0;
    while accepted.len() < MOST_EFFECTS {
        let (current, rest) = best.as_ref().map_or((&base, &places), |(frozen, rest)| (frozen, rest));
        // Every candidate is tried once; on top of a model that leaves nothing there is nothing to try.
        if !rounds.is_empty() && (is_quiet(current, rest) || is_hopeless(current, &places, rest)) {
            break;
        }
        let named = |c: &&Candidate| current.fitted.shape.effects.iter().all(|e| e.spec.id != c.spec.id);
        let mut candidates: Vec<Candidate> = library.iter().filter(named).cloned().collect();
        if let Some(before) = rounds.last() {
            candidates.iter_mut().for_each(|candidate| start_from(candidate, before));
        }
        if candidates.is_empty() {
            break;
        }
        let mut round = try_all(current, &candidates, progress);
        let (next, settled) =
            refit_finalists(case, &disturbances, current, &candidates, &round, rest, &accepted);
        round.own_filter_gains = settled;
        // What looks like a small effect may be a base that another start would have fitted better.
        if restarts < MOST_RESTARTS
            && let Some(better) =
                next.as_ref().and_then(|next| better_start(case, &disturbances, current, next))
        {
            restarts += 1;
            let rest = free_places(case, &disturbances, &better);
            match &mut best {
                Some(best) => *best = (better, rest),
                None => (base, places) = (better, rest),
            }
            continue;
        }
        let eventful = next.as_ref().is_some_and(|next| is_an_event(current, next, &round, acceptance));
        rounds.push(if rounds.is_empty() { round } else { round.lighter() });
        let Some(next) = next.filter(|_| !eventful) else { break };
        let gain = current.evidence_cost() - next.evidence_cost();
        let predictive = current.fitted.predictive_cost() - next.fitted.predictive_cost();
        let predicts =
            predictive >= acceptance.predictive || gain > CERTAIN || next.tolerance != current.tolerance;
        if gain < acceptance.gain || !predicts || !is_new(&next, rest, &accepted, gain, predictive) {
            break;
        }
        accepted.push(gain);
        let rest = free_places(case, &disturbances, &next);
        best = Some((next, rest));
    }
    let (best, rest, lost_without) = match best {
        Some((best, rest)) => {
            let number = best.fitted.shape.effects.len();
            let (best, lost_without) = delete_backwards(case, &disturbances, acceptance, best);
            let same = best.fitted.shape.effects.len() == number;
            let rest = if same { rest } else { free_places(case, &disturbances, &best) };
            (best, rest, lost_without)
        }
        None => {
            let best = frozen::freeze(
                case,
                &base.fitted.shape,
                &disturbances,
                &base.fitted.fit.theta,
                base.tolerance,
            );
            (best, places.clone(), Vec::new())
        }
    };
    Selection { base, best, rounds, places, rest, lost_without }
}

fn free_places(case: &Case, disturbances: &DisturbanceModel, frozen: &FrozenFit) -> Vec<PlaceEvidence> {
    localise::localise(case, &frozen.fitted.shape.build(&frozen.fitted.fit.theta), disturbances)
}

/// What freeing any place may gain where nothing is left to explain.
const QUIET: f64 = 25.0;

/// Innovations that are white cost half a unit each; how far above that they may lie where nothing is left to explain.
const WHITE: f64 = 1.03;

/// Whether a model leaves nothing to explain. Freed places alone do not tell: beside a late or smoothed sensor, which
/// unsettles a filter that trusts it, they may gain nothing although much is left.
pub(crate) fn is_quiet(frozen: &FrozenFit, rest: &[PlaceEvidence]) -> bool {
    let expected = 0.5 * frozen.fitted.residuals.len() as f64;
    let white = frozen.fitted.fit.cost < WHITE * expected;
    frozen.tolerance == 0 && white && rest.first().is_none_or(|w| w.evidence < QUIET)
}

/// Whether named effects leave most of a gross misfit, at their own place or more than there was: then what is wrong is
/// something else, and further names would only decorate it.
fn is_hopeless(frozen: &FrozenFit, before: &[PlaceEvidence], rest: &[PlaceEvidence]) -> bool {
    let left = localise::share_left(before, rest);
    let effects = &frozen.fitted.shape.effects;
    let same = effects.iter().any(|e| localise::may_act_at(e.spec.term, localise::likely(rest)));
    frozen.tolerance >= GROSS && (left > 1.0 || (left > localise::MOST && same))
}

/// Least gain of a further effect, as a share of what effects at the same place gained before it.
const REFINEMENT: f64 = 0.2;
/// The same for effects elsewhere, as a share of all that was gained before; and where the likeliest place says so too.
const ELSEWHERE: f64 = 0.006;
const ELSEWHERE_IN_PLACE: f64 = 0.002;
/// Least gain of a further effect elsewhere that the likeliest place does not speak for.
const FURTHER: f64 = 100.0;
/// Least gain of effects elsewhere on left-out runs, as a share of their gain on all runs.
const ELSEWHERE_PREDICTS: f64 = 0.3;

/// Whether the last effect of `next` is one more effect. A law of another form than the plant's leaves a rest that a
/// neighbour can mend: at the same place of the equations an effect must gain a good share of what those before it gained;
/// elsewhere little is enough if runs left out agree, or if that is where the model before errs most, as `rest` says. The
/// first effect, too, must be one or the other; a further one whose strength runs into its bound only mends something else.
fn is_new(next: &FrozenFit, rest: &[PlaceEvidence], accepted: &[f64], gain: f64, predictive: f64) -> bool {
    let Some((last, before)) = next.fitted.shape.effects.split_last() else { return false };
    if !before.is_empty() && is_on_bound(&next.fitted, before.len()) {
        return false;
    }
    let there = |(e, _): &(&FittedEffect, &f64)| localise::may_share_place(e.spec.term, last.spec.term);
    let same_place: f64 = before.iter().zip(accepted).filter(there).map(|(_, gain)| gain).sum();
    let all: f64 = accepted.iter().sum();
    if same_place > 0.0 {
        return gain >= (REFINEMENT * same_place).max(ELSEWHERE_IN_PLACE * all);
    }
    let in_place = localise::may_act_at(last.spec.term, localise::likely(rest));
    let least = if before.is_empty() { 0.0 } else { (ELSEWHERE * all).max(FURTHER) };
    (gain >= ELSEWHERE_IN_PLACE * all && in_place)
        || (gain >= least && predictive >= ELSEWHERE_PREDICTS * gain)
}

/// The model before `next` fitted again from where `next` ended, if that is better: one that gained little may have only
/// led the nuisances out of a side valley.
fn better_start<'a>(
    case: &'a Case,
    disturbances: &DisturbanceModel,
    current: &FrozenFit<'a>,
    next: &FrozenFit<'a>,
) -> Option<FrozenFit<'a>> {
    let gain = current.evidence_cost() - next.evidence_cost();
    let last = next.fitted.shape.effects.len().checked_sub(1)?;
    if gain > DOUBTED || next.tolerance != current.tolerance {
        return None;
    }
    let start = without_range(&next.fitted.fit.theta, next.fitted.shape.range_of(last));
    let again = frozen::freeze(case, &current.fitted.shape, disturbances, &start, current.tolerance);
    (again.evidence_cost() < current.evidence_cost() - BETTER_START).then_some(again)
}

/// Gain up to which an effect is doubted so.
const DOUBTED: f64 = 600.0;
/// By how much the model before it must be better to count as better.
const BETTER_START: f64 = 5.0;
/// How often the selection may begin again.
const MOST_RESTARTS: usize = 2;

/// Whether what the last effect of `next` gains is next to nothing outside of a few stretches, by the filter that both
/// share: a wheelset at the edge between holding and sliding that falls the other way once is no effect.
fn is_an_event(current: &FrozenFit, next: &FrozenFit, round: &Round, acceptance: Acceptance) -> bool {
    let gain = current.evidence_cost() - next.evidence_cost();
    let last = next.fitted.shape.effects.last().map_or("", |effect| effect.spec.id);
    let own = round.gains.iter().find(|gain| gain.id == last);
    if gain > CERTAIN || next.tolerance != current.tolerance {
        return false;
    }
    own.is_none_or(|own| {
        let stretches = |fitted: &Fitted| frozen::costs_of_stretches(&fitted.residuals);
        let lasting = localise::evidence(&stretches(&current.fitted), &stretches(&own.fitted));
        own.gain < acceptance.gain || lasting < LASTING * acceptance.gain
    })
}

/// Least gain of a small effect outside of the few stretches in which it gains most, relative to the least gain at all.
const LASTING: f64 = 0.3;

/// Whether the strength of an effect sits on a bound that is not its neutral value.
pub(crate) fn is_on_bound(fitted: &Fitted, effect: usize) -> bool {
    let Some(own) = fitted.shape.effects.get(effect) else { return false };
    let values = &fitted.fit.theta[fitted.shape.range_of(effect)];
    own.parameters.iter().zip(values).any(|(p, v)| {
        let neutral = own.spec.parameters.iter().find(|s| s.name == p.name).and_then(|s| s.neutral);
        let near = |bound: f64| (v - bound).abs() < 1e-6 * (p.upper - p.lower);
        neutral.is_some_and(|n| (near(p.lower) && n != p.lower) || (near(p.upper) && n != p.upper))
    })
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

fn try_all(current: &FrozenFit, candidates: &[Candidate], progress: &(dyn Fn(&'static str) + Sync)) -> Round {
    let fits = candidate::fit_all(&current.whitening, &current.fitted, candidates, progress);
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
    Round { gains: gains.collect(), own_filter_gains: Vec::new() }
}

/// Gives the best candidates of a round filters frozen at themselves, and returns the most likely one, with what each
/// gained.
fn refit_finalists<'a>(
    case: &'a Case,
    disturbances: &DisturbanceModel,
    current: &FrozenFit,
    candidates: &[Candidate],
    round: &Round,
    rest: &[PlaceEvidence],
    accepted: &[f64],
) -> (Option<FrozenFit<'a>>, Vec<(&'static str, f64)>) {
    let mut order: Vec<&Gain> = round.gains.iter().collect();
    order.sort_by(|a, b| b.score().total_cmp(&a.score()));
    let Some(best) = order.first() else { return (None, Vec::new()) };
    // A tolerant filter separates candidates less sharply than the one it leads to.
    let share = if current.tolerance > 0 { 0.5 } else { 0.85 };
    let promising = |g: &&&Gain| g.gain > 5.0 && g.score() > share * best.score();
    let likely = localise::likely(rest);
    let errs_there =
        |g: &Gain| g.own().is_some_and(|(effect, _)| localise::may_act_at(effect.spec.term, likely));
    let mut finalists: Vec<&Gain> = order.iter().filter(promising).take(FINALISTS).copied().collect();
    // What is left of an effect whose form is not quite right may hide a smaller one where the model errs most now.
    let hidden = |g: &&&Gain| g.gain > 5.0 && !shares_place(current, g) && errs_there(g);
    let elsewhere = order.iter().find(hidden).copied();
    if let Some(other) = elsewhere
        && finalists.iter().all(|g| shares_place(current, g))
    {
        finalists.push(other);
    }
    let settle = |g: &&Gain| {
        frozen::freeze(case, &g.fitted.shape, disturbances, &g.fitted.fit.theta, current.tolerance)
    };
    let mut settled: Vec<FrozenFit<'a>> = finalists.par_iter().map(settle).collect();
    if current.tolerance >= GROSS {
        let strict = frozen::strict_trials(case, &current.fitted, disturbances, candidates, STRICT_FINALISTS);
        let settle = |(_, shape, theta): &(usize, Shape, Vec<f64>)| {
            frozen::freeze_upwards(case, shape, disturbances, theta, current.tolerance)
        };
        settled.extend(strict.par_iter().map(settle).collect::<Vec<_>>());
    }
    let gained = |frozen: &FrozenFit| {
        let last = frozen.fitted.shape.effects.last()?;
        Some((last.spec.id, current.evidence_cost() - frozen.evidence_cost()))
    };
    let gains: Vec<(&str, f64)> = settled.iter().filter_map(gained).collect();
    // Mends an effect before it, or lies where the model errs little.
    let mends = |frozen: &FrozenFit| {
        let Some((last, before)) = frozen.fitted.shape.effects.split_last() else { return false };
        let gain = current.evidence_cost() - frozen.evidence_cost();
        let same = before.iter().any(|e| localise::may_share_place(e.spec.term, last.spec.term));
        let there = localise::may_act_at(last.spec.term, likely);
        if same { gain < REFINEMENT * accepted.iter().sum::<f64>() } else { !there }
    };
    // A law with more to adjust must earn it, and one whose strength runs into its bound imitates something else.
    let cost = |frozen: &FrozenFit| {
        let effects = &frozen.fitted.shape.effects;
        let last = effects.len().saturating_sub(1);
        let adjusted = effects.last().map_or(0, |effect| effect.parameters.len());
        let imitates = last > 0 && is_on_bound(&frozen.fitted, last);
        let gain = (current.evidence_cost() - frozen.evidence_cost()).max(0.0);
        frozen.evidence_cost()
            + PER_PARAMETER * adjusted as f64
            + if imitates { IMITATION * gain } else { 0.0 }
    };
    let first = |a: &FrozenFit, b: &FrozenFit| mends(a).cmp(&mends(b)).then(cost(a).total_cmp(&cost(b)));
    (settled.into_iter().min_by(first), gains)
}

/// Whether a candidate shows at a place at which an effect of the model does already.
fn shares_place(current: &FrozenFit, candidate: &Gain) -> bool {
    let Some((effect, _)) = candidate.own() else { return true };
    current.fitted.shape.effects.iter().any(|e| localise::may_share_place(e.spec.term, effect.spec.term))
}

/// Evidence that each parameter of an effect must earn, about half the logarithm of the number of samples.
const PER_PARAMETER: f64 = 5.0;
/// Share of its gain by which a further effect on its bound must lead.
const IMITATION: f64 = 0.1;

/// Drops effects that the others have made superfluous; returns the model and what it would lose without each of several.
fn delete_backwards<'a>(
    case: &'a Case,
    disturbances: &DisturbanceModel,
    acceptance: Acceptance,
    best: FrozenFit<'a>,
) -> (FrozenFit<'a>, Vec<f64>) {
    let mut best = best;
    while best.fitted.shape.effects.len() > 1 {
        let effects = &best.fitted.shape.effects;
        let reduced: Vec<FrozenFit<'a>> = (0..effects.len())
            .into_par_iter()
            .map(|drop| {
                let keep: Vec<FittedEffect> = without_one(effects, drop);
                let theta = without_range(&best.fitted.fit.theta, best.fitted.shape.range_of(drop));
                frozen::freeze(case, &best.fitted.shape.with_all(&keep), disturbances, &theta, best.tolerance)
            })
            .collect();
        let lost_without = reduced.iter().map(|r| r.evidence_cost() - best.evidence_cost()).collect();
        let cheapest = reduced.into_iter().min_by(|a, b| a.evidence_cost().total_cmp(&b.evidence_cost()));
        match cheapest {
            Some(smaller) if smaller.evidence_cost() < best.evidence_cost() + acceptance.gain => {
                best = smaller
            }
            _ => return (best, lost_without),
        }
    }
    (best, Vec::new())
}

fn without_one(effects: &[FittedEffect], drop: usize) -> Vec<FittedEffect> {
    effects.iter().enumerate().filter(|(i, _)| *i != drop).map(|(_, e)| e.clone()).collect()
}

fn without_range(theta: &[f64], range: std::ops::Range<usize>) -> Vec<f64> {
    theta.iter().enumerate().filter(|(i, _)| !range.contains(i)).map(|(_, t)| *t).collect()
}
