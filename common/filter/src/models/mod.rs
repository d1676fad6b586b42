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
mod wagon_filter;

pub use bogie::BogieEstimator;
pub use imm::ImmFilter;
pub use motor::MotorEstimator;
pub use paper::{PaperFilter, PaperInput, PaperModel};
pub use physics::WagonPhysics;
pub use rig::{RigFilter, RigModel};
pub use sample::DrivenSample;
pub use wagon::{StepInput, WagonEkf};
pub use wagon_filter::{FilterState, WagonFilter};
pub(crate) use wagon_filter::{dynamic, pack, unpack};

use crate::{BogieRigFile, Estimator, EstimatorConfig, FilterError, PlantKind, TractionRigFile};
use railgrip_vehicle::{VehicleParameters, WagonModel};

/// Builds a filter of speeds.
pub type BuildWagonFilter =
    fn(&EstimatorConfig, &VehicleParameters, &WagonModel) -> Result<Box<dyn WagonFilter>, FilterError>;
/// Builds an estimator of a traction rig.
pub type BuildTractionEstimator = fn(&TractionRigFile) -> Result<Box<dyn Estimator>, FilterError>;
/// Builds an estimator of a bogie rig.
pub type BuildBogieEstimator = fn(&BogieRigFile) -> Result<Box<dyn Estimator>, FilterError>;

/// How a filter is built.
#[derive(Clone, Copy)]
pub enum Build {
    /// A filter of speeds; [`crate::WagonEstimator`] surrounds it. The vehicle's effects are in the model already.
    Wagon(BuildWagonFilter),
    /// A filter of the sensors of a traction rig.
    Traction(BuildTractionEstimator),
    /// A filter of the sensors of a bogie rig.
    Bogie(BuildBogieEstimator),
}

/// One filter.
pub struct FilterEntry {
    /// Name in config files and on the command line.
    pub name: &'static str,
    /// One line for people.
    pub about: &'static str,
    /// What it can watch.
    pub plants: &'static [PlantKind],
    /// Whether it knows that couplers act on a wagon.
    pub couplers: bool,
    /// How it is built.
    pub build: Build,
}

const WAGON: &[PlantKind] = &[PlantKind::Wagon, PlantKind::Roller];
const DRIVEN: &[PlantKind] = &[PlantKind::Traction];
const BOGIE: &[PlantKind] = &[PlantKind::Bogie];

/// Every filter railgrip knows. The first that handles a plant is the plant's default.
#[rustfmt::skip]
pub static FILTERS: &[FilterEntry] = &[
    FilterEntry { name: "default", about: "one adhesion a wheelset, tied by the creep law; adaptive", plants: WAGON, couplers: true, build: Build::Wagon(wagon::boxed) },
    FilterEntry { name: "paper", about: "Schwarz & Keck (12)-(15), one adhesion for all wheelsets", plants: WAGON, couplers: false, build: Build::Wagon(paper::boxed) },
    FilterEntry { name: "rig", about: "Schwarz & Keck (19), of a wagon its leading wheelset", plants: WAGON, couplers: false, build: Build::Wagon(rig::boxed) },
    FilterEntry { name: "imm", about: "interacting multiple models: steady or moving adhesion, prompt or late pads", plants: WAGON, couplers: false, build: Build::Wagon(imm::boxed) },
    FilterEntry { name: "zhao", about: "Zhao et al., 13-state square-root unscented filter", plants: DRIVEN, couplers: false, build: Build::Traction(motor::boxed_ukf) },
    FilterEntry { name: "zhao_ekf", about: "the same model by an extended filter", plants: DRIVEN, couplers: false, build: Build::Traction(motor::boxed_ekf) },
    FilterEntry { name: "shrestha", about: "Shrestha et al. (2), (3) with inertia: torque transducer, load cell, pulses", plants: BOGIE, couplers: false, build: Build::Bogie(bogie::boxed) },
];

/// A filter by name.
pub(crate) fn find(name: &str) -> Option<&'static FilterEntry> {
    FILTERS.iter().find(|entry| entry.name == name)
}

/// The names of all filters, for people.
pub(crate) fn names() -> String {
    FILTERS.iter().map(|entry| format!("\"{}\"", entry.name)).collect::<Vec<_>>().join(", ")
}
