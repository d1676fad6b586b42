//! How sure a named effect is: its rivals, the ids that the data cannot tell from it, and a score.

use crate::decide::criteria::{ConfidenceModel, Ties};
use crate::decide::round::{Gain, Round};
use railgrip_vehicle::effects::{EffectSpec, Likeness};

/// How well the other candidates of a round do beside the one named `id`, best first: by the evidence that they gain with
/// a filter of their own if they were carried so far, else by their score.
pub fn rivals<'a>(round: &'a Round, id: &str) -> Vec<(&'a Gain, f64)> {
    let Some(own) = round.of(id) else { return Vec::new() };
    let top = round.gains.iter().max_by(|a, b| a.score.total_cmp(&b.score)).unwrap_or(own);
    let by_evidence = |other: &Gain| {
        let (other, own) = (round.own_filter_gain(other.id)?, round.own_filter_gain(id)?);
        Some(other / own.max(1.0))
    };
    let scale = by_evidence(top).unwrap_or(1.0).clamp(0.0, 1.0) / top.score.max(1.0);
    let ratio = |g: &Gain| by_evidence(g).unwrap_or(scale * g.score);
    let mut rivals: Vec<(&Gain, f64)> =
        round.gains.iter().filter(|g| g.id != id).map(|g| (g, ratio(g))).collect();
    rivals.sort_by(|a, b| b.1.total_cmp(&a.1));
    rivals
}

/// Ids that the data cannot tell from the effect of `spec`.
pub fn equivalents(round: &Round, spec: &EffectSpec, ties: &Ties) -> Vec<String> {
    let tie = |id: &str| match spec.twins.iter().find(|twin| twin.id == id).map(|twin| twin.likeness) {
        Some(Likeness::SameModel) => ties.same_model,
        Some(Likeness::LookAlike) => ties.look_alike,
        None => ties.any,
    };
    let tied = rivals(round, spec.id).into_iter().filter(|(g, ratio)| *ratio >= tie(g.id));
    tied.map(|(g, _)| g.id.to_owned()).collect()
}

/// What a named effect's confidence follows from.
#[derive(Clone, Copy, Debug)]
pub struct Standing {
    /// Share of the explainable that the named effects recover.
    pub recovered: f64,
    /// Share of what freeing the likeliest place gains that they leave.
    pub left: f64,
    /// Score of the best rival that is not declared equivalent, relative to the effect's own.
    pub rival: f64,
    /// Log-likelihood gained by the effect.
    pub gain: f64,
    /// Whether an effect named before it may show at the same place.
    pub at_same_place: bool,
}

/// Log-odds that a named effect is right, before they are calibrated.
pub fn score(standing: Standing, model: &ConfidenceModel) -> f64 {
    let Standing { recovered, left, rival, gain, at_same_place } = standing;
    let [least_log, most_log] = model.log_gain_limits;
    model.base + model.per_recovered * (recovered.max(model.least_recovered) - model.usual_recovered)
        - model.per_left * left.min(1.0)
        - model.per_rival * (rival - model.harmless_rival).max(0.0)
        + model.per_log_gain * (gain.max(1.0) / model.usual_gain).ln().clamp(least_log, most_log)
        - if at_same_place { model.at_same_place } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SURE: Standing =
        Standing { recovered: 1.0, left: 0.0, rival: 0.1, gain: 1e4, at_same_place: false };

    fn of(standing: Standing) -> f64 {
        score(standing, &ConfidenceModel::default())
    }

    #[test]
    fn a_score_is_a_number_whatever_the_gain() {
        for gain in [-1e5, 0.0, 1e-9, 1e9] {
            let score = of(Standing { gain, ..SURE });
            assert!(score.abs() < 10.0, "{score} at {gain}");
        }
    }

    #[test]
    fn a_close_rival_and_a_rest_cost_confidence() {
        let sure = of(SURE);
        for worse in [
            Standing { rival: 0.92, ..SURE },
            Standing { left: 0.5, ..SURE },
            Standing { recovered: 0.6, ..SURE },
            Standing { at_same_place: true, ..SURE },
        ] {
            assert!(of(worse) < sure - 0.1, "{worse:?}");
        }
    }
}
