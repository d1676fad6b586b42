//! Evidence for the verdict: what chance would gain, what the effects leave, and what a curve would explain beside them or
//! instead of them.

use crate::answer::schema::Evidence;
use crate::decide::acceptance::is_quiet;
use crate::decide::criteria::Criteria;
use crate::decide::selection::Selection;
use crate::decide::significance::Chance;
use crate::decide::verdict::{Decision, Missing, decide};
use crate::fit::discrepancies::{self, FittedDiscrepancy};
use crate::predict::localise;
use railgrip_vehicle::effects::Term;

/// What was concluded, and from what.
#[derive(Debug)]
pub struct Judgement {
    /// The verdict, and the rule that led to it.
    pub decision: Decision,
    /// What it rests on.
    pub evidence: Evidence,
    /// What is missing, for unknown and for effects with a rest.
    pub missing: Option<FittedDiscrepancy>,
    /// The terms that it may be in, the likeliest first.
    pub missing_terms: Vec<Term>,
    /// Whether it stands instead of the effects and not beside them.
    is_missing_instead: bool,
    /// The test against chance.
    pub chance: Option<Chance>,
    /// Flexible discrepancies on top of the best model, strongest first.
    pub beside: Vec<FittedDiscrepancy>,
    /// Flexible discrepancies at likely places on top of the nuisances alone, strongest first; empty unless in doubt.
    pub instead: Vec<FittedDiscrepancy>,
}

impl Judgement {
    /// Takes what the decision says is missing out of the discrepancies, and puts back what was missing by the decision before it. The terms
    /// that it may be in are those whose curves explain at least a share `tie` of what it explains.
    pub(crate) fn sort_missing(&mut self, tie: f64) {
        let taken_from = if self.is_missing_instead { &mut self.instead } else { &mut self.beside };
        taken_from.splice(0..0, self.missing.take());
        self.missing_terms.clear();
        let wanted = self.decision.rule.missing;
        self.is_missing_instead = wanted == Missing::InsteadOfEffects && !self.instead.is_empty();
        let from = if self.is_missing_instead { &mut self.instead } else { &mut self.beside };
        if wanted == Missing::Nothing || from.is_empty() {
            return;
        }
        let missing = from.remove(0);
        self.missing_terms.push(missing.discrepancy.term);
        for other in from.iter().filter(|other| other.score >= tie * missing.score) {
            if !self.missing_terms.contains(&other.discrepancy.term) {
                self.missing_terms.push(other.discrepancy.term);
            }
        }
        self.missing = Some(missing);
    }
}

/// Judges the outcome of the selection: gathers evidence and decides.
pub fn judge(selection: &Selection, criteria: &Criteria, seed: u64) -> Judgement {
    let chance = selection.rounds.first().map(|round| {
        let nuisances = selection.base.fitted.shape.nuisance_count();
        Chance::new(round, nuisances, &selection.best, criteria, seed)
    });
    let quiet = is_quiet(&selection.best, &selection.rest, &criteria.localisation);
    let beside =
        if quiet { Vec::new() } else { discrepancies::beside_effects(&selection.best, &criteria.pursuit) };
    let mut evidence =
        without_instead(selection, criteria, chance.as_ref().map_or(0.0, Chance::threshold), &beside);
    let likely = localise::likely(&selection.places, criteria.localisation.likely_share);
    let instead = if is_doubtful(selection, &evidence, criteria) {
        let fit = || discrepancies::instead_of_effects(&selection.base, likely, &criteria.pursuit);
        selection.instead.get_or_init(fit).clone()
    } else {
        Vec::new()
    };
    if let Some((discrepancy, gained)) = instead.first() {
        let effects = &selection.best.fitted.shape.effects;
        evidence.instead_evidence = Some(*gained);
        evidence.instead_at_effects = effects.iter().any(|e| e.spec.term == discrepancy.discrepancy.term);
        evidence.instead_at_strongest =
            selection.strongest().is_some_and(|e| e.spec.term == discrepancy.discrepancy.term);
    }
    let decision = decide(&evidence, criteria);
    let mut judgement = Judgement {
        decision,
        evidence,
        missing: None,
        missing_terms: Vec::new(),
        is_missing_instead: false,
        chance,
        beside,
        instead: likelier(instead),
    };
    judgement.sort_missing(criteria.ties.look_alike);
    judgement
}

/// All evidence but that of curves instead of the effects, which cost most to fit.
fn without_instead(
    selection: &Selection,
    criteria: &Criteria,
    alarm: f64,
    beside: &[FittedDiscrepancy],
) -> Evidence {
    let (base, best) = (&selection.base, &selection.best);
    let effects = &best.fitted.shape.effects;
    let likely = localise::likely(&selection.places, criteria.localisation.likely_share);
    let strongest = beside.first();
    let mut evidence = Evidence {
        effects: effects.len(),
        gain: (base.evidence_cost() - best.evidence_cost()).max(0.0),
        alarm,
        on_bound: (0..effects.len()).any(|e| best.fitted.is_on_bound(e, &criteria.acceptance)),
        at_likely_place: effects.iter().any(|e| localise::may_act_at(e.spec.term, likely)),
        discrepancy_gain: strongest.map_or(0.0, |discrepancy| discrepancy.gain),
        discrepancy_predictive: strongest.map_or(0.0, |discrepancy| discrepancy.predictive),
        place_evidence: selection.places.first().map_or(0.0, |place| place.evidence),
        left: 1.0,
        instead_evidence: None,
        instead_at_effects: false,
        instead_at_strongest: false,
    };
    if evidence.is_named() {
        evidence.left = localise::share_left(&selection.places, &selection.rest, evidence.gain);
    }
    evidence
}

/// Whether curves instead of the effects are worth fitting: where something is wrong without a name, and where named effects
/// are several, leave something, need a tolerant filter or are as strong as they may be.
fn is_doubtful(selection: &Selection, evidence: &Evidence, criteria: &Criteria) -> bool {
    let structure = evidence.has_structure(criteria);
    if evidence.is_named() {
        structure || selection.best.tolerance > 0 || evidence.effects > 1 || evidence.on_bound
    } else {
        structure || evidence.has_place_alone(criteria)
    }
}

/// Discrepancies instead of the effects, scored by their evidence, without those that make the recordings less likely: these are none, even at
/// the likeliest place, unless all are such.
fn likelier(instead: Vec<(FittedDiscrepancy, f64)>) -> Vec<FittedDiscrepancy> {
    let gains = instead.iter().any(|(_, evidence)| *evidence > 0.0);
    let kept = instead.into_iter().filter(|(_, evidence)| !gains || *evidence > 0.0);
    kept.map(|(discrepancy, evidence)| FittedDiscrepancy { score: evidence, ..discrepancy }).collect()
}
