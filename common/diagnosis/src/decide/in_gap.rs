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
pub(crate) fn first(case: &Case, selection: &Selection, criteria: &Criteria) -> Option<usize> {
    let share = |faint: &FrozenFit| {
        let models = Models::fit(case, &selection.base.fitted, Some(&faint.fitted));
        let fit = predictions::predict(case, &case.fit, models.build().each_ref());
        let [calibrated, extended] = predictions::robust_gaps(&fit);
        predictions::reduction(calibrated, extended).min(predictions::shrinks(&fit))
    };
    let shares: Vec<f64> = selection.faint.par_iter().map(share).collect();
    let cost = |index: usize| selection.faint[index].evidence_cost();
    let shown = (0..shares.len()).filter(|index| shares[*index] > criteria.acceptance.faint_share);
    shown.min_by(|a, b| cost(*a).total_cmp(&cost(*b)))
}

/// Where effects are looked for: the recordings as they are, and what the library leaves out.
#[derive(Clone, Copy)]
pub(crate) struct Search<'s, 'a> {
    /// The case.
    pub(crate) case: &'a Case,
    /// Where it is kept put right for late sensors.
    pub(crate) alignments: &'a Alignments,
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
        let gap = Gap::new(self.case, selection);
        let (shape, theta) = self.one_more(&gap)?;
        let mends = gap.mends(self.case, selection, (&shape, &theta), self.criteria);
        if mends { None } else { self.frozen(best, &shape, &theta) }
    }

    /// The effect that shrinks a gap most, if it does so beyond a limit: every candidate is tried open loop on the windows, and
    /// those that promise most are fitted to the end.
    fn one_more(&self, gap: &Gap) -> Option<(Shape, Vec<f64>)> {
        let Self { case, without, criteria, .. } = *self;
        let held = |c: &Candidate| gap.shape.effects.iter().any(|effect| effect.spec.id == c.spec.id);
        let library = candidates::all(case, without).into_iter();
        let library: Vec<Candidate> = library.filter(|candidate| !held(candidate)).collect();
        let count = criteria.pursuit.finalists;
        let model = (&gap.shape, &gap.theta[..]);
        let trials = frozen::open_loop_trials(case, model, &library, &[], count, &|_, _| false);
        let polish = |(_, shape, theta): (usize, Shape, Vec<f64>)| {
            let theta = windows::fit(case, &shape, &[theta]);
            (gap.shrunk_by(case, &shape, &theta), shape, theta)
        };
        let polished: Vec<(f64, Shape, Vec<f64>)> = trials.into_par_iter().map(polish).collect();
        let best = polished.into_iter().max_by(|a, b| a.0.total_cmp(&b.0));
        let shown = best.filter(|(shrunk, ..)| *shrunk >= criteria.acceptance.further_share);
        shown.map(|(_, shape, theta)| (shape, theta))
    }

    /// A model with a filter frozen at it; `None` where that finds it no likelier than `before`.
    fn frozen(&self, before: &FrozenFit<'a>, shape: &Shape, theta: &[f64]) -> Option<FrozenFit<'a>> {
        let (disturbances, tolerance) = (DisturbanceModel::default(), before.tolerance);
        let next = aligned::freeze(self.case, self.alignments, shape, &disturbances, theta, tolerance)
            .unwrap_or_else(|| frozen::freeze(self.case, shape, &disturbances, theta, tolerance));
        let gain = before.evidence_cost() - next.evidence_cost();
        (gain > self.criteria.pursuit.finalist_gain).then_some(next)
    }
}

/// The gap of the fitted runs as effects leave it.
struct Gap {
    /// The model with them, fitted on the windows.
    shape: Shape,
    theta: Vec<f64>,
    /// Robust gap with tolerances alone.
    calibrated: f64,
    /// Each window with the effects.
    windows: Vec<Tally>,
}

impl Gap {
    fn new(case: &Case, selection: &Selection) -> Self {
        let models = Models::fit(case, &selection.base.fitted, Some(&selection.best.fitted));
        let calibrated = robust(&windows::tallies(case, &models.nominal, &models.calibrated));
        let (shape, theta) = (models.extended_shape, models.extended);
        let windows = windows::tallies(case, &shape, &theta);
        Self { shape, theta, calibrated, windows }
    }

    /// By how much a model with one more effect shrinks the gap, relative: with all windows alike, and with those on the wrong
    /// side between holding and sliding counting little; the smaller of both.
    fn shrunk_by(&self, case: &Case, shape: &Shape, theta: &[f64]) -> f64 {
        let more = windows::tallies(case, shape, theta);
        let all = [&self.windows, &more].map(|windows| Tally::total(windows).gap());
        let robust = [&self.windows, &more].map(|windows| robust(windows));
        [all, robust]
            .map(|[before, after]| predictions::reduction(before, after))
            .into_iter()
            .fold(1.0, f64::min)
    }

    /// Whether one more effect only mends the form of those at its place: in squares of the gap, of which each
    /// effect has closed what the evidence lost without it is of all.
    fn mends(
        &self,
        case: &Case,
        selection: &Selection,
        (shape, theta): (&Shape, &[f64]),
        criteria: &Criteria,
    ) -> bool {
        let before = robust(&self.windows).powi(2);
        let gain = before - robust(&windows::tallies(case, shape, theta)).powi(2);
        let closed = (self.calibrated.powi(2) - before).max(0.0);
        let lost =
            |e: usize| selection.lost_without.get(e).copied().filter(|lost| lost.is_finite()).unwrap_or(1.0);
        let effects = &selection.best.fitted.shape.effects;
        let all: f64 = (0..effects.len()).map(lost).sum();
        let closed_by: Vec<(Term, f64)> = effects
            .iter()
            .enumerate()
            .map(|(e, effect)| (effect.spec.term, closed * lost(e) / all))
            .collect();
        shape.effects.last().is_some_and(|last| {
            mending::relation(last.spec.term, gain, &closed_by, &criteria.acceptance) == Relation::Mends
        })
    }
}

/// The effect, of several, without which the gap of fitted and of predicted runs grows least, if that is next to nothing and its
/// strength may be none. Asked of those whose evidence is a small part of the strongest one's.
pub(crate) fn idle(
    case: &Case,
    selection: &Selection,
    models: &Models,
    criteria: &Criteria,
) -> Option<usize> {
    let lost = &selection.lost_without;
    let most = lost.iter().copied().fold(0.0, f64::max);
    let several = models.extended_shape.effects.len() > 1;
    let small = (0..lost.len()).filter(|e| several && lost[*e] < criteria.verdict.doubted_share * most);
    let weak = small.filter(|e| details::may_do_nothing(selection, models, *e, criteria.report.widening));
    let least = weak.map(|effect| (effect, models.grows_without(case, effect, true)));
    let least = least.min_by(|a, b| a.1.total_cmp(&b.1));
    least.filter(|(_, grown)| *grown < criteria.verdict.least_further_reduction).map(|(effect, _)| effect)
}
