//! One round of the selection: every candidate on top of the model so far, and the best of them with filters of their own.

use crate::data::align::Alignments;
use crate::data::case::Case;
use crate::decide::criteria::Criteria;
use crate::decide::mending::{Relation, relation};
use crate::fit::aligned;
use crate::fit::candidate::{self, Fitted};
use crate::fit::frozen::{self, FrozenFit};
use crate::fit::linearisation::Linearisation;
use crate::fit::objective::Objective;
use crate::model::candidates::Candidate;
use crate::model::parameters::{FittedEffect, Shape};
use crate::model::places;
use crate::predict::disturbances::DisturbanceModel;
use crate::predict::localise::{self, PlaceEvidence};
use railgrip_vehicle::effects::Term;
use rayon::prelude::*;

/// What one round tried on top of the model before it.
#[derive(Debug)]
pub struct Round {
    /// Log-likelihood gained by each candidate over the round's base, in the order of the library.
    pub gains: Vec<Gain>,
    /// Evidence that those carried to a filter of their own gained over the round's base.
    pub own_filter_gains: Vec<(&'static str, f64)>,
}

impl Round {
    /// How a candidate did, if it was tried.
    pub fn of(&self, id: &str) -> Option<&Gain> {
        self.gains.iter().find(|gain| gain.id == id)
    }

    /// Evidence that a candidate gained with a filter of its own, if it was carried so far.
    pub fn own_filter_gain(&self, id: &str) -> Option<f64> {
        let own = self.own_filter_gains.iter().filter(|(carried, _)| *carried == id);
        own.map(|(_, gain)| *gain).max_by(f64::total_cmp)
    }

    /// Without the large tables that only the test against chance needs.
    pub(crate) fn lighter(mut self) -> Self {
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
    /// What candidates are ranked by, see [`candidate::score`].
    pub score: f64,
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

    /// The candidate's effect, to be fitted again from where it ended.
    fn led(&self) -> Option<FittedEffect> {
        let (effect, values) = self.own()?;
        let mut effect = effect.clone();
        effect.parameters.iter_mut().zip(values).for_each(|(parameter, value)| parameter.start = value);
        Some(effect)
    }

    /// The term of the candidate's effect.
    fn term(&self) -> Option<Term> {
        self.own().map(|(effect, _)| effect.spec.term)
    }
}

/// Later rounds start from where a candidate ended before, and from its first start; a stretch of track, which another effect
/// may have drawn to a wrong place before, from all of them.
pub(crate) fn start_from(candidate: &mut Candidate, before: &Round) {
    let ended = before.of(candidate.spec.id);
    let Some(effect) = ended.and_then(Gain::led) else { return };
    if !candidate.is_stretch() {
        candidate.starts.truncate(1);
    }
    candidate.starts.push(effect);
}

/// Fits every candidate on top of `current` with its filter.
pub(crate) fn try_all(
    current: &FrozenFit,
    candidates: &[Candidate],
    criteria: &Criteria,
    progress: &(dyn Fn(&'static str) + Sync),
) -> Round {
    let around;
    let objective: &dyn Objective = if current.whitening.is_tolerant() {
        around = Linearisation::new(&current.whitening, &current.fitted);
        &around
    } else {
        &current.whitening
    };
    let fits = candidate::fit_all(objective, &current.fitted, candidates, &criteria.pursuit, progress);
    let gains = candidates.iter().zip(fits).map(|(candidate, fitted)| {
        let by_run = fitted.gains_left_out(&current.fitted);
        let gain = current.fitted.fit.total() - fitted.fit.total();
        let predictive = by_run.iter().sum();
        Gain {
            id: candidate.spec.id,
            gain,
            predictive,
            by_run,
            score: candidate::score(gain, predictive, &criteria.pursuit),
            converged: fitted.fit.converged,
            fitted,
        }
    });
    Round { gains: gains.collect(), own_filter_gains: Vec::new() }
}

/// What a round stands on: the model so far, what freeing places gains over it, and what each of its effects gained.
pub(crate) struct Standpoint<'b, 'a> {
    /// The model so far.
    pub current: &'b FrozenFit<'a>,
    /// What freeing places gains over it.
    pub rest: &'b [PlaceEvidence],
    /// Evidence that each of its effects gained when it was accepted.
    pub accepted: &'b [f64],
}

impl Standpoint<'_, '_> {
    /// How the last effect of `next` relates to those before it; `None` without an effect.
    pub(crate) fn relation(&self, next: &FrozenFit, criteria: &Criteria) -> Option<Relation> {
        let (last, before) = next.fitted.shape.effects.split_last()?;
        let gain = self.current.evidence_cost() - next.evidence_cost();
        let before: Vec<(Term, f64)> =
            before.iter().zip(self.accepted).map(|(effect, gained)| (effect.spec.term, *gained)).collect();
        Some(relation(last.spec.term, gain, &before, &criteria.acceptance))
    }
}

/// Gives the best candidates of a round filters frozen at themselves, and returns them, the most likely one first, with what
/// each gained.
pub(crate) fn refit_finalists<'a>(
    (original, alignments): (&'a Case, &'a Alignments),
    disturbances: &DisturbanceModel,
    at: &Standpoint<'_, 'a>,
    candidates: &[Candidate],
    round: &Round,
    criteria: &Criteria,
) -> (Vec<FrozenFit<'a>>, Vec<(&'static str, f64)>) {
    let (current, pursuit) = (at.current, &criteria.pursuit);
    let case = current.case;
    let finalists = finalists(at, round, criteria);
    let refit = |g: &&Gain| {
        frozen::freeze(case, &g.fitted.shape, disturbances, &g.fitted.fit.theta, current.tolerance)
    };
    let mut refitted: Vec<FrozenFit<'a>> = finalists.par_iter().map(refit).collect();
    if current.tolerance >= pursuit.gross_tolerance {
        let led: Vec<Option<FittedEffect>> = round.gains.iter().map(Gain::led).collect();
        // What is late is hidden from all other fits: the best of its kind is always looked at.
        let late = |shape: &Shape, theta: &[f64]| aligned::is_late(case, shape, theta);
        let count = pursuit.strict_finalists;
        let standing = (&current.fitted.shape, &current.fitted.fit.theta[..]);
        let strict = frozen::open_loop_trials(case, standing, candidates, &led, count, &late);
        // No filter can follow a late sensor: the recordings are put right for it instead.
        let refit = |(_, shape, theta): &(usize, Shape, Vec<f64>)| {
            aligned::freeze(original, alignments, shape, disturbances, theta, current.tolerance)
                .unwrap_or_else(|| {
                    frozen::freeze_upwards(case, shape, disturbances, theta, current.tolerance)
                })
        };
        refitted.extend(strict.par_iter().map(refit).collect::<Vec<_>>());
    }
    let gained = |frozen: &FrozenFit| {
        let last = frozen.fitted.shape.effects.last()?;
        Some((last.spec.id, current.evidence_cost() - frozen.evidence_cost()))
    };
    let gains: Vec<(&str, f64)> = refitted.iter().filter_map(gained).collect();
    let at_likely = refitted.iter().filter(|frozen| !stands_back(at, frozen, criteria));
    let most = at_likely.map(|frozen| current.evidence_cost() - frozen.evidence_cost()).fold(0.0, f64::max);
    let factor = if current.fitted.shape.effects.is_empty() {
        criteria.acceptance.first_outweighing_factor
    } else {
        criteria.acceptance.outweighing_factor
    };
    let outweighs = |frozen: &FrozenFit| {
        let gain = current.evidence_cost() - frozen.evidence_cost();
        gain > factor * most && is_apart(at, frozen, criteria)
    };
    let stands_back = |frozen: &FrozenFit| stands_back(at, frozen, criteria) && !outweighs(frozen);
    let cost = |frozen: &FrozenFit| cost(current, frozen, criteria);
    let first =
        |a: &FrozenFit, b: &FrozenFit| stands_back(a).cmp(&stands_back(b)).then(cost(a).total_cmp(&cost(b)));
    refitted.sort_by(first);
    (refitted, gains)
}

/// The candidates that get filters of their own.
fn finalists<'r>(at: &Standpoint, round: &'r Round, criteria: &Criteria) -> Vec<&'r Gain> {
    let pursuit = &criteria.pursuit;
    let mut order: Vec<&Gain> = round.gains.iter().collect();
    order.sort_by(|a, b| b.score.total_cmp(&a.score));
    let Some(best) = order.first() else { return Vec::new() };
    let share =
        if at.current.tolerance > 0 { pursuit.tolerant_finalist_share } else { pursuit.finalist_share };
    let promising = |g: &&&Gain| g.gain > pursuit.finalist_gain && g.score > share * best.score;
    let mut finalists: Vec<&Gain> = order.iter().filter(promising).take(pursuit.finalists).copied().collect();
    // What is left of an effect whose form is not quite right may hide a smaller one where the model errs most now.
    let likely = localise::likely(at.rest, criteria.localisation.likely_share);
    let errs_there = |g: &Gain| g.term().is_some_and(|term| localise::may_act_at(term, likely));
    let hidden = |g: &&&Gain| g.gain > pursuit.finalist_gain && !shares_place(at.current, g) && errs_there(g);
    let elsewhere = order.iter().find(hidden).copied();
    if let Some(other) = elsewhere
        && finalists.iter().all(|g| shares_place(at.current, g))
    {
        finalists.push(other);
    }
    finalists
}

