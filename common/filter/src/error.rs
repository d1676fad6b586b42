//! What can go wrong in building or resuming an estimator. A step itself never fails.

use crate::ConfigError;

/// Errors of this crate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FilterError {
    /// A setting out of range.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A vehicle parameter out of range.
    #[error(transparent)]
    Vehicle(#[from] railgrip_vehicle::ParameterError),
    /// An effect of the vehicle that cannot be built.
    #[error(transparent)]
    Model(#[from] railgrip_vehicle::ModelError),
    /// A parameter of a rig out of range.
    #[error(transparent)]
    Parameter(#[from] crate::PlantError),
    /// The filter does not handle such a thing.
    #[error("filter \"{filter}\" does not handle a {plant}; those that do are {known}")]
    Plant {
        /// The filter.
        filter: &'static str,
        /// What is watched.
        plant: &'static str,
        /// Filters that handle it.
        known: String,
    },
    /// The wagon is coupled, and the filter would take what couplers do to it for its own brakes.
    #[error(
        "filter \"{filter}\" takes a wagon for a free one, and this one is coupled to others (`[train] free`, or train.toml); those that know couplers are {known}"
    )]
    Coupled {
        /// The filter.
        filter: &'static str,
        /// Filters that know couplers.
        known: String,
    },
    /// The filter cannot be smoothed.
    #[error(
        "filter \"{0}\" cannot be smoothed: its belief is not one Gaussian, or its readings begin anew with every sample; \"default\", \"paper\", \"rig\", \"zhao\" and \"zhao_ekf\" can"
    )]
    NotSmoothable(String),
    /// A covariance of the way forward has no Cholesky factor.
    #[error("sample {0} cannot be smoothed: its predicted covariance is not positive definite")]
    SmoothingFailed(usize),
    /// The filter does not exist for so many wheelsets.
    #[error("filter \"{filter}\" does not handle {wheelsets} wheelsets")]
    Wheelsets {
        /// The filter.
        filter: &'static str,
        /// Wheelsets of the vehicle.
        wheelsets: usize,
    },
    /// A snapshot of another filter.
    #[error("the snapshot is of filter \"{found}\", configured is \"{expected}\"")]
    SnapshotFilter {
        /// Configured.
        expected: String,
        /// In the snapshot.
        found: String,
    },
    /// A snapshot of another layout or vehicle.
    #[error("the snapshot's layout or vehicle is not the one configured")]
    SnapshotVehicle,
    /// A snapshot of another shape.
    #[error("the snapshot holds {found} states, expected are {expected}")]
    SnapshotShape {
        /// States of the filter.
        expected: usize,
        /// States in the snapshot.
        found: usize,
    },
    /// A snapshot with a covariance that is not positive definite, or values that are not finite.
    #[error("the snapshot's belief is not finite and positive definite")]
    SnapshotUnsound,
}
