//! Interacting multiple models (Blom & Bar-Shalom, IEEE Trans. Automatic Control 33, 1988): filters with different
//! Q run side by side; each begins a step from a mixture of all beliefs, and each weighs as much as it foretold.
//!
//! Glossary: *mode* – one filter with its Q; *weight* – its probability.

use super::filter::{PadLaw, RigEkf, RigEstimate, Tuning};
use super::rig::RigSample;
use nalgebra::{Matrix4, Vector4};
use railgrip_filter::core::Gaussian;
use railgrip_vehicle::WagonModel;

/// Filters side by side.
pub struct MultipleModel<const K: usize> {
    modes: [RigEkf; K],
    weights: [f64; K],
    /// Probability to stay in a mode over one sample.
    stay: f64,
}

impl<const K: usize> MultipleModel<K> {
    /// Modes with these tunings, equally likely at first.
    pub fn new(model: &WagonModel, tunings: &[Tuning; K], stay: f64, first: &RigSample) -> Self {
        let modes = std::array::from_fn(|i| RigEkf::new(model, &tunings[i], PadLaw::Constant, first));
        Self { modes, weights: [1.0 / K as f64; K], stay }
    }

    /// Probability of each mode.
    pub fn weights(&self) -> &[f64; K] {
        &self.weights
    }

    /// Uses a sample.
    pub fn step(&mut self, sample: &RigSample) -> RigEstimate {
        let expected = self.mix();
        let mut log_weights = [0.0; K];
        for (i, mode) in self.modes.iter_mut().enumerate() {
            mode.predict(sample);
            let (_, log_likelihood) = mode.update(sample);
            log_weights[i] = expected[i].ln() + log_likelihood;
        }
        let best = log_weights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let shares = log_weights.map(|value| (value - best).exp());
        let sum: f64 = shares.iter().sum();
        // A mode that is never likely must be able to come back.
        self.weights = shares.map(|share| (share / sum).max(1e-6));
        let beliefs: [Gaussian<4>; K] = std::array::from_fn(|i| self.modes[i].belief);
        self.modes[0].read(&mixture(&beliefs, &self.weights), f64::NAN)
    }

    /// Lets every mode begin from the mixture that could have led into it; the modes' expected weights.
    fn mix(&mut self) -> [f64; K] {
        let change = (1.0 - self.stay) / (K as f64 - 1.0).max(1.0);
        let beliefs: [Gaussian<4>; K] = std::array::from_fn(|i| self.modes[i].belief);
        let mut expected = [0.0; K];
        for (to, mode) in self.modes.iter_mut().enumerate() {
            let from: [f64; K] =
                std::array::from_fn(|i| self.weights[i] * if i == to { self.stay } else { change });
            expected[to] = from.iter().sum();
            mode.belief = mixture(&beliefs, &from);
        }
        expected
    }
}

/// One Gaussian with mean and covariance of a weighted sum of Gaussians; weights need not add up to one.
fn mixture<const K: usize>(beliefs: &[Gaussian<4>; K], weights: &[f64; K]) -> Gaussian<4> {
    let sum: f64 = weights.iter().sum();
    let mut mean = Vector4::zeros();
    for (belief, weight) in beliefs.iter().zip(weights) {
        mean += belief.mean * (weight / sum);
    }
    let mut covariance = Matrix4::zeros();
    for (belief, weight) in beliefs.iter().zip(weights) {
        let apart = belief.mean - mean;
        covariance += (belief.covariance + apart * apart.transpose()) * (weight / sum);
    }
    Gaussian { mean, covariance }
}

/// Runs multiple models over a test.
pub fn estimate<const K: usize>(
    model: &WagonModel,
    tunings: &[Tuning; K],
    stay: f64,
    samples: &[RigSample],
) -> Vec<RigEstimate> {
    let Some(first) = samples.first() else { return Vec::new() };
    let mut filter = MultipleModel::new(model, tunings, stay, first);
    samples.iter().map(|sample| filter.step(sample)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::roller::filter;
    use crate::roller::rig::{RigSensors, Test, nominal_model, simulate};

    #[test]
    fn equal_modes_are_one_filter() {
        let samples = simulate(Test::Sanding, 1, RigSensors::SERVICE);
        let tuning = Tuning { q: [1e-1, 1e-5, 1e-4, 1e-2], r: [9e-4, 9e-4] };
        let model = nominal_model(Test::Sanding);
        let one = filter::estimate(&model, &tuning, PadLaw::Constant, &samples[..2000]);
        let two = estimate(&model, &[tuning; 2], 0.98, &samples[..2000]);
        for (one, two) in one.iter().zip(&two) {
            assert!((one.adhesion - two.adhesion).abs() < 1e-9);
            assert!((one.adhesion_sigma - two.adhesion_sigma).abs() < 1e-9);
        }
    }
}
