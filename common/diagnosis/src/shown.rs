//! What is shown of a wagon: three models, what they predict of its runs, and the verdict in view of that.

use crate::answer::schema::{NaturalGap, Verdict};
use crate::data::case::{Case, Run};
use crate::decide::criteria::Criteria;
use crate::decide::evidence::Judgement;
use crate::decide::practice::{Practice, in_practice, in_practice_of_curve, in_spite_of_curve};
use crate::fit::candidate::Fitted;
use crate::fit::windows::Models;
use crate::model::parameters::Built;
use crate::write::predictions::{self, Predicted};

/// The three models of a report, and what they predict.
pub(crate) struct Shown<'f> {
    /// The fit whose effects the extended model has; `None` where that is the calibrated one.
    pub(crate) named: Option<&'f Fitted>,
    /// The models.
    pub(crate) models: Models,
    /// The same, built.
    pub(crate) built: [Built; 3],
    /// What they predict of the fitted runs.
    pub(crate) fit: Vec<Predicted>,
    /// What they predict of the runs that are only predicted.
    pub(crate) holdout: Vec<Predicted>,
}

impl<'f> Shown<'f> {
    /// Predicts the runs of `case` with `models`, of which the extended one has the effects of `named`.
    pub(crate) fn new(case: &Case, models: Models, named: Option<&'f Fitted>) -> Self {
        let built = models.build();
        let predict = |runs: &[Run]| predictions::predict(case, runs, built.each_ref());
        let (fit, holdout) = (predict(&case.fit), predict(&case.holdout));
        Self { named, models, built, fit, holdout }
    }
}

/// What a verdict is tried with in practice.
pub(crate) struct Trial<'t> {
    /// The case with all its samples, which are predicted.
    pub(crate) case: &'t Case,
    /// The same with the samples that models are fitted to.
    pub(crate) fitted: &'t Case,
    /// The models without any effect.
    pub(crate) calibrated: &'t Models,
    /// What a right model would leave of the gap.
    pub(crate) natural: NaturalGap,
    /// All limits.
    pub(crate) criteria: &'t Criteria,
}

impl Trial<'_> {
    /// Revises a verdict by what becomes of the gap, and returns what is shown then: what does next to nothing to the gap is no
    /// answer to where it comes from, and a gap that is left is one. `tried` is the best fit of the selection, named or not.
    pub(crate) fn revise<'f>(
        &self,
        judgement: &mut Judgement,
        tried: &'f Fitted,
        mut shown: Shown<'f>,
    ) -> Shown<'f> {
        let tie = self.criteria.ties.look_alike;
        judgement.decision = in_practice(judgement.decision, &self.practice(&shown), self.criteria);
        let is_overruled = judgement.decision.verdict == Verdict::Unknown && judgement.evidence.is_named();
        if is_overruled && tried.shape.effects.len() == 1 {
            let with = self.with(tried);
            if let Some(decision) = in_spite_of_curve(&self.practice(&with), self.criteria) {
                judgement.decision = decision;
                shown = with;
            }
        }
        // A gap that is left asks for no curve: it is larger than noise makes it, whatever a curve does.
        let is_asked = judgement.missing.is_some();
        judgement.sort_missing(tie);
        let is_unnamed = judgement.decision.verdict == Verdict::Unknown;
        if is_unnamed
            && is_asked
            && let Some(missing) = &judgement.missing
        {
            let practice = self.practice(&self.with(&missing.fitted));
            judgement.decision = in_practice_of_curve(judgement.decision, &practice, self.criteria);
            judgement.sort_missing(tie);
        }
        match shown.named.is_some() && !judgement.decision.names_effects() {
            true => Shown::new(self.case, self.calibrated.clone(), None),
            false => shown,
        }
    }

    /// What would be shown with what `fitted` adds to the calibrated model.
    fn with<'f>(&self, fitted: &'f Fitted) -> Shown<'f> {
        Shown::new(self.case, self.calibrated.extended_by(self.fitted, Some(fitted)), Some(fitted))
    }

    /// What the models do to the gap of fitted and of predicted runs.
    fn practice(&self, shown: &Shown) -> Practice {
        let gaps = |runs: &[Predicted]| {
            let [_, calibrated, extended] = predictions::totals(runs).map(|tally| tally.gap());
            [calibrated, extended]
        };
        let (fit, holdout) = (&shown.fit[..], &shown.holdout[..]);
        let (is_held_out, natural) = (!holdout.is_empty(), self.natural);
        Practice {
            fitted: gaps(fit),
            held_out: is_held_out.then(|| gaps(holdout)),
            predicted: is_held_out.then(|| predictions::robust_gaps(holdout)),
            moved: predictions::moved(self.case, holdout),
            lasting: predictions::lasting_gaps([fit, holdout], self.criteria.localisation.event_share),
            natural: [natural.fit, natural.holdout.unwrap_or(natural.fit)],
        }
    }
}
