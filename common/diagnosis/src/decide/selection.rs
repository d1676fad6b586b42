//! The selection: try every candidate on the calibrated model, accept the best, try again on top of it, delete what is not
//! needed.

use crate::data::align::Alignments;
use crate::data::case::Case;
use crate::decide::acceptance::{Stop, is_hopeless, is_quiet, why_not};
use crate::decide::criteria::Criteria;
use crate::decide::round::{Round, Standpoint, refit_finalists, start_from, try_all};
use crate::fit::aligned;
use crate::fit::frozen::{self, FrozenFit};
use crate::model::candidates::{self, Candidate};
use crate::model::parameters::{FittedEffect, Shape};
use crate::predict::disturbances::{DisturbanceModel, TOLERANCES};
use crate::predict::localise::{self, PlaceEvidence, Stretches};
use rayon::prelude::*;

/// The outcome of the selection.
#[derive(Debug)]
pub struct Selection<'a> {
    /// Nuisances alone.
    pub base: FrozenFit<'a>,
    /// Nuisances and accepted effects, with a filter frozen at them.
    pub best: FrozenFit<'a>,
    /// Rounds of forward selection.
    pub rounds: Vec<Round>,
    /// Why it stopped.
    pub stop: Stop,
    /// What freeing each place gains over the base, most first.
    pub places: Vec<PlaceEvidence>,
    /// The same over the best model.
    pub rest: Vec<PlaceEvidence>,
    /// Evidence that the best model loses without each of its effects, if it has several.
    pub lost_without: Vec<f64>,
}

/// Fits the nuisances alone, from the filter that tolerates most errors of the model.
pub fn calibrate(case: &Case) -> FrozenFit<'_> {
    let shape = Shape::nominal(case);
    frozen::freeze(case, &shape, &DisturbanceModel::default(), &shape.start(), TOLERANCES.len() - 1)
}

/// Frees each place of the equations on top of a frozen fit; the likeliest first.
pub fn localise(frozen: &FrozenFit, criteria: &Criteria) -> Vec<PlaceEvidence> {
    let built = frozen.fitted.shape.build(&frozen.fitted.fit.theta);
    let stretches = Stretches {
        length_s: criteria.significance.stretch_s,
        event_share: criteria.localisation.event_share,
    };
    localise::localise(frozen.case, &built, &DisturbanceModel::default(), stretches)
}

/// Selects effects on top of the calibrated model `base`, over which freeing places gains `places`, from the library
/// (without the ids of `without`).
pub fn select<'a>(
    (case, alignments): (&'a Case, &'a Alignments),
    base: FrozenFit<'a>,
    places: Vec<PlaceEvidence>,
    without: &[String],
    criteria: &Criteria,
    progress: &(dyn Fn(&'static str) + Sync),
) -> Selection<'a> {
    let disturbances = DisturbanceModel::default();
    let library = candidates::all(case, without);
    let (mut base, mut places) = (base, places);
    let mut best: Option<(FrozenFit<'a>, Vec<PlaceEvidence>)> = None;
    let mut rounds: Vec<Round> = Vec::new();
    let mut accepted: Vec<f64> = Vec::new();
    let mut restarts = 0;
    let stop = loop {
        if accepted.len() == criteria.acceptance.most_effects {
            break Stop::EnoughEffects;
        }
        let (current, rest) = best.as_ref().map_or((&base, &places), |(frozen, rest)| (frozen, rest));
        // Every candidate is tried once; on top of a model that leaves nothing there is nothing to try.
        if !rounds.is_empty() && is_quiet(current, rest, &criteria.localisation) {
            break Stop::Quiet;
        }
        if !rounds.is_empty() && is_hopeless(current, &places, rest, criteria) {
            break Stop::Hopeless;
        }
        let candidates = remaining(&library, current, rounds.last());
        if candidates.is_empty() {
            break Stop::NoCandidate;
        }
        let at = Standpoint { current, rest, accepted: &accepted };
        let mut round = try_all(current, &candidates, criteria, progress);
        let (next, gains) = refit_finalists((case, alignments), &disturbances, &at, &candidates, &round, criteria);
        round.own_filter_gains = gains;
        // What looks like a small effect may be a base that another start would have fitted better.
        if restarts < criteria.acceptance.most_restarts
            && let Some(better) =
                next.as_ref().and_then(|next| better_start(&disturbances, current, next, criteria))
        {
            restarts += 1;
            let rest = localise(&better, criteria);
            match &mut best {
                Some(best) => *best = (better, rest),
                None => (base, places) = (better, rest),
            }
            continue;
        }
        let refused =
            next.as_ref().map_or(Some(Stop::NoFinalist), |next| why_not(&at, next, &round, criteria));
        let gain = next.as_ref().map_or(0.0, |next| current.evidence_cost() - next.evidence_cost());
        rounds.push(if rounds.is_empty() { round } else { round.lighter() });
        let next = match (refused, next) {
            (None, Some(next)) => next,
            (refused, _) => break refused.unwrap_or(Stop::NoFinalist),
        };
        accepted.push(gain);
        let rest = localise(&next, criteria);
        best = Some((next, rest));
    };
    let (best, rest, lost_without) = match best {
        Some(best) => delete_backwards((case, alignments), &disturbances, criteria, best),
        None => {
            let start = &base.fitted.fit.theta;
            let best = frozen::freeze(base.case, &base.fitted.shape, &disturbances, start, base.tolerance);
            (best, places.clone(), Vec::new())
        }
    };
    Selection { base, best, rounds, stop, places, rest, lost_without }
}

/// The candidates that `current` does not hold yet, started from where the round `before` left them.
fn remaining(library: &[Candidate], current: &FrozenFit, before: Option<&Round>) -> Vec<Candidate> {
    let held = |c: &&Candidate| current.fitted.shape.effects.iter().all(|e| e.spec.id != c.spec.id);
    let mut candidates: Vec<Candidate> = library.iter().filter(held).cloned().collect();
    if let Some(before) = before {
        candidates.iter_mut().for_each(|candidate| start_from(candidate, before));
    }
    candidates
}

/// The model before `next` fitted again from where `next` ended, if that is better: one that gained little may have only
/// led the nuisances out of a side valley.
fn better_start<'a>(
    disturbances: &DisturbanceModel,
    current: &FrozenFit<'a>,
    next: &FrozenFit<'a>,
    criteria: &Criteria,
) -> Option<FrozenFit<'a>> {
    let acceptance = &criteria.acceptance;
    let gain = current.evidence_cost() - next.evidence_cost();
    let last = next.fitted.shape.effects.len().checked_sub(1)?;
    let realigned = !std::ptr::eq(next.case, current.case);
    if realigned || gain > acceptance.doubted_gain || next.tolerance != current.tolerance {
        return None;
    }
    let start = without_range(&next.fitted.fit.theta, next.fitted.shape.range_of(last));
    let again = frozen::freeze(current.case, &current.fitted.shape, disturbances, &start, current.tolerance);
    (again.evidence_cost() < current.evidence_cost() - acceptance.better_start).then_some(again)
}

