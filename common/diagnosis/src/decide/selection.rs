//! The selection: try every candidate on the calibrated model, accept the best, try again on top of it, delete what is not
//! needed.

use crate::data::align::Alignments;
use crate::data::case::Case;
use crate::data::noise::SensorNoise;
use crate::decide::acceptance::{Stop, is_hopeless, is_quiet, why_not};
use crate::decide::criteria::Criteria;
use crate::decide::imitation;
use crate::decide::round::{Gain, Round, Standpoint, refit_finalists, start_from, try_all};
use crate::fit::aligned;
use crate::fit::discrepancies::FittedDiscrepancy;
use crate::fit::frozen::{self, FrozenFit};
use crate::fit::hearing;
use crate::fit::objective::Whitening;
use crate::model::candidates::{self, Candidate};
use crate::model::parameters::{FittedEffect, Shape};
use crate::predict::disturbances::{DisturbanceModel, TOLERANCES};
use crate::predict::localise::{self, PlaceEvidence, Stretches};
use rayon::prelude::*;
use std::sync::OnceLock;

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
    /// The best of the first round where none was taken: what is slow a filter takes for pads that drift.
    pub faint: Vec<FrozenFit<'a>>,
    /// Flexible discrepancies instead of any effect, with the evidence that they gain over the base, once they were asked for.
    pub(crate) instead: OnceLock<Vec<(FittedDiscrepancy, f64)>>,
}

impl<'a> Selection<'a> {
    /// Takes a faint effect into the model after all; what it gains still has to be more than chance.
    pub fn take_faint(&mut self, index: usize, criteria: &Criteria) {
        self.best = self.faint.swap_remove(index);
        self.rest = localise(&self.best, criteria);
        self.faint.clear();
    }

    /// Takes a model with one effect more for the best, if it needs each of its effects.
    pub(crate) fn take_further(
        &mut self,
        recorded: (&'a Case, &'a Alignments),
        next: FrozenFit<'a>,
        criteria: &Criteria,
    ) -> bool {
        let number = next.fitted.shape.effects.len();
        let rest = localise(&next, criteria);
        let (best, rest, lost_without) =
            delete_backwards(recorded, &DisturbanceModel::default(), criteria, (next, rest));
        if best.fitted.shape.effects.len() < number {
            return false;
        }
        (self.best, self.rest, self.lost_without) = (best, rest, lost_without);
        true
    }

    /// Takes one effect out of the best model again, which is fitted anew; false, and nothing changes, where that cannot be.
    pub fn drop_effect(
        &mut self,
        recorded: (&'a Case, &'a Alignments),
        effect: usize,
        criteria: &Criteria,
    ) -> bool {
        let Some(best) = reduced(recorded, &DisturbanceModel::default(), &self.best, effect) else {
            return false;
        };
        self.rest = localise(&best, criteria);
        self.best = best;
        if effect < self.lost_without.len() {
            self.lost_without.remove(effect);
        }
        true
    }
}

impl Selection<'_> {
    /// The effect without which the best model would lose most.
    pub fn strongest(&self) -> Option<&FittedEffect> {
        let effects = &self.best.fitted.shape.effects;
        let lost = |e: usize| self.lost_without.get(e).copied().unwrap_or(0.0);
        (0..effects.len()).max_by(|a, b| lost(*a).total_cmp(&lost(*b))).map(|e| &effects[e])
    }

    /// The round in which the effect named `id` was tried against its rivals and taken: the last that tried it.
    pub fn accepted_in(&self, id: &str) -> Option<&Round> {
        self.rounds.iter().rev().find(|round| round.gains.iter().any(|gain| gain.id == id))
    }
}

/// Fits the nuisances alone, from the filter that tolerates most errors of the model.
pub fn calibrate(case: &Case) -> FrozenFit<'_> {
    let shape = Shape::nominal(case);
    frozen::freeze(case, &shape, &DisturbanceModel::default(), &shape.start(), TOLERANCES.len() - 1)
}

