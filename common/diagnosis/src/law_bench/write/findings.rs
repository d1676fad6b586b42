//! Everything that was found out about a law-level case, ready to be written up.

use crate::answer::schema::Verdict;
use crate::law_bench::data::case::LawCase;
use crate::law_bench::decide::criteria::Criteria;
use crate::law_bench::decide::evidence::Gathered;
use crate::law_bench::decide::selection::Selection;
use crate::law_bench::decide::verdict::{Missing, Rule};
use crate::law_bench::fit::fitted::FittedModel;
use crate::law_bench::fit::left_out::Scheme;
use crate::law_bench::fit::noise::Noise;
use crate::law_bench::model::discrepancy::Discrepancy;

/// The findings.
pub struct Findings {
    /// The case.
    pub case: LawCase,
    /// Noise of the measured column, and where its sigma comes from.
    pub noise: Noise,
    /// Where sigma comes from, in words.
    pub sigma_source: &'static str,
    /// How points were left out.
    pub scheme: Scheme,
    /// The model without effects.
    pub calibrated: FittedModel,
    /// The effects that were selected.
    pub selection: Selection,
    /// The rule that decided.
    pub rule: &'static Rule,
    /// Share of the excess that the extended model removes.
    pub recovered: f64,
    /// The smooth discrepancy that shows best what is missing.
    pub missing: Option<Discrepancy>,
    /// Score of the best smooth discrepancy on what the extended model leaves, and what chance reaches.
    pub structure_score: f64,
    /// The score that chance reaches with the level's probability.
    pub structure_threshold: f64,
    /// The thresholds.
    pub criteria: Criteria,
}

impl Findings {
    /// Whether effects are named.
    pub fn names_effects(&self) -> bool {
        matches!(self.rule.verdict, Verdict::Effects | Verdict::EffectsAndUnknown)
    }

    /// The model that the report calls extended: the calibrated one where no effect is named.
    pub fn extended(&self) -> &FittedModel {
        if self.names_effects() { &self.selection.extended } else { &self.calibrated }
    }
}

/// The discrepancy that shows what a rule says is missing.
pub fn missing(rule: &Rule, gathered: Gathered) -> Option<Discrepancy> {
    match rule.missing {
        Missing::Nothing => None,
        Missing::BesideEffects => gathered.beside_effects,
        Missing::InsteadOfEffects => gathered.instead_of_effects,
        Missing::SimplerCause => gathered.simpler_cause,
    }
}
