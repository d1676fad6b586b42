//! Effects looked for where people see them: in the gap, on its windows.
//!
//! A filter that allows for errors of the model follows what is slow or small beside them, and has little to say of an effect
//! that an open-loop prediction shows for ten seconds. Here candidates are weighed by how far they shrink the gap of the fitted
//! runs; runs to predict are never looked at for a choice.

use crate::data::align::Alignments;
use crate::data::case::Case;
use crate::decide::criteria::Criteria;
use crate::decide::mending::{self, Relation};
use crate::decide::selection::Selection;
use crate::fit::aligned;
use crate::fit::frozen::{self, FrozenFit};
use crate::fit::windows::{self, Models, robust};
use crate::model::candidates::{self, Candidate};
use crate::model::parameters::Shape;
use crate::predict::disturbances::DisturbanceModel;
use crate::predict::open_loop::Tally;
use crate::write::{details, predictions};
use railgrip_vehicle::effects::Term;
use rayon::prelude::*;

/// The likeliest effect, of those that gain little by a filter, that shrinks the gap of the fitted runs beyond a limit: with all
/// windows alike, and with those on the wrong side between holding and sliding counting little. How far it shrinks is no
/// measure beyond that, since a law that can follow many windows shrinks it in the fitted runs alone.
pub(crate) fn first(
    case: &Case,
    selection: &Selection,
    calibrated: &Models,
    criteria: &Criteria,
) -> Option<usize> {
    let before = windows::tallies(case, &calibrated.nominal, &calibrated.calibrated);
    let share = |faint: &FrozenFit| {
        let models = calibrated.extended_by(case, Some(&faint.fitted));
        shrunk_by(&before, &windows::tallies(case, &models.extended_shape, &models.extended))
    };
    let shares: Vec<f64> = selection.faint.par_iter().map(share).collect();
    let cost = |index: usize| selection.faint[index].evidence_cost();
    let shown = (0..shares.len()).filter(|index| shares[*index] > criteria.acceptance.faint_share);
    shown.min_by(|a, b| cost(*a).total_cmp(&cost(*b)))
}

/// By how much windows shrink the gap of those before them, relative: with all windows alike, and with those on the wrong side
/// between holding and sliding counting little; the smaller of both.
fn shrunk_by(before: &[Tally], after: &[Tally]) -> f64 {
    let all = |windows: &[Tally]| Tally::total(windows).gap();
    let robustly = predictions::reduction(robust(before), robust(after));
    robustly.min(predictions::reduction(all(before), all(after)))
}

/// Where effects are looked for: the recordings as they are, and what the library leaves out.
#[derive(Clone, Copy)]
pub(crate) struct Search<'s, 'a> {
    /// The case.
    pub(crate) case: &'a Case,
    /// Where it is kept put right for late sensors.
    pub(crate) alignments: &'a Alignments,
    /// The calibrated model.
    pub(crate) calibrated: &'s Models,
    /// The gap that a right model would leave of the fitted runs: where no more is left there is nothing to look for.
    pub(crate) enough: f64,
    /// Ids to leave out.
    pub(crate) without: &'s [String],
    /// Limits.
    pub(crate) criteria: &'s Criteria,
}