/// Fits the nuisances again on recordings whose noise was heard, from where `base` ended with the noise of the vehicle file and
/// from one tolerance above its own.
pub fn calibrate_again<'a>(case: &'a Case, base: &FrozenFit) -> FrozenFit<'a> {
    let (shape, start) = (&base.fitted.shape, &base.fitted.fit.theta);
    let from = (base.tolerance + 1).min(TOLERANCES.len() - 1);
    frozen::freeze(case, shape, &DisturbanceModel::default(), start, from)
}

/// The case with the noise of its sensors as the recordings show it, where the vehicle file says something less likely and
/// the calibrated model `base` is right enough to tell.
pub fn heard(base: &FrozenFit, criteria: &Criteria) -> Option<Case> {
    let hearing = &criteria.hearing;
    if base.tolerance > hearing.most_tolerance {
        return None;
    }
    let noise = if base.tolerance > hearing.strict_tolerance {
        // Stronger noise than the file says looks like a model that is wrong at every sample.
        let (shape, start) = (&base.fitted.shape, &base.fitted.fit.theta);
        let disturbances = DisturbanceModel::default();
        let strict = frozen::freeze(base.case, shape, &disturbances, start, hearing.strict_tolerance);
        hearing::listen(&strict, base, hearing)?
    } else {
        hearing::listen(base, base, hearing)?
    };
    let file = SensorNoise::of_file(&base.case.vehicle.sensors);
    let mut heard = Case { noise, ..base.case.clone() };
    for j in [0, 1] {
        let what = ["vehicle speed", "wheelset speeds"][j];
        let times = noise[j].level() / file[j].level();
        let share = (noise[j].coloured / noise[j].level()).powi(2);
        let colour = match share > 0.0 {
            true => {
                format!(", {:.0} % of its variance lasting about {:.2} s", 100.0 * share, noise[j].time_s)
            }
            false => ", white".to_owned(),
        };
        if noise[j] != file[j] {
            heard.notes.push(format!(
                "the noise of {what} was taken from the recordings: {times:.2} times what the vehicle file says{colour}"
            ));
        }
    }
    Some(heard)
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
    let climb = Climb { case, alignments, library, disturbances, criteria, progress };
    let mut path = Path::new(base, places);
    climb.go_on(&mut path, criteria.acceptance.most_restarts, 1);
    climb.try_rival(&mut path);
    let Path { base, places, best, rounds, stop, faint, .. } = path;
    let (best, rest, lost_without) = match best {
        Some(best) => delete_backwards((case, alignments), &climb.disturbances, criteria, best),
        None => {
            let start = &base.fitted.fit.theta;
            let shape = &base.fitted.shape;
            let best = frozen::freeze(base.case, shape, &climb.disturbances, start, base.tolerance);
            (best, places.clone(), Vec::new())
        }
    };
    Selection { base, best, rounds, stop, places, rest, lost_without, faint, instead: OnceLock::new() }
}

/// How far a selection has come.
struct Path<'a> {
    base: FrozenFit<'a>,
    places: Vec<PlaceEvidence>,
    best: Option<(FrozenFit<'a>, Vec<PlaceEvidence>)>,
    rounds: Vec<Round>,
    /// Evidence that each effect gained when it was accepted.
    accepted: Vec<f64>,
    stop: Stop,
    /// The second best of the first round, if it did nearly as well beside a gross misfit.
    rival: Option<FrozenFit<'a>>,
    /// The best of the first round, if none was taken.
    faint: Vec<FrozenFit<'a>>,
}

impl<'a> Path<'a> {
    fn new(base: FrozenFit<'a>, places: Vec<PlaceEvidence>) -> Self {
        let (rounds, accepted) = (Vec::new(), Vec::new());
        Self {
            base,
            places,
            best: None,
            rounds,
            accepted,
            stop: Stop::NoFinalist,
            rival: None,
            faint: Vec::new(),
        }
    }

    /// The model so far, and what freeing places gains over it.
    fn standing(&self) -> (&FrozenFit<'a>, &[PlaceEvidence]) {
        self.best.as_ref().map_or((&self.base, &self.places[..]), |(frozen, rest)| (frozen, &rest[..]))
    }

