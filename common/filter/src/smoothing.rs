//! Fixed-interval smoothing of a recording by any filter whose belief is one Gaussian: Rauch, Tung & Striebel, as in Simon,
//! Optimal State Estimation (2006), section 9.4.2.
//!
//! The way back needs, for each sample, the belief before and after its measurements and the covariance between the
//! state before and after the prediction (P Fᵀ of an extended filter; the same from sigma points of an unscented one).
//! Only checkpoints are kept on the way forward; each block is run once more on the way back, so that memory does not
//! grow with the matrices of the whole record. Where a filter starts anew, smoothing starts anew.

use crate::trace::StepTrace;
use crate::{Estimator, EstimatorInput, EstimatorOutput, FilterError};
use nalgebra::{DMatrix, DVector};

/// Samples between two checkpoints.
const BLOCK: usize = 1024;

/// Belief about one sample from the whole record.
#[derive(Clone, Debug)]
pub struct SmoothedStep {
    /// Mean.
    pub mean: DVector<f64>,
    /// Covariance.
    pub covariance: DMatrix<f64>,
}

/// Runs `estimator` over a record and back: one estimate a sample. The estimator ends as after the way forward.
///
/// # Errors
/// A filter that cannot be smoothed, or a covariance that lost its positive definiteness.
pub fn smooth_record(
    estimator: &mut Box<dyn Estimator>,
    inputs: &[EstimatorInput],
) -> Result<Vec<EstimatorOutput>, FilterError> {
    let name = estimator.snapshot().filter;
    let mut checkpoints = Vec::with_capacity(inputs.len() / BLOCK + 1);
    for (index, input) in inputs.iter().enumerate() {
        if index % BLOCK == 0 {
            checkpoints.push(estimator.boxed_clone());
        }
        estimator.step(input);
    }
    let mut outputs = vec![EstimatorOutput::default(); inputs.len()];
    // The smoothed belief of the sample after the present one, and that sample's trace.
    let mut later: Option<(SmoothedStep, StepTrace)> = None;
    for (block, mut checkpoint) in checkpoints.into_iter().enumerate().rev() {
        let from = block * BLOCK;
        let to = (from + BLOCK).min(inputs.len());
        let mut traces = Vec::with_capacity(to - from);
        for input in &inputs[from..to] {
            let trace = checkpoint.traced_step(input);
            traces.push(trace.ok_or_else(|| FilterError::NotSmoothable(name.clone()))?);
        }
        for (offset, trace) in traces.into_iter().enumerate().rev() {
            let smoothed =
                step_back(&trace, later.as_ref()).ok_or(FilterError::SmoothingFailed(from + offset + 1))?;
            outputs[from + offset] =
                checkpoint.read_smoothed(&trace, smoothed.mean.as_slice(), smoothed.covariance.as_slice());
            later = Some((smoothed, trace));
        }
    }
    Ok(outputs)
}

/// The smoothed belief of a sample, given that of the one after it.
fn step_back(trace: &StepTrace, later: Option<&(SmoothedStep, StepTrace)>) -> Option<SmoothedStep> {
    let (mut mean, mut covariance) = (trace.mean.clone(), trace.covariance.clone());
    if let Some((smoothed, next)) = later.filter(|(_, next)| !next.begins) {
        // gain = P Fᵀ P_predicted⁻¹, by a solve with the symmetric P_predicted scaled to a unit diagonal.
        let scale = next.predicted_covariance.diagonal().map(|v| 1.0 / v.max(1e-300).sqrt());
        let scaled =
            DMatrix::from_diagonal(&scale) * &next.predicted_covariance * DMatrix::from_diagonal(&scale);
        let factor = scaled.cholesky()?;
        let right = DMatrix::from_diagonal(&scale) * next.cross.transpose();
        let gain = (DMatrix::from_diagonal(&scale) * factor.solve(&right)).transpose();
        mean += &gain * (&smoothed.mean - &next.predicted_mean);
        covariance += &gain * (&smoothed.covariance - &next.predicted_covariance) * gain.transpose();
        covariance = 0.5 * (&covariance + covariance.transpose());
    }
    Some(SmoothedStep { mean, covariance })
}
