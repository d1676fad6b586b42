//! The filters by name, and what each must be able to do.
//!
//! A filter couples a physical model to the [`crate::core`]. **Adding one**: write its module and add its line to
//! [`FILTERS`].

pub mod bogie_rig;
mod paper;
mod rig;
mod sample;
pub mod traction_rig;
mod wagon;

pub use paper::{PaperFilter, PaperInput, PaperModel};
pub use rig::{RigFilter, RigModel};
pub use sample::DrivenSample;
pub use wagon::{StepInput, WagonEkf, WagonPhysics};

use crate::core::ScalarUpdate;
use crate::{EstimatorConfig, EstimatorOutput, FilterError};
use railgrip_vehicle::{VehicleParameters, WagonModel};
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

/// Builds a filter; the vehicle's effects are in the model already.
type Constructor =
    fn(&EstimatorConfig, &VehicleParameters, &WagonModel) -> Result<Box<dyn WagonFilter>, FilterError>;

/// Every filter railgrip knows.
pub static FILTERS: &[(&str, Constructor)] =
    &[("default", wagon::boxed), ("paper", paper::boxed), ("rig", rig::boxed)];

/// The constructor of a filter by name.
pub(crate) fn find(name: &str) -> Option<Constructor> {
    FILTERS.iter().find(|(known, _)| *known == name).map(|(_, constructor)| *constructor)
}

/// The names of all filters, for people.
pub(crate) fn names() -> String {
    FILTERS.iter().map(|(name, _)| format!("\"{name}\"")).collect::<Vec<_>>().join(", ")
}

/// Packs a belief for a snapshot.
pub(crate) fn pack<const N: usize>(belief: &crate::core::Gaussian<N>, memory: Vec<f64>) -> FilterState {
    FilterState {
        mean: belief.mean.iter().copied().collect(),
        covariance: belief.covariance.iter().copied().collect(),
        memory,
    }
}

/// Unpacks a belief from a snapshot and checks it.
pub(crate) fn unpack<const N: usize>(
    state: &FilterState,
    memory: usize,
) -> Result<crate::core::Gaussian<N>, FilterError> {
    if state.mean.len() != N || state.covariance.len() != N * N || state.memory.len() != memory {
        return Err(FilterError::SnapshotShape { expected: N, found: state.mean.len() });
    }
    let belief = crate::core::Gaussian::<N> {
        mean: nalgebra::SVector::from_column_slice(&state.mean),
        covariance: nalgebra::SMatrix::from_column_slice(&state.covariance),
    };
    if !belief.is_sound() || state.memory.iter().any(|value| !value.is_finite()) {
        return Err(FilterError::SnapshotUnsound);
    }
    Ok(belief)
}
