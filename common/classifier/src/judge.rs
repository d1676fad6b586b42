//! How often the network is right.

use crate::dataset::Example;
use crate::{Condition, Model};

/// Counts of what was and what was said; and how far probabilities lie from the truth.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Confusion {
    /// Dry, said dry.
    pub dry_dry: usize,
    /// Dry, said wet.
    pub dry_wet: usize,
    /// Wet, said dry.
    pub wet_dry: usize,
    /// Wet, said wet.
    pub wet_wet: usize,
    /// Clips that the model finds unfamiliar; they count above as well.
    pub unfamiliar: usize,
    /// Mean squared error of the probability (Brier score): 0 perfect, 0.25 for always saying 0.5.
    pub brier: f64,
}

impl Confusion {
    /// Of a model on examples.
    pub fn of(model: &Model, examples: &[Example]) -> Self {
        let features: Vec<_> = examples.iter().map(|example| example.features).collect();
        let mut confusion = Self::default();
        for (example, wet) in examples.iter().zip(model.wet_probabilities(&features)) {
            let truth = example.condition == Condition::Wet;
            match (truth, wet > 0.5) {
                (false, false) => confusion.dry_dry += 1,
                (false, true) => confusion.dry_wet += 1,
                (true, false) => confusion.wet_dry += 1,
                (true, true) => confusion.wet_wet += 1,
            }
            confusion.unfamiliar += usize::from(!model.is_familiar(&example.features));
            confusion.brier += (wet - f64::from(u8::from(truth))).powi(2) / examples.len().max(1) as f64;
        }
        confusion
    }

    /// Clips.
    pub const fn total(&self) -> usize {
        self.dry_dry + self.dry_wet + self.wet_dry + self.wet_wet
    }

    /// Share told right.
    pub fn accuracy(&self) -> f64 {
        (self.dry_dry + self.wet_wet) as f64 / self.total().max(1) as f64
    }
}
