//! How sure a named effect is, and which others the data cannot tell from it.

use super::criteria::Criteria;
use super::selection::SelectedEffect;
use crate::law_bench::model::candidates::CandidateSpec;

/// Probability that `effect` is right: that it is no chance, times the share of the excess that the named effects remove,
/// divided among the rivals by how close they come.
pub fn confidence(effect: &SelectedEffect, recovered: f64, criteria: &Criteria) -> f64 {
    let weights: f64 = effect.rivals.iter().map(|(_, behind)| (-behind / criteria.evidence_unit).exp()).sum();
    let confidence = (1.0 - effect.p_value) * recovered.clamp(0.0, 1.0) / (1.0 + weights);
    confidence.clamp(criteria.least_sure, criteria.surest)
}

/// Candidates that the data cannot tell from `effect`, closest first.
pub fn tied(effect: &SelectedEffect, criteria: &Criteria) -> Vec<&'static CandidateSpec> {
    let close = effect.rivals.iter().filter(|(_, behind)| *behind < criteria.tie);
    close.map(|(rival, _)| *rival).collect()
}
