//! A trained model: standardisation, network, and what it was trained on. Its file is the business of [`crate::file`].

use crate::network::Network;
use crate::standard::Standard;
use railgrip_acoustics::{FEATURES, Features};
use serde::{Deserialize, Serialize};

/// What a model was trained on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Seed of everything random.
    pub seed: u64,
    /// Clips learnt from.
    pub clips: usize,
    /// Passes over them.
    pub epochs: usize,
    /// Rigs that they come from.
    pub rigs: Vec<String>,
    /// Share of clips told right among those set aside while training.
    pub validation_accuracy: f64,
}

/// A trained model.
#[derive(Clone, Debug)]
pub struct Model {
    pub(crate) standard: Standard,
    pub(crate) network: Network,
    provenance: Provenance,
}

impl Model {
    pub(crate) const fn of(standard: Standard, network: Network, provenance: Provenance) -> Self {
        Self { standard, network, provenance }
    }

    /// What it was trained on.
    pub const fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// Probability that the rail is wet, of each window.
    pub fn wet_probabilities(&self, windows: &[Features]) -> Vec<f64> {
        let rows: Vec<[f32; FEATURES]> = windows.iter().map(|window| self.standard.apply(window)).collect();
        self.network.wet(&rows)
    }

    /// True if the model has heard the like.
    pub fn is_familiar(&self, window: &Features) -> bool {
        self.standard.distance(&self.standard.apply(window)) <= self.standard.familiar
    }
}
