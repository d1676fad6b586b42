//! What a filter of speeds must be able to do, and its belief at rest.

use super::sample::DrivenSample;
use crate::core::{Gaussian, ScalarUpdate};
use crate::{EstimatorOutput, FilterError};
use nalgebra::{DMatrix, DVector, SMatrix, SVector};
use serde::{Deserialize, Serialize};

/// A filter of one wagon, step by step. Outputs are counted as in [`crate::InnovationRecord`]: 0 the vehicle speed,
/// `1 + i` the speed of wheelset `i`.
pub trait WagonFilter: Send {
    /// Begins from this sample, knowing only the priors.
    fn start(&mut self, sample: &DrivenSample);

    /// Measures the motion anew from this sample after `gap_s` without data, keeping what changes slowly.
    fn restart_motion(&mut self, sample: &DrivenSample, gap_s: f64);

    /// Predicts over `dt_s` under the inputs of `sample`.
    fn predict(&mut self, sample: &DrivenSample, dt_s: f64);

    /// What measuring `output` as `measured` would say.
    fn expect(&self, output: usize, measured: f64) -> ScalarUpdate;

    /// Uses that measurement.
    fn accept(&mut self, output: usize, update: &ScalarUpdate);

    /// Believes a sensor that contradicted the filter for too long: what it measures becomes as uncertain as at the
    /// start, around the measured value.
    fn believe(&mut self, output: usize, measured: f64);

    /// Called once after the measurements of a sample.
    fn conclude(&mut self, sample: &DrivenSample, dt_s: f64);

    /// Writes the belief into an estimate.
    fn read(&self, sample: &DrivenSample, out: &mut EstimatorOutput);

    /// Everything that a restart needs.
    fn save(&self) -> FilterState;

    /// Takes up what [`WagonFilter::save`] gave.
    ///
    /// # Errors
    /// If the state has another shape or is not sound.
    fn load(&mut self, state: &FilterState) -> Result<(), FilterError>;

    /// A copy that goes on by itself.
    fn boxed_clone(&self) -> Box<dyn WagonFilter>;

    /// Mean and covariance now; `None` if the belief is not one Gaussian. For smoothing only: it allocates.
    fn belief(&self) -> Option<(DVector<f64>, DMatrix<f64>)>;

    /// Derivative of the last prediction with respect to the state before it. For smoothing only: it allocates.
    fn transition(&self) -> DMatrix<f64>;

    /// True if the belief contradicts physics: the filter must start anew.
    fn has_diverged(&self) -> bool;
}

/// Belief and memory of a filter, for a snapshot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FilterState {
    /// Mean of the state.
    pub mean: Vec<f64>,
    /// Covariance, column by column.
    pub covariance: Vec<f64>,
    /// What the filter remembers beside its belief.
    pub memory: Vec<f64>,
}

/// A belief as matrices of dynamic size, for smoothing.
pub(crate) fn dynamic<const N: usize>(belief: &Gaussian<N>) -> (DVector<f64>, DMatrix<f64>) {
    let mean = DVector::from_column_slice(belief.mean.as_slice());
    (mean, DMatrix::from_column_slice(N, N, belief.covariance.as_slice()))
}

/// Packs a belief for a snapshot.
pub(crate) fn pack<const N: usize>(belief: &Gaussian<N>, memory: Vec<f64>) -> FilterState {
    FilterState {
        mean: belief.mean.iter().copied().collect(),
        covariance: belief.covariance.iter().copied().collect(),
        memory,
    }
}

/// Unpacks a belief from a snapshot and checks it.
pub(crate) fn unpack<const N: usize>(state: &FilterState, memory: usize) -> Result<Gaussian<N>, FilterError> {
    if state.mean.len() != N || state.covariance.len() != N * N || state.memory.len() != memory {
        return Err(FilterError::SnapshotShape { expected: N, found: state.mean.len() });
    }
    let belief = Gaussian::<N> {
        mean: SVector::from_column_slice(&state.mean),
        covariance: SMatrix::from_column_slice(&state.covariance),
    };
    if !belief.is_sound() || state.memory.iter().any(|value| !value.is_finite()) {
        return Err(FilterError::SnapshotUnsound);
    }
    Ok(belief)
}