/// Drops effects that the others have made superfluous; returns the model, what freeing places gains over it, and what it
/// would lose without each of several.
fn delete_backwards<'a>(
    (case, alignments): (&'a Case, &'a Alignments),
    disturbances: &DisturbanceModel,
    criteria: &Criteria,
    (mut best, mut rest): (FrozenFit<'a>, Vec<PlaceEvidence>),
) -> (FrozenFit<'a>, Vec<PlaceEvidence>, Vec<f64>) {
    let mut lost_without = Vec::new();
    let number = best.fitted.shape.effects.len();
    while best.fitted.shape.effects.len() > 1 {
        let effects = &best.fitted.shape.effects;
        let reduced: Vec<Option<FrozenFit<'a>>> = (0..effects.len())
            .into_par_iter()
            .map(|drop| {
                let keep: Vec<FittedEffect> = without_one(effects, drop);
                let theta = without_range(&best.fitted.fit.theta, best.fitted.shape.range_of(drop));
                let shape = best.fitted.shape.with_all(&keep);
                let case = aligned::align(case, alignments, &shape, &theta)?;
                Some(frozen::freeze(case, &shape, disturbances, &theta, best.tolerance))
            })
            .collect();
        let lost = |reduced: &Option<FrozenFit<'a>>| {
            reduced.as_ref().map_or(f64::INFINITY, |r| r.evidence_cost() - best.evidence_cost())
        };
        lost_without = reduced.iter().map(lost).collect();
        let cheapest = reduced.into_iter().flatten().min_by(|a, b| a.evidence_cost().total_cmp(&b.evidence_cost()));
        match cheapest {
            Some(smaller) if smaller.evidence_cost() < best.evidence_cost() + criteria.acceptance.gain => {
                best = smaller;
                lost_without = Vec::new();
            }
            _ => break,
        }
    }
    if best.fitted.shape.effects.len() != number {
        rest = localise(&best, criteria);
    }
    (best, rest, lost_without)
}

fn without_one(effects: &[FittedEffect], drop: usize) -> Vec<FittedEffect> {
    effects.iter().enumerate().filter(|(i, _)| *i != drop).map(|(_, e)| e.clone()).collect()
}

fn without_range(theta: &[f64], range: std::ops::Range<usize>) -> Vec<f64> {
    theta.iter().enumerate().filter(|(i, _)| !range.contains(i)).map(|(_, t)| *t).collect()
}
