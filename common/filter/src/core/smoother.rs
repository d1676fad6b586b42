//! Rauch–Tung–Striebel smoother: what the whole record says about each instant. For analysis after the fact.

use super::Gaussian;
use nalgebra::SMatrix;

/// One step of a forward pass, kept for the way back.
#[derive(Clone, Copy, Debug)]
pub struct SmootherStep<const N: usize> {
    /// Belief after the prediction to this instant.
    pub predicted: Gaussian<N>,
    /// Belief after the measurements of this instant.
    pub updated: Gaussian<N>,
    /// F of the prediction from the instant before.
    pub f: SMatrix<f64, N, N>,
}

/// Why a record cannot be smoothed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SmootherError {
    /// The predicted covariance of a step has no Cholesky factor.
    #[error("predicted covariance of step {step} is not positive definite")]
    NotPositiveDefinite {
        /// Index of the step.
        step: usize,
    },
}

/// Smooths a record, oldest step first (Simon, section 9.4.2).
///
/// # Errors
/// If a predicted covariance is not positive definite.
pub fn smooth<const N: usize>(steps: &[SmootherStep<N>]) -> Result<Vec<Gaussian<N>>, SmootherError> {
    let mut smoothed: Vec<Gaussian<N>> = steps.iter().map(|step| step.updated).collect();
    for index in (1..steps.len()).rev() {
        let later = &steps[index];
        let factor = (later.predicted.covariance.cholesky())
            .ok_or(SmootherError::NotPositiveDefinite { step: index })?;
        let here = steps[index - 1].updated;
        // gain = P Fᵀ P_predicted⁻¹, by a solve with the symmetric P_predicted.
        let gain = factor.solve(&(later.f * here.covariance)).transpose();
        let mut belief = here;
        belief.mean += gain * (smoothed[index].mean - later.predicted.mean);
        belief.covariance +=
            gain * (smoothed[index].covariance - later.predicted.covariance) * gain.transpose();
        belief.symmetrise();
        smoothed[index - 1] = belief;
    }
    Ok(smoothed)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Vector2};
    use rand::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn smoothing_halves_the_error_of_a_random_walk_in_velocity() {
        let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(7);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        let (dt, sigma) = (0.1, 0.5);
        let f = Matrix2::new(1.0, dt, 0.0, 1.0);
        let q = Matrix2::new(1e-4, 0.0, 0.0, 1e-2);
        let (mut truth, mut belief) =
            (Vector2::zeros(), Gaussian::<2>::independent(Vector2::zeros(), &Vector2::new(1.0, 1.0)));
        let (mut steps, mut truths) = (Vec::new(), Vec::new());
        for _ in 0..400 {
            truth = f * truth + Vector2::new(1e-2 * normal(), 1e-1 * normal());
            belief.predict(f * belief.mean, &f, &q);
            let predicted = belief;
            let update = belief.expect_component(0, truth[0] + sigma * normal(), sigma * sigma);
            belief.update_component(0, &update, sigma * sigma);
            steps.push(SmootherStep { predicted, updated: belief, f });
            truths.push(truth);
        }
        let rms = |beliefs: &[Gaussian<2>]| {
            let sum: f64 = beliefs.iter().zip(&truths).map(|(b, t)| (b.mean[0] - t[0]).powi(2)).sum();
            (sum / truths.len() as f64).sqrt()
        };
        let filtered: Vec<_> = steps.iter().map(|step| step.updated).collect();
        let smoothed = smooth(&steps).unwrap();
        let (before, after) = (rms(&filtered), rms(&smoothed));
        println!("position RMSE: filtered {before:.4}, smoothed {after:.4}");
        assert!(after < 0.7 * before);
        assert!(smoothed.iter().all(Gaussian::is_sound));
    }
}
