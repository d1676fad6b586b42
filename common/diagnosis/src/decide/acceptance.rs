//! Whether one more effect is taken into the model, and why the selection stops.

use crate::decide::criteria::{Acceptance, Criteria, Localisation, Pursuit, VerdictLimits};
use crate::decide::mending::Relation;
use crate::decide::round::{Gain, Round, Standpoint};
use crate::decide::significance::counted;
use crate::fit::candidate::Fitted;
use crate::fit::frozen::{self, FrozenFit};
use crate::predict::localise::{self, PlaceEvidence};

/// Why the selection stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// As many effects are named as may be.
    EnoughEffects,
    /// The model leaves nothing to explain.
    Quiet,
    /// The effects leave most of a gross misfit where it was: something else is wrong.
    Hopeless,
    /// The library is used up.
    NoCandidate,
    /// No candidate fitted well enough to get a filter of its own.
    NoFinalist,
    /// What the best candidate gains lies in a few stretches only.
    Event,
    /// The best candidate gains too little.
    GainsLittle,
    /// The best candidate fails on runs left out.
    FailsLeftOut,
    /// The best candidate is no further effect: it mends one before it, takes up no more than one that does, sits on its bound, or lies
    /// where little is wrong.
    NotOneMore,
}

impl Stop {
    /// Why, in one sentence for people.
    pub const fn words(self) -> &'static str {
        match self {
            Self::EnoughEffects => "As many effects are named as may be named together.",
            Self::Quiet => "The model leaves nothing to explain.",
            Self::Hopeless => "The effects so far leave most of a gross misfit where it was.",
            Self::NoCandidate => "No candidate is left to try.",
            Self::NoFinalist => "No candidate fits well enough to be looked at more closely.",
            Self::Event => "What the best candidate gains lies in a few seconds only.",
            Self::GainsLittle => "The best candidate gains too little.",
            Self::FailsLeftOut => "The best candidate does not predict runs that are left out of the fit.",
            Self::NotOneMore => {
                "The best candidate mends an effect before it, sits on its bound, or acts where little is wrong."
            }
        }
    }
}

/// Whether a model leaves nothing to explain.
pub(crate) fn is_quiet(frozen: &FrozenFit, rest: &[PlaceEvidence], localisation: &Localisation) -> bool {
    let expected = 0.5 * frozen.fitted.residuals.len() as f64;
    let white = frozen.fitted.fit.cost < localisation.white_cost * expected;
    let quiet = rest.first().is_none_or(|place| place.evidence < localisation.quiet_evidence);
    frozen.tolerance == 0 && white && quiet
}

/// Whether named effects leave most of a gross misfit, at their own place or more than there was: then what is wrong is
/// something else, and further names would only decorate it.
pub(crate) fn is_hopeless(
    (base, before): (&FrozenFit, &[PlaceEvidence]),
    (frozen, rest): (&FrozenFit, &[PlaceEvidence]),
    criteria: &Criteria,
) -> bool {
    let (pursuit, limits): (&Pursuit, &VerdictLimits) = (&criteria.pursuit, &criteria.verdict);
    let gained = base.evidence_cost() - frozen.evidence_cost();
    let left = localise::share_left(before, rest, gained);
    let likely = localise::likely(rest, criteria.localisation.likely_share);
    let same = frozen.fitted.shape.effects.iter().any(|e| localise::may_act_at(e.spec.term, likely));
    frozen.tolerance >= pursuit.gross_tolerance && (left > 1.0 || (left > limits.most_left && same))
}

/// Why the best of a round, `next`, is not taken into the model; `None` if it is.
pub(crate) fn why_not(at: &Standpoint, next: &FrozenFit, round: &Round, criteria: &Criteria) -> Option<Stop> {
    let acceptance = &criteria.acceptance;
    if is_an_event(at.current, next, round, criteria) {
        return Some(Stop::Event);
    }
    let gain = at.current.evidence_cost() - next.evidence_cost();
    let predictive = predictive_gain(at.current, next, round);
    let sure = gain > acceptance.certain_gain || next.tolerance != at.current.tolerance;
    if gain < acceptance.gain {
        return Some(Stop::GainsLittle);
    }
    let predicts = predictive >= acceptance.predictive;
    if !predicts && !sure {
        return Some(Stop::FailsLeftOut);
    }
    // What is gained on runs left out is a share of what the same filter gains on all.
    let on_all = shared_gain(at.current, next, round).map_or(gain, |shared| shared.gain);
    let agree = predictive >= acceptance.elsewhere_predictive_share * on_all;
    (!is_one_more(at, next, gain, agree, criteria)).then_some(Stop::NotOneMore)
}

