//! Whether stated confidences and intervals mean what they say.

use serde::Serialize;

use super::{
    answer::Named,
    score::{Outcome, Rate},
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

/// How a fitted parameter compares with the true one.
pub(super) struct Agreement {
    pub relative_error: f64,
    pub in_ci95: bool,
    pub in_90: bool,
}

/// Effects whose form in the plant is that of the catalogue: id, the plant's parameter, the catalogue's, and what to add
/// to the plant's value.
const AGREEING: [(&str, &str, &str, f64); 6] = [
    ("wheel_radius", "relative", "relative_error", 0.0),
    ("mass_error", "relative", "relative_error", 0.0),
    ("rotating_inertia", "relative", "relative_error", 0.0),
    ("load_transfer", "factor", "relative_error", -1.0),
    ("dragging_brake", "torque_nm", "torque_nm", 0.0),
    ("wheel_encoder_window", "window_s", "window_s", 0.0),
];

/// Compares the fitted parameter with the true one where the first name is right and the forms agree.
pub(super) fn agreement(outcome: &Outcome) -> Option<Agreement> {
    let truth = outcome.made.label.effects.first()?;
    let (_, plants, catalogues, offset) = AGREEING.iter().find(|(id, ..)| *id == truth.id)?;
    let named = outcome.effects().iter().find(|named| named.id == truth.id)?;
    let value = truth.parameters.iter().find(|(name, _)| name == plants)?.1 + offset;
    let (fitted, low, high) = *named.parameters.get(*catalogues)?;
    let narrow = 1.645 / 1.96;
    Some(Agreement {
        relative_error: ((fitted - value) / value).abs(),
        in_ci95: (low..=high).contains(&value),
        in_90: (fitted + narrow * (low - fitted)..=fitted + narrow * (high - fitted)).contains(&value),
    })
}
