//! The answer to a case: what departs, how far it shows, and how the plant was built.

use serde::{Deserialize, Serialize};

/// Gap on both sets of runs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Gaps {
    /// On the runs that may be fitted.
    pub fit: f64,
    /// On the runs that may only be predicted.
    pub holdout: f64,
}

/// One departure in a label.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LabelledEffect {
    /// Id of the contract or the plant's own name.
    pub id: String,
    /// Term of the equations.
    pub term: String,
    /// Whether the contract has an id for it.
    pub named: bool,
    /// Functional form; empty where the plant has one only.
    #[serde(default)]
    pub form: String,
    /// Set of the form; empty where there are no sets.
    #[serde(default)]
    pub set: String,
    /// Size over the usual one.
    #[serde(default)]
    pub strength: f64,
    /// Size and shape in the plant's own terms.
    pub parameters: Vec<(String, f64)>,
    /// Gap of the calibrated nominal model on the case without this effect and with all others; absent where there is no other.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap_without: Option<Gaps>,
}

/// How a plant of the family was built.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlantOf {
    /// Set of all its forms.
    pub set: String,
    /// Creep law.
    pub creep_law: String,
    /// Integration.
    pub integrator: String,
    /// Kinds of sensor noise.
    pub noise: Vec<String>,
    /// Level of the noise over the sheet's.
    pub noise_level: f64,
    /// Samples a second.
    pub rate_hz: f64,
    /// Number of wheelsets.
    pub wheelsets: usize,
    /// Mass of the sheet, kg.
    pub mass_kg: f64,
    /// Whether drive torque is recorded.
    pub motored: bool,
    /// Whether position is recorded.
    pub has_position: bool,
    /// Whether it has slide protection.
    pub protected: bool,
    /// Rail classes of the runs.
    pub rails: Vec<String>,
    /// Runs to fit on.
    pub fit_runs: usize,
    /// Runs to predict.
    pub holdout_runs: usize,
    /// Recorded time, s.
    pub seconds: f64,
}

/// The answer to a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Label {
    /// Name of the case.
    pub case: String,
    /// Family or class of the vehicle.
    pub vehicle: String,
    /// What departs.
    pub effects: Vec<LabelledEffect>,
    /// Gap of the calibrated nominal model.
    pub gap_calibrated: Gaps,
    /// The same on the twin without the effect: what a perfect diagnosis leaves.
    pub gap_without_the_effect: Gaps,
    /// How the plant was built, where it is one of the family.
    #[serde(default)]
    pub plant: Option<PlantOf>,
}

impl Label {
    /// Whether any effect is one that no id names.
    #[must_use]
    pub fn has_nameless(&self) -> bool {
        self.effects.iter().any(|effect| !effect.named)
    }

    /// How far the effects show: the calibrated gap over the twin's, on the runs that may be fitted. About 1 where there is
    /// nothing to see.
    #[must_use]
    pub fn salience(&self) -> f64 {
        self.gap_calibrated.fit / self.gap_without_the_effect.fit
    }

    /// The same of one effect of several: the calibrated gap over that with all others.
    #[must_use]
    pub fn salience_of(&self, effect: &LabelledEffect) -> f64 {
        effect.gap_without.map_or_else(|| self.salience(), |without| self.gap_calibrated.fit / without.fit)
    }
}
