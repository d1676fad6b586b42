//! What a filter leaves of each sample for smoothing on the way back.

use crate::EstimatorOutput;
use crate::models::DrivenSample;
use nalgebra::{DMatrix, DVector};

/// What one sample leaves for the way back.
#[derive(Clone, Debug)]
pub struct StepTrace {
    /// The filter began anew with this sample: nothing leads back over it.
    pub begins: bool,
    /// Mean after the prediction.
    pub predicted_mean: DVector<f64>,
    /// Covariance after the prediction.
    pub predicted_covariance: DMatrix<f64>,
    /// Mean after the measurements.
    pub mean: DVector<f64>,
    /// Covariance after the measurements.
    pub covariance: DMatrix<f64>,
    /// Covariance between the state of the sample before and the predicted one, P Fᵀ.
    pub cross: DMatrix<f64>,
    /// The estimate of the way forward.
    pub output: EstimatorOutput,
    /// The sample as a filter of speeds saw it.
    pub sample: DrivenSample,
    /// What the filter remembered beside its belief.
    pub memory: Vec<f64>,
}