impl<'a> Search<'_, 'a> {
    /// A further effect, in the model beside those that were selected, without which much of the gap of the fitted runs is left;
    /// `None` where there is none, or where nothing was selected.
    ///
    /// It must not only mend the form of an effect before it at the same place.
    pub(crate) fn further(&self, selection: &Selection<'a>) -> Option<FrozenFit<'a>> {
        let best = &selection.best;
        let number = best.fitted.shape.effects.len();
        if number == 0 || number >= self.criteria.acceptance.most_effects {
            return None;
        }
        let shape = best.fitted.shape.on_recordings();
        let theta = windows::fit(self.case, &shape, std::slice::from_ref(&best.fitted.fit.theta));
        let now = Fit::new(self.case, shape, theta);
        if now.gap() <= self.enough {
            return None;
        }
        let more = self.one_more(&now)?;
        if self.mends(selection, &now, &more) { None } else { self.frozen(best, &more) }
    }

    /// Where nothing was selected and the gap is larger than tolerances and noise make it: the effect that shrinks it most, in the
    /// model; `None` where none does. A filter that allows for errors of the model follows a wheel that slides on a stretch of
    /// low adhesion instead of asking for it, so that no candidate begins where it would find the place.
    pub(crate) fn alone(&self, selection: &Selection<'a>) -> Option<FrozenFit<'a>> {
        let best = &selection.best;
        let Models { nominal, calibrated, .. } = self.calibrated;
        let now = Fit::new(self.case, nominal.clone(), calibrated.clone());
        let is_large = now.gap() > self.criteria.verdict.noticeable_gap.max(self.enough);
        if !best.fitted.shape.effects.is_empty() || !is_large {
            return None;
        }
        let more = self.one_more(&now)?;
        self.frozen(best, &more)
    }

    /// The effect that shrinks the gap of `now` most, if it does so beyond a limit: every candidate is tried open loop on the
    /// windows, and of those that promise most the ones that already come half as far are fitted to the end.
    fn one_more(&self, now: &Fit) -> Option<Fit> {
        let Self { case, without, criteria, .. } = *self;
        let (count, least) = (criteria.pursuit.finalists, criteria.acceptance.further_share);
        let held = |c: &Candidate| now.shape.effects.iter().any(|effect| effect.spec.id == c.spec.id);
        let library = candidates::all(case, without).into_iter();
        let library: Vec<Candidate> = library.filter(|candidate| !held(candidate)).collect();
        let model = (&now.shape, &now.theta[..]);
        let trials = frozen::open_loop_trials(case, model, &library, &[], count, &|_, _| false);
        let polish = |(_, shape, theta): (usize, Shape, Vec<f64>)| {
            let tried = Fit::new(case, shape, theta);
            if shrunk_by(&now.windows, &tried.windows) < 0.5 * least {
                return None;
            }
            let theta = windows::fit(case, &tried.shape, &[tried.theta]);
            let more = Fit::new(case, tried.shape, theta);
            Some((shrunk_by(&now.windows, &more.windows), more))
        };
        let polished: Vec<(f64, Fit)> = trials.into_par_iter().filter_map(polish).collect();
        let best = polished.into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
        best.filter(|(shrunk, _)| *shrunk >= least).map(|(_, more)| more)
    }

    /// Whether the last effect of `more` only mends the form of those of `now` at its place: in squares of the gap, of which
    /// each effect has closed as much as the evidence lost without it is of all.
    fn mends(&self, selection: &Selection, now: &Fit, more: &Fit) -> bool {
        let Models { nominal, calibrated, .. } = self.calibrated;
        let square = |windows: &[Tally]| robust(windows).powi(2);
        let left = square(&now.windows);
        let closed = (square(&windows::tallies(self.case, nominal, calibrated)) - left).max(0.0);
        let lost = |e: usize| selection.lost_without.get(e).copied().filter(|lost| lost.is_finite());
        let lost: Vec<f64> = (0..now.shape.effects.len()).map(|e| lost(e).unwrap_or(1.0)).collect();
        let all: f64 = lost.iter().sum();
        let terms = now.shape.effects.iter().map(|effect| effect.spec.term);
        let closed_by: Vec<(Term, f64)> =
            terms.zip(&lost).map(|(term, lost)| (term, closed * lost / all)).collect();
        let gain = left - square(&more.windows);
        more.shape.effects.last().is_some_and(|last| {
            mending::relation(last.spec.term, gain, &closed_by, &self.criteria.acceptance) == Relation::Mends
        })
    }

    /// A model with a filter frozen at it; `None` where that finds it no likelier than `before`.
    fn frozen(&self, before: &FrozenFit<'a>, Fit { shape, theta, .. }: &Fit) -> Option<FrozenFit<'a>> {
        let (disturbances, tolerance) = (DisturbanceModel::default(), before.tolerance);
        let next = aligned::freeze(self.case, self.alignments, shape, &disturbances, theta, tolerance)
            .unwrap_or_else(|| frozen::freeze(self.case, shape, &disturbances, theta, tolerance));
        let gain = before.evidence_cost() - next.evidence_cost();
        (gain > self.criteria.pursuit.finalist_gain).then_some(next)
    }
}

/// A model fitted on the windows, and what it leaves of each.
struct Fit {
    shape: Shape,
    theta: Vec<f64>,
    windows: Vec<Tally>,
}

impl Fit {
    fn new(case: &Case, shape: Shape, theta: Vec<f64>) -> Self {
        let windows = windows::tallies(case, &shape, &theta);
        Self { shape, theta, windows }
    }

    /// What it leaves of the gap.
    fn gap(&self) -> f64 {
        Tally::total(&self.windows).gap()
    }
}

/// The effect, of several, without which the gap of fitted runs grows least, if that is next to nothing: a few hundredths, of any
/// but the strongest; some more of one whose evidence is a small part of the strongest one's and whose strength may be none, or
/// that gains much less when it is fitted to other runs, and of all but the strongest with a filter that tolerates gross errors.
pub(crate) fn idle(
    case: &Case,
    selection: &Selection,
    models: &Models,
    criteria: &Criteria,
) -> Option<usize> {
    let (lost, limits) = (&selection.lost_without, &criteria.verdict);
    let most = lost.iter().copied().fold(0.0, f64::max);
    if models.extended_shape.effects.len() < 2 {
        return None;
    }
    let is_faint = |e: usize| {
        lost[e] < limits.doubted_share * most
            && details::may_do_nothing(selection, models, e, criteria.report.widening)
    };
    let is_of_one_run = |e: usize| {
        let id = models.extended_shape.effects[e].spec.id;
        let own = selection.accepted_in(id).and_then(|round| round.of(id));
        own.is_some_and(|own| own.predictive < limits.doubted_predictive_share * own.gain)
    };
    let is_loose = selection.best.tolerance >= criteria.pursuit.gross_tolerance;
    let is_doubted = |e: usize| is_faint(e) || is_loose || is_of_one_run(e);
    let further: Vec<usize> = (0..lost.len()).filter(|e| lost[*e] < most).collect();
    let grown = |e: usize| {
        let least = if is_doubted(e) { limits.least_further_reduction } else { limits.least_shown };
        let fitted = models.fitted_grows_without(case, e);
        (fitted < least).then_some((e, fitted))
    };
    let idle: Vec<(usize, f64)> = further.into_par_iter().filter_map(grown).collect();
    idle.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).map(|(effect, _)| effect)
}
