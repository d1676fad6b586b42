//! Standardisation of features, and how familiar they are.

use nalgebra::DMatrix;
use railgrip_acoustics::{FEATURES, Features};

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