/// What the last effect of `next` gains by the filter of the model before it, where its own is another: costs by two filters are
/// not to be compared run by run.
fn shared_gain<'r>(current: &FrozenFit, next: &FrozenFit, round: &'r Round) -> Option<&'r Gain> {
    let last = next.fitted.shape.effects.last().map_or("", |effect| effect.spec.id);
    round.of(last).filter(|_| next.tolerance != current.tolerance)
}

/// What the last effect of `next` gains on runs left out, by a filter that both models share.
fn predictive_gain(current: &FrozenFit, next: &FrozenFit, round: &Round) -> f64 {
    let shared = shared_gain(current, next, round);
    shared.map_or_else(|| next.fitted.predictive_gain(&current.fitted), |gain| gain.predictive)
}

/// Whether the last effect of `next` is one more effect: beside one at the same place it must gain a good share of what that
/// gained, see [`mending`](crate::decide::mending); elsewhere little is enough if runs left out `agree`, or if that is where
/// the model before errs most. The first effect, too, must be one or the other; a further one whose strength runs into its
/// bound is none.
fn is_one_more(at: &Standpoint, next: &FrozenFit, gain: f64, agree: bool, criteria: &Criteria) -> bool {
    let acceptance = &criteria.acceptance;
    let Some((last, before)) = next.fitted.shape.effects.split_last() else { return false };
    if !before.is_empty() && next.fitted.is_on_bound(before.len(), acceptance) {
        return false;
    }
    let all: f64 = at.accepted.iter().sum();
    match at.relation(next, criteria) {
        None | Some(Relation::Mends) => false,
        Some(Relation::Beside) => gain >= acceptance.in_place_share * all,
        Some(Relation::Apart) => {
            let likely = localise::likely(at.rest, criteria.localisation.likely_share);
            let in_place = localise::may_act_at(last.spec.term, likely);
            let least = if before.is_empty() { 0.0 } else { least_elsewhere(all, acceptance) };
            (gain >= acceptance.in_place_share * all && in_place) || (gain >= least && agree)
        }
    }
}

/// Least evidence of a further effect that the likeliest place does not speak for, beside effects that gained `all`.
fn least_elsewhere(all: f64, acceptance: &Acceptance) -> f64 {
    (acceptance.elsewhere_share * all).max(acceptance.elsewhere_gain)
}

/// Whether what the last effect of `next` gains is next to nothing outside of a few stretches, by the filter that both
/// share: a wheelset at the edge between holding and sliding that falls the other way once is no effect.
fn is_an_event(current: &FrozenFit, next: &FrozenFit, round: &Round, criteria: &Criteria) -> bool {
    let acceptance = &criteria.acceptance;
    let gain = current.evidence_cost() - next.evidence_cost();
    let last = next.fitted.shape.effects.last().map_or("", |effect| effect.spec.id);
    let own = round.of(last);
    if gain > acceptance.certain_gain || next.tolerance != current.tolerance {
        return false;
    }
    own.is_none_or(|own| {
        let lasting = lasting(current, own, criteria);
        own.gain < acceptance.gain || lasting < acceptance.lasting_share * acceptance.gain
    })
}

/// What a candidate gains outside of the few stretches in which it gains most, on top of the model of its round.
fn lasting(current: &FrozenFit, own: &Gain, criteria: &Criteria) -> f64 {
    localise::lasting(by_stretch(current, own, criteria), criteria.localisation.event_share)
}

/// What a candidate gains in each stretch, on top of the model of its round.
fn by_stretch(current: &FrozenFit, own: &Gain, criteria: &Criteria) -> Vec<f64> {
    let length = current.whitening.stretch(criteria.significance.stretch_s);
    let stretches = |fitted: &Fitted| frozen::costs_of_stretches(&fitted.residuals, length);
    let (before, after) = (stretches(&current.fitted), stretches(&own.fitted));
    before.iter().zip(after).map(|(before, after)| before - after).collect()
}

/// What of a candidate's gain is compared with chance, see [`counted`].
pub(crate) fn counted_gain(current: &FrozenFit, own: &Gain, criteria: &Criteria) -> f64 {
    if own.fitted.residuals.is_empty() {
        return own.gain;
    }
    counted(own.gain, || by_stretch(current, own, criteria), criteria)
}
