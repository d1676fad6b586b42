//! How sure a named effect is: its rivals, the ids that the data cannot tell from it, and a probability.

use crate::decide::selection::{Gain, Round};

/// How well the other candidates of a round do beside the one named `id`, best first: by the evidence that they gain with
/// a filter of their own if they were carried so far, else by their score.
pub fn rivals<'a>(round: &'a Round, id: &str) -> Vec<(&'a Gain, f64)> {
    let Some(own) = round.gains.iter().find(|g| g.id == id) else { return Vec::new() };
    let top = round.gains.iter().max_by(|a, b| a.score().total_cmp(&b.score())).unwrap_or(own);
    let settled = |other: &Gain| {
        let (other, own) = (round.own_filter_gain(other.id)?, round.own_filter_gain(id)?);
        Some(other / own.max(1.0))
    };
    let scale = settled(top).unwrap_or(1.0).clamp(0.0, 1.0) / top.score().max(1.0);
    let ratio = |g: &Gain| settled(g).unwrap_or(scale * g.score());
    let mut rivals: Vec<(&Gain, f64)> =
        round.gains.iter().filter(|g| g.id != id).map(|g| (g, ratio(g))).collect();
    rivals.sort_by(|a, b| b.1.total_cmp(&a.1));
    rivals
}

/// Share of the named effect's score from which a rival counts as inseparable.
pub const TIE: f64 = 0.93;

/// Ids that the data cannot tell from `id`.
pub fn equivalents(round: &Round, id: &str, twins: &[&str]) -> Vec<String> {
    let span_same_model = |a: &str, b: &str| {
        let pair = [a, b];
        pair.contains(&"headwind") && pair.contains(&"running_resistance")
    };
    rivals(round, id)
        .into_iter()
        .filter(|(g, ratio)| {
            let tie = if span_same_model(id, g.id) {
                0.6
            } else if twins.contains(&g.id) {
                TIE - 0.05
            } else {
                TIE
            };
            *ratio >= tie
        })
        .map(|(g, _)| g.id.to_owned())
        .collect()
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
    pub mends: bool,
}

/// Probability that a named effect is right. The logistic is set by hand from some forty simulated cases whose answer is
/// known, not fitted; `railgrip gap blind` prints how often verdicts at each confidence are right.
pub fn confidence(standing: Standing) -> f64 {
    let Standing { recovered, left, rival, gain, mends } = standing;
    let margin = 3.8 + 3.0 * (recovered.max(0.5) - 0.95) - 4.5 * left.min(1.0) - 5.0 * (rival - 0.6).max(0.0)
        + 0.4 * (gain.max(1.0) / 300.0).ln().clamp(-2.0, 1.0)
        - if mends { 1.5 } else { 0.0 };
    (1.0 / (1.0 + (-margin).exp())).clamp(0.1, 0.985)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SURE: Standing = Standing { recovered: 1.0, left: 0.0, rival: 0.1, gain: 1e4, mends: false };

    #[test]
    fn confidence_is_a_probability_whatever_the_gain() {
        for gain in [-1e5, 0.0, 1e-9, 1e9] {
            let confidence = confidence(Standing { gain, ..SURE });
            assert!((0.0..=1.0).contains(&confidence), "{confidence} at {gain}");
        }
    }

    #[test]
    fn a_close_rival_and_a_rest_cost_confidence() {
        let sure = confidence(SURE);
        for worse in [
            Standing { rival: 0.92, ..SURE },
            Standing { left: 0.5, ..SURE },
            Standing { recovered: 0.6, ..SURE },
            Standing { mends: true, ..SURE },
        ] {
            assert!(confidence(worse) < sure - 0.005, "{worse:?}");
        }
    }
}
