//! Whether stated confidences and intervals mean what they say.

use railgrip_diagnosis::decide::learning::{TrueValue, area};
use railgrip_truth_plant::label::LabelledEffect;
use serde::Serialize;

use super::{
    answer::Named,
    meaning,
    outcome::{Outcome, Rate},
};

/// One bin of stated confidence.
#[derive(Debug, Clone, Serialize)]
pub(super) struct Bin {
    /// Range of stated confidence.
    pub range: (f64, f64),
    /// Mean of what was stated.
    pub stated: f64,
    /// How often it was right.
    pub right: Rate,
}

/// How often first names are right, by stated confidence. A name given to an unknown or to nothing is wrong.
pub(super) fn reliability(outcomes: &[Outcome]) -> Vec<Bin> {
    const EDGES: [f64; 6] = [0.0, 0.5, 0.7, 0.85, 0.95, 1.000_001];
    let bin = |range: &[f64]| {
        let inside = |named: &Named| (range[0]..range[1]).contains(&named.confidence);
        let named =
            outcomes.iter().filter_map(|o| Some((o, o.effects().first()?))).filter(|(_, n)| inside(n));
        let (mut stated, mut right) = (0.0, Rate::default());
        for (outcome, named) in named {
            stated += named.confidence;
            right = right.and(outcome.made.nameable().iter().any(|id| named.is(id)));
        }
        Bin { range: (range[0], range[1].min(1.0)), stated: stated / right.of as f64, right }
    };
    EDGES.windows(2).map(bin).collect()
}

/// What stated probabilities are worth, over all cases.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Beliefs {
    /// Expected calibration error of names, first and further: mean distance between stated and observed, in five bins.
    pub calibration_error: f64,
    /// Names that were given.
    pub names: usize,
    /// Verdict sets that hold the truth; nothing holds where nothing can be seen, and what cannot be seen beside others may be missing.
    pub sets_hold: Rate,
    /// Mean number of sets in a verdict set.
    pub mean_size: f64,
    /// How well the probability of something unknown sorts the cases that visibly hold such from the others: area under the
    /// curve of the receiver.
    pub unknown_area: f64,
}

/// See [`Beliefs`].
pub(super) fn beliefs(outcomes: &[Outcome]) -> Beliefs {
    const BINS: usize = 5;
    let mut off = [0.0; BINS];
    let mut names = 0;
    let (mut sets_hold, mut sizes) = (Rate::default(), 0);
    let mut stated = [Vec::new(), Vec::new()];
    for outcome in outcomes {
        let Some(answer) = &outcome.answer else { continue };
        let (nameable, showing) = (outcome.made.nameable(), outcome.made.showing());
        for named in &answer.effects {
            let right = nameable.iter().any(|id| named.is(id));
            off[((named.confidence * BINS as f64) as usize).min(BINS - 1)] +=
                named.confidence - f64::from(u8::from(right));
            names += 1;
        }
        let is_nothing = outcome.made.label.effects.is_empty() || !outcome.is_visible();
        sets_hold = sets_hold.and(answer.held().any(|set| {
            (is_nothing && set.effects.is_empty() && !set.unknown)
                || (set.unknown == outcome.made.is_unknown()
                    && (set.unknown || !set.effects.is_empty())
                    && set.effects.iter().all(|id| nameable.contains(&id.as_str()))
                    && showing.iter().all(|id| set.effects.iter().any(|listed| listed == id)))
        }));
        sizes += answer.verdict_set.len();
        let holds_unknown = outcome.made.is_unknown() && outcome.is_visible();
        stated[usize::from(holds_unknown)].push(answer.unknown());
    }
    Beliefs {
        calibration_error: off.iter().map(|off: &f64| off.abs()).sum::<f64>() / names as f64,
        names,
        sets_hold,
        mean_size: sizes as f64 / sets_hold.of as f64,
        unknown_area: area(&stated[1], &stated[0]),
    }
}

/// How a fitted parameter compares with the true one.
pub(super) struct Agreement {
    pub relative_error: f64,
    pub in_ci95: bool,
    pub in_90: bool,
}

/// Compares the fitted parameters of the true effects that were named with the true ones, where they mean the same.
pub(super) fn agreements(outcome: &Outcome) -> Vec<Agreement> {
    let compare = |truth: &LabelledEffect| {
        let TrueValue { effect, parameter, value } = meaning::true_value(truth)?;
        let named = outcome.effects().iter().find(|named| named.id == effect)?;
        let (fitted, low, high) = *named.parameters.get(parameter)?;
        let narrow = 1.645 / 1.96;
        Some(Agreement {
            relative_error: ((fitted - value) / value).abs(),
            in_ci95: (low..=high).contains(&value),
            in_90: (fitted + narrow * (low - fitted)..=fitted + narrow * (high - fitted)).contains(&value),
        })
    };
    outcome.made.label.effects.iter().filter_map(compare).collect()
}
