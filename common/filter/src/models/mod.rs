//! The filters by name, and what each must be able to do.
//!
//! A filter couples a physical model to the [`crate::core`]. **Adding one**: write its module and add its line to
//! [`FILTERS`]. A filter of speeds implements [`WagonFilter`] and is given hygiene, gates, innovation records and
//! snapshots by [`crate::WagonEstimator`]; one of other sensors implements [`crate::Estimator`] itself.

mod bogie;
pub mod bogie_rig;
#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::print_stdout, reason = "a test may fail and says what it measured")]
mod consistency;
mod imm;
mod motor;
mod paper;
mod physics;
mod rig;
mod sample;
mod sample_rate;
pub mod traction_rig;
mod wagon;

pub use bogie::BogieEstimator;
pub use imm::{ImmFilter, ImmSettings};
pub use motor::MotorEstimator;
pub use paper::{PaperFilter, PaperInput, PaperModel};
pub use physics::WagonPhysics;
pub use rig::{RigFilter, RigModel};
pub use sample::DrivenSample;
pub use wagon::{StepInput, WagonEkf};

use crate::core::ScalarUpdate;
use crate::{Estimator, EstimatorConfig, EstimatorOutput, FilterError, Plant, PlantKind};
use nalgebra::{DMatrix, DVector};
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

/// Builds a filter of speeds.
pub type BuildWagonFilter =
    fn(&EstimatorConfig, &VehicleParameters, &WagonModel) -> Result<Box<dyn WagonFilter>, FilterError>;
/// Builds an estimator with sensors of its own.
pub type BuildEstimator = fn(&EstimatorConfig, &Plant) -> Result<Box<dyn Estimator>, FilterError>;

/// How a filter is built.
#[derive(Clone, Copy)]
pub enum Build {
    /// A filter of speeds; [`crate::WagonEstimator`] surrounds it. The vehicle's effects are in the model already.
    Wagon(BuildWagonFilter),
    /// A filter with sensors of its own.
    Own(BuildEstimator),
}

/// One filter.
pub struct FilterEntry {
    /// Name in config files and on the command line.
    pub name: &'static str,
    /// One line for people.
    pub about: &'static str,
    /// What it can watch.
    pub plants: &'static [PlantKind],
    /// How it is built.
    pub build: Build,
}

const WAGON: &[PlantKind] = &[PlantKind::Wagon, PlantKind::Roller];
const DRIVEN: &[PlantKind] = &[PlantKind::Traction];
const BOGIE: &[PlantKind] = &[PlantKind::Bogie];

/// Every filter railgrip knows. The first that handles a plant is the plant's default.
#[rustfmt::skip]
pub static FILTERS: &[FilterEntry] = &[
    FilterEntry { name: "default", about: "one adhesion a wheelset, tied by the creep law; adaptive", plants: WAGON, build: Build::Wagon(wagon::boxed) },
    FilterEntry { name: "paper", about: "Schwarz & Keck (12)-(15), one adhesion for all wheelsets", plants: WAGON, build: Build::Wagon(paper::boxed) },
    FilterEntry { name: "rig", about: "Schwarz & Keck (19), of a wagon its leading wheelset", plants: WAGON, build: Build::Wagon(rig::boxed) },
    FilterEntry { name: "imm", about: "interacting multiple models: steady or moving adhesion, prompt or late pads", plants: WAGON, build: Build::Wagon(imm::boxed) },
    FilterEntry { name: "zhao", about: "Zhao et al., 13-state square-root unscented filter", plants: DRIVEN, build: Build::Own(motor::boxed_ukf) },
    FilterEntry { name: "zhao_ekf", about: "the same model by an extended filter", plants: DRIVEN, build: Build::Own(motor::boxed_ekf) },
    FilterEntry { name: "shrestha", about: "Shrestha et al. (2), (3) with inertia: torque transducer, load cell, pulses", plants: BOGIE, build: Build::Own(bogie::boxed) },
];

/// A filter by name.
pub(crate) fn find(name: &str) -> Option<&'static FilterEntry> {
    FILTERS.iter().find(|entry| entry.name == name)
}

/// The names of all filters, for people.
pub(crate) fn names() -> String {
    FILTERS.iter().map(|entry| format!("\"{}\"", entry.name)).collect::<Vec<_>>().join(", ")
}

/// A belief as matrices of dynamic size, for smoothing.
pub(crate) fn dynamic<const N: usize>(belief: &crate::core::Gaussian<N>) -> (DVector<f64>, DMatrix<f64>) {
    let mean = DVector::from_column_slice(belief.mean.as_slice());
    (mean, DMatrix::from_column_slice(N, N, belief.covariance.as_slice()))
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