    /// Evidence that is left to gain above innovations that cost `white`.
    fn excess(&self, white: f64) -> f64 {
        let (frozen, _) = self.standing();
        (frozen.evidence_cost() - white).max(0.0)
    }
}

/// What a selection climbs with.
struct Climb<'s, 'a> {
    case: &'a Case,
    alignments: &'a Alignments,
    library: Vec<Candidate>,
    disturbances: DisturbanceModel,
    criteria: &'s Criteria,
    progress: &'s (dyn Fn(&'static str) + Sync),
}

impl<'a> Climb<'_, 'a> {
    /// Takes one effect after the other into the model, until there is a reason to stop.
    /// A gross misfit that grows at its likeliest place is given up once there are `patience` effects.
    fn go_on(&self, path: &mut Path<'a>, mut restarts: usize, patience: usize) {
        let (case, criteria, disturbances) = (self.case, self.criteria, &self.disturbances);
        path.stop = loop {
            if path.accepted.len() == criteria.acceptance.most_effects {
                break Stop::EnoughEffects;
            }
            let standing = path.standing();
            let (current, rest) = standing;
            // Every candidate is tried once; on top of a model that leaves nothing there is nothing to try.
            if !path.rounds.is_empty() && is_quiet(current, rest, &criteria.localisation) {
                break Stop::Quiet;
            }
            let began = (&path.base, &path.places[..]);
            if path.accepted.len() >= patience && is_hopeless(began, standing, criteria) {
                break Stop::Hopeless;
            }
            let candidates = remaining(&self.library, current, path.rounds.last());
            if candidates.is_empty() {
                break Stop::NoCandidate;
            }
            let at = Standpoint { current, rest, accepted: &path.accepted };
            (self.progress)("candidates");
            let mut round = try_all(current, &candidates, criteria, self.progress);
            (self.progress)("finalists");
            let (finalists, gains) =
                refit_finalists((case, self.alignments), disturbances, &at, &candidates, &round, criteria);
            round.own_filter_gains = gains;
            let mut finalists = finalists.into_iter();
            let next = finalists.next();
            // What looks like a small effect may be a base that another start would have fitted better.
            if restarts > 0
                && let Some(better) =
                    next.as_ref().and_then(|next| better_start(disturbances, current, next, criteria))
            {
                restarts -= 1;
                let rest = localise(&better, criteria);
                match &mut path.best {
                    Some(best) => *best = (better, rest),
                    None => (path.base, path.places) = (better, rest),
                }
                continue;
            }
            let others = finalists.as_slice();
            let takes_up_form = |next: &FrozenFit| {
                imitation::takes_up_form(&at, next, others, disturbances, criteria)
                    .then_some(Stop::NotOneMore)
            };
            let refused = next.as_ref().map_or(Some(Stop::NoFinalist), |next| {
                why_not(&at, next, &round, criteria).or_else(|| takes_up_form(next))
            });
            let gain = |next: &FrozenFit| current.evidence_cost() - next.evidence_cost();
            let gained = next.as_ref().map_or(0.0, gain);
            let rival = (path.accepted.is_empty() && current.tolerance >= criteria.pursuit.gross_tolerance)
                .then(|| finalists.find(|other| last_id(other) != next.as_ref().and_then(last_id)))
                .flatten()
                .filter(|rival| gain(rival) > criteria.pursuit.rival_share * gained);
            path.rounds.push(if path.rounds.is_empty() { round } else { round.lighter() });
            let next = match (refused, next) {
                (None, Some(next)) => next,
                (refused, next) => {
                    if path.accepted.is_empty() {
                        let tried = next.into_iter().chain(finalists).collect();
                        let faint = self.faint(&path.base, &path.rounds[path.rounds.len() - 1], tried);
                        path.faint = faint;
                    }
                    break refused.unwrap_or(Stop::NoFinalist);
                }
            };
            path.rival = path.rival.take().or(rival);
            path.accepted.push(gained);
            let rest = localise(&next, criteria);
            path.best = Some((next, rest));
        };
    }

    /// Where none was taken: the candidates that gain most by the filter of `base` alone, whatever left-out runs say, beside the
    /// finalists that were `tried`, with filters of their own.
    fn faint(&self, base: &FrozenFit<'a>, round: &Round, tried: Vec<FrozenFit<'a>>) -> Vec<FrozenFit<'a>> {
        let pursuit = &self.criteria.pursuit;
        let mut order: Vec<&Gain> = round.gains.iter().filter(|g| g.gain > pursuit.finalist_gain).collect();
        order.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        order.truncate(pursuit.finalists);
        order.retain(|g| tried.iter().all(|tried| last_id(tried) != Some(g.id)));
        let freeze = |g: &&Gain| {
            let fitted = &g.fitted;
            frozen::freeze(base.case, &fitted.shape, &self.disturbances, &fitted.fit.theta, base.tolerance)
        };
        let mut faint: Vec<FrozenFit<'a>> = order.par_iter().map(freeze).collect();
        faint.extend(tried);
        faint.retain(|frozen| base.evidence_cost() - frozen.evidence_cost() > pursuit.finalist_gain);
        faint
    }

    /// Climbs again from the rival of the first effect, and takes what is found if it leaves less: where two things are wrong at
    /// once, the effect that gains most alone need not be one of them.
    fn try_rival(&self, path: &mut Path<'a>) {
        let Some(rival) = path.rival.take() else { return };
        let (current, rest) = path.standing();
        if is_quiet(current, rest, &self.criteria.localisation) {
            return;
        }
        let white = self.white_cost(current);
        let (excess, number) = (path.excess(white), path.accepted.len());
        let later = path.rounds.split_off(1);
        let gained = path.base.evidence_cost() - rival.evidence_cost();
        let rest = localise(&rival, self.criteria);
        let best = path.best.replace((rival, rest));
        let accepted = std::mem::replace(&mut path.accepted, vec![gained]);
        let stop = path.stop;
        self.go_on(path, 0, 2);
        let more = path.accepted.len().saturating_sub(number);
        let allowed = self.criteria.acceptance.left_by_more.powi(more as i32);
        if path.excess(white) >= allowed * excess {
            path.rounds.truncate(1);
            path.rounds.extend(later);
            (path.best, path.accepted, path.stop) = (best, accepted, stop);
        }
    }
}

