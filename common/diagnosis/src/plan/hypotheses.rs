//! What a planned run is to tell apart.

use crate::answer::schema::Report;
use crate::decide::confidence::rivals;
use crate::decide::selection::Selection;
use crate::fit::candidate::Fitted;

/// A model that may be true.
#[derive(Clone, Debug)]
pub struct Hypothesis {
    /// Ids of its effects; empty for the calibrated model.
    pub effects: Vec<String>,
    /// Its probability among the hypotheses.
    pub p: f64,
    /// The model with the values that the recordings give it.
    pub(super) fitted: Fitted,
}

/// Most rivals that a run is to tell from the first hypothesis.
const RIVALS: usize = 3;
/// Share of the first one's evidence below which a further rival is out of the question. Set by hand, as all figures here.
const LEAST_SHARE: f64 = 0.3;
/// How quickly the probability of a rival falls with its share of the evidence: its power.
const SHARPNESS: i32 = 4;
/// Probability that is left to rivals of a certain finding: one that needs no test gets a mild one.
const LEAST_DOUBT: f64 = 0.02;

/// The likeliest first effect and its rivals; without a named effect the calibrated model and what comes nearest.
pub(super) fn of(selection: &Selection, report: &Report) -> Vec<Hypothesis> {
    let Some(round) = selection.rounds.first() else { return Vec::new() };
    let named = report.effects.iter().find(|effect| round.gains.iter().any(|gain| gain.id == effect.id));
    let mut hypotheses = Vec::new();
    let (first_id, first_p) = match named {
        Some(effect) => {
            let gain = round.of(&effect.id);
            let fitted = gain.map(|gain| gain.fitted.clone());
            let p = effect.confidence.clamp(LEAST_DOUBT, 1.0 - LEAST_DOUBT);
            hypotheses.extend(fitted.map(|fitted| Hypothesis {
                effects: vec![effect.id.clone()],
                p,
                fitted,
            }));
            (effect.id.clone(), p)
        }
        None => {
            let Some(top) = round.gains.iter().max_by(|a, b| a.score.total_cmp(&b.score)) else {
                return Vec::new();
            };
            let none = report.posterior.iter().find(|set| set.effects.is_empty() && !set.unknown);
            let p = none.map_or(0.5, |set| set.p).clamp(LEAST_DOUBT, 1.0 - LEAST_DOUBT);
            let fitted = selection.base.fitted.clone();
            hypotheses.push(Hypothesis { effects: Vec::new(), p, fitted });
            let best = Hypothesis { effects: vec![top.id.to_owned()], p: 0.0, fitted: top.fitted.clone() };
            hypotheses.push(best);
            (top.id.to_owned(), p)
        }
    };
    let near = rivals(round, &first_id).into_iter().enumerate();
    // The nearest one is asked about however far it is.
    let near = near.filter(|(k, (_, share))| *k == 0 || *share >= LEAST_SHARE).take(RIVALS);
    let mut shares: Vec<f64> = hypotheses.iter().skip(1).map(|_| 1.0).collect();
    for (_, (gain, share)) in near {
        shares.push(share.clamp(0.0, 1.0).powi(SHARPNESS).max(f64::MIN_POSITIVE));
        hypotheses.push(Hypothesis {
            effects: vec![gain.id.to_owned()],
            p: 0.0,
            fitted: gain.fitted.clone(),
        });
    }
    let total: f64 = shares.iter().sum();
    for (hypothesis, share) in hypotheses.iter_mut().skip(1).zip(&shares) {
        hypothesis.p = (1.0 - first_p) * share / total;
    }
    hypotheses
}