/// Whether a candidate shows at a place at which an effect of the model does already.
fn shares_place(current: &FrozenFit, candidate: &Gain) -> bool {
    let Some(term) = candidate.term() else { return true };
    current.fitted.shape.effects.iter().any(|e| places::may_share(e.spec.term, term))
}

/// Whether a finalist stands back behind others: it only mends an effect before it, or lies where the model errs little.
fn stands_back(at: &Standpoint, frozen: &FrozenFit, criteria: &Criteria) -> bool {
    let Some(last) = frozen.fitted.shape.effects.last() else { return false };
    match at.relation(frozen, criteria) {
        Some(Relation::Mends) => true,
        Some(Relation::Apart) => {
            let likely = localise::likely(at.rest, criteria.localisation.likely_share);
            !localise::may_act_at(last.spec.term, likely)
        }
        Some(Relation::Beside) | None => false,
    }
}

/// Whether a finalist shows at no place at which an effect of the model does.
fn is_apart(at: &Standpoint, frozen: &FrozenFit, criteria: &Criteria) -> bool {
    at.relation(frozen, criteria) == Some(Relation::Apart)
}

/// Cost by which finalists are compared: a law with more to adjust must earn it, and a further one whose strength runs into
/// its bound imitates something else.
fn cost(current: &FrozenFit, frozen: &FrozenFit, criteria: &Criteria) -> f64 {
    let acceptance = &criteria.acceptance;
    let effects = &frozen.fitted.shape.effects;
    let last = effects.len().saturating_sub(1);
    let adjusted = effects.last().map_or(0, FittedEffect::own_parameters);
    let imitates = last > 0 && frozen.fitted.is_on_bound(last, acceptance);
    let gain = (current.evidence_cost() - frozen.evidence_cost()).max(0.0);
    frozen.evidence_cost()
        + acceptance.per_parameter * adjusted as f64
        + if imitates { acceptance.on_bound_share * gain } else { 0.0 }
}