impl Climb<'_, '_> {
    /// What innovations of `frozen` would cost if a filter that tolerates no error of the model made them white.
    fn white_cost(&self, frozen: &FrozenFit) -> f64 {
        let built = frozen.fitted.shape.build(&frozen.fitted.fit.theta);
        let strict = Whitening::new(frozen.case, &built, &self.disturbances.tolerant(0));
        0.5 * frozen.fitted.residuals.len() as f64 + strict.half_log_determinant()
    }
}

/// Id of the effect that was taken last.
fn last_id(frozen: &FrozenFit) -> Option<&'static str> {
    frozen.fitted.shape.effects.last().map(|effect| effect.spec.id)
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
    let (_, start) = next.fitted.shape.without(&next.fitted.fit.theta, last);
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
        let each = (0..best.fitted.shape.effects.len()).into_par_iter();
        let reduced: Vec<Option<FrozenFit<'a>>> =
            each.map(|drop| reduced((case, alignments), disturbances, &best, drop)).collect();
        let lost = |reduced: &Option<FrozenFit<'a>>| {
            reduced.as_ref().map_or(f64::INFINITY, |r| r.evidence_cost() - best.evidence_cost())
        };
        lost_without = reduced.iter().map(lost).collect();
        let cheapest =
            reduced.into_iter().flatten().min_by(|a, b| a.evidence_cost().total_cmp(&b.evidence_cost()));
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

/// A model without one of its effects, fitted again; `None` if no more alignments can be kept.
fn reduced<'a>(
    (case, alignments): (&'a Case, &'a Alignments),
    disturbances: &DisturbanceModel,
    best: &FrozenFit<'a>,
    effect: usize,
) -> Option<FrozenFit<'a>> {
    let (shape, theta) = best.fitted.shape.without(&best.fitted.fit.theta, effect);
    let case = aligned::align(case, alignments, &shape, &theta)?;
    Some(frozen::freeze(case, &shape, disturbances, &theta, best.tolerance))
}
