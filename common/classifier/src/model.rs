//! A trained model: standardisation, network, and what it was trained on.

use crate::file::Provenance;
use crate::network::{Layer, Network};
use crate::{ModelError, file};
use nalgebra::DMatrix;
use railgrip_acoustics::{FEATURES, Features};
use std::path::Path;

/// The model that is part of the program: what `railgrip acoustics train` makes without options.
const BUILT_IN: &[u8] = include_bytes!("../models/default.safetensors");

/// How features become numbers about zero, and how far from the usual they are.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Standard {
    /// Mean of each feature in training.
    pub mean: Vec<f32>,
    /// Standard deviation of each feature in training.
    pub sigma: Vec<f32>,
    /// Inverse of the covariance of standardised features, row by row.
    pub precision: Vec<f32>,
    /// Largest mean square of a Mahalanobis distance that is still familiar.
    pub familiar: f32,
}

impl Standard {
    /// From training examples.
    pub fn of(examples: &[Features]) -> Self {
        let count = examples.len() as f64;
        let mean: [f64; FEATURES] =
            std::array::from_fn(|k| examples.iter().map(|features| features[k]).sum::<f64>() / count);
        let sigma: [f64; FEATURES] = std::array::from_fn(|k| {
            let sum: f64 = examples.iter().map(|features| (features[k] - mean[k]).powi(2)).sum();
            (sum / count).sqrt().max(1e-9)
        });
        let single = |values: [f64; FEATURES]| values.map(|value| value as f32).to_vec();
        let mut standard = Self {
            mean: single(mean),
            sigma: single(sigma),
            precision: vec![0.0; FEATURES * FEATURES],
            familiar: f32::INFINITY,
        };
        let rows: Vec<[f32; FEATURES]> = examples.iter().map(|features| standard.apply(features)).collect();
        // A small ridge keeps the inverse bounded where features hang together.
        let mut covariance = DMatrix::<f64>::identity(FEATURES, FEATURES) * 1e-3;
        for row in &rows {
            for i in 0..FEATURES {
                for j in 0..FEATURES {
                    covariance[(i, j)] += f64::from(row[i]) * f64::from(row[j]) / count;
                }
            }
        }
        if let Some(factor) = covariance.cholesky() {
            let inverse = factor.inverse();
            standard.precision = inverse.transpose().iter().map(|value| *value as f32).collect();
        }
        let mut distances: Vec<f32> = rows.iter().map(|row| standard.distance(row)).collect();
        distances.sort_by(f32::total_cmp);
        let usual = distances.get(distances.len() * 999 / 1000).copied().unwrap_or(f32::INFINITY);
        standard.familiar = 4.0 * usual;
        standard
    }

    pub fn apply(&self, features: &Features) -> [f32; FEATURES] {
        std::array::from_fn(|k| (features[k] as f32 - self.mean[k]) / self.sigma[k])
    }

    /// Squared Mahalanobis distance over the number of features; about 1 for what training knew.
    pub fn distance(&self, row: &[f32; FEATURES]) -> f32 {
        let product = |i: usize| -> f32 {
            let line = &self.precision[i * FEATURES..(i + 1) * FEATURES];
            line.iter().zip(row).map(|(p, x)| p * x).sum()
        };
        (0..FEATURES).map(|i| row[i] * product(i)).sum::<f32>() / FEATURES as f32
    }
}

/// A trained model.
#[derive(Clone, Debug)]
pub struct Model {
    pub(crate) standard: Standard,
    pub(crate) network: Network,
    provenance: Provenance,
}

impl Model {
    pub(crate) fn of(standard: Standard, layers: &[Layer], provenance: Provenance) -> Self {
        Self { standard, network: Network::of(layers), provenance }
    }

    /// The model that is part of the program.
    ///
    /// # Errors
    /// Never, unless the program is damaged.
    pub fn built_in() -> Result<Self, ModelError> {
        file::decode("built-in model", BUILT_IN)
    }

    /// Reads a model.
    ///
    /// # Errors
    /// A file that cannot be read, is no model, has another version or is damaged.
    pub fn load(path: &Path) -> Result<Self, ModelError> {
        let bytes =
            std::fs::read(path).map_err(|source| ModelError::File { path: path.to_owned(), source })?;
        file::decode(&path.display().to_string(), &bytes)
    }

    /// Writes the model: beside first, then under its name, so that nobody reads half of it.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), ModelError> {
        let beside = path.with_extension("new");
        let bytes = file::encode(self)?;
        std::fs::write(&beside, bytes)
            .and_then(|()| std::fs::rename(&beside, path))
            .map_err(|source| ModelError::File { path: path.to_owned(), source })
    }

    /// What it was trained on.
    pub const fn provenance(&self) -> &Provenance {
        &self.provenance
    }

    /// Probability that the rail is wet, of each window.
    ///
    /// # Errors
    /// What the library of tensors refuses.
    pub fn wet_probabilities(&self, windows: &[Features]) -> Result<Vec<f64>, ModelError> {
        let rows: Vec<[f32; FEATURES]> = windows.iter().map(|window| self.standard.apply(window)).collect();
        self.network.wet(&rows)
    }

    /// True if the model has heard the like.
    pub fn is_familiar(&self, window: &Features) -> bool {
        self.standard.distance(&self.standard.apply(window)) <= self.standard.familiar
    }
}
