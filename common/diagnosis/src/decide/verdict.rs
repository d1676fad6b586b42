//! From the selection to a verdict: what is named, what is missing, and how sure that is.

use crate::answer::schema::Verdict;
use crate::data::case::Case;
use crate::decide::selection::{self, Acceptance, Selection};
use crate::decide::significance::Chance;
use crate::fit::discrepancies::{self, FittedDiscrepancy, STRUCTURE};
use crate::fit::frozen::FrozenFit;
use crate::predict::localise;

/// Named effects must recover this share of what they and a flexible discrepancy recover together.
const RECOVERED: f64 = 0.65;
/// Below this share the rest is missing beside the named effects.
const NEARLY_ALL: f64 = 0.8;
/// A flexible discrepancy at one place that gains this many times what the named effects gain shows that they are not the
/// answer; laws of another form than the plant's fall short by less.
const OUTDONE: f64 = 1.25;
/// What freeing a place must gain to count as structure where nothing is named.
const LEFT_ALONE: f64 = 250.0;

/// What was concluded.
#[derive(Debug)]
pub struct Judgement {
    /// The verdict.
    pub verdict: Verdict,
    /// Share of the explainable that the named effects recover.
    pub recovered: f64,
    /// Share of what freeing the likeliest place gains that is left beside the named effects; one if there are none.
    pub left: f64,
    /// What is missing, for unknown and for effects with a rest.
    pub missing: Option<FittedDiscrepancy>,
    /// The test against chance.
    pub chance: Option<Chance>,
    /// Flexible discrepancies on top of the best model, strongest first.
    pub beside: Vec<FittedDiscrepancy>,
    /// Flexible discrepancies at likely places on top of the nuisances alone, strongest first; empty unless in doubt.
    pub instead: Vec<FittedDiscrepancy>,
}

impl Judgement {
    /// Whether the effects selected are (part of) the answer.
    pub fn names_effects(&self) -> bool {
        matches!(self.verdict, Verdict::Effects | Verdict::EffectsAndUnknown)
    }
}

/// Judges the outcome of the selection.
pub fn judge(case: &Case, selection: &Selection, acceptance: Acceptance, seed: u64) -> Judgement {
    let best = &selection.best;
    let chance = selection
        .rounds
        .first()
        .map(|round| Chance::new(round, selection.base.fitted.shape.nuisance_count(), &best.fitted, seed));
    let gain = (selection.base.evidence_cost() - best.evidence_cost()).max(0.0);
    let alarm = chance.as_ref().map_or(0.0, Chance::threshold);
    let named = !best.fitted.shape.effects.is_empty() && gain > alarm;
    let (places, likely) = (&selection.places, localise::likely(&selection.places));
    let mut beside = if selection::is_quiet(best, &selection.rest) {
        Vec::new()
    } else {
        discrepancies::beside_effects(case, best)
    };
    let rest_gain = beside.first().map_or(0.0, |strongest| strongest.gain.max(0.0));
    let structure = beside.first().is_some_and(|f| {
        f.gain > STRUCTURE.max(2.0 * acceptance.gain) && (f.predictive > 0.1 * f.gain || f.gain > 250.0)
    });
    let recovered = if gain + rest_gain > 0.0 { gain / (gain + rest_gain) } else { 1.0 };
    let doubtful = best.tolerance > 0 || structure || best.fitted.shape.effects.len() > 1 || on_bound(best);
    let left = if named { localise::share_left(places, &selection.rest) } else { 1.0 };
    let alone = places.first().is_some_and(|w| w.evidence > LEFT_ALONE);
    let ask = if named { doubtful } else { structure || alone };
    let instead =
        if ask { discrepancies::instead_of_effects(case, &selection.base, likely) } else { Vec::new() };
    let outdone = instead.first().is_some_and(|(_, evidence)| *evidence > OUTDONE * gain + STRUCTURE);
    let fits_place = best.fitted.shape.effects.iter().any(|e| localise::may_act_at(e.spec.term, likely));
    let too_little = recovered < RECOVERED || (on_bound(best) && recovered < NEARLY_ALL);
    let verdict = match named {
        false if structure || alone => Verdict::Unknown,
        false => Verdict::None,
        true if outdone || left > 1.0 || (left > localise::MOST && !fits_place) => Verdict::Unknown,
        true if structure && too_little => Verdict::Unknown,
        true if left > localise::MOST || (structure && recovered < NEARLY_ALL) => Verdict::EffectsAndUnknown,
        true => Verdict::Effects,
    };
    // What makes the recordings less likely is no discrepancy, even at the likeliest place.
    let gains = instead.iter().any(|(_, evidence)| *evidence > 0.0);
    let kept = instead.into_iter().filter(|(_, evidence)| !gains || *evidence > 0.0);
    let mut instead: Vec<FittedDiscrepancy> = kept.map(|(discrepancy, _)| discrepancy).collect();
    let missing = match verdict {
        Verdict::Unknown if !instead.is_empty() => Some(instead.remove(0)),
        Verdict::Unknown | Verdict::EffectsAndUnknown if !beside.is_empty() => Some(beside.remove(0)),
        _ => None,
    };
    Judgement { verdict, recovered, left, missing, chance, beside, instead }
}

/// Whether an effect's strength sits on a bound.
fn on_bound(frozen: &FrozenFit) -> bool {
    (0..frozen.fitted.shape.effects.len()).any(|e| selection::is_on_bound(&frozen.fitted, e))
}
