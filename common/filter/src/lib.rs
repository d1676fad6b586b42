//! Estimation of adhesion and brake friction: Kalman filters, their models, and the estimator of one wagon.
//!
//! * [`core`] – the mathematics, which knows no physics;
//! * [`unscented`] – the same for sigma points, in square-root form;
//! * [`models`] – the filters by name, which couple it to the vehicle's equations;
//! * [`Plant`] – what is watched: a wagon or a rig; [`estimator`] builds the filter that the config names for it, and
//!   [`Estimator`] is the one interface of all: a pure step from [`EstimatorInput`] to [`EstimatorOutput`], the same live
//!   and offline;
//! * [`WagonEstimator`] – hygiene of the data around a filter of speeds;
//! * [`smooth_record`] – what a whole recording says about each of its instants.
//!
//! Glossary: *innovation* – measured minus predicted value; *gate* – bound beyond which it is refused; *nis* –
//! normalised innovation squared; *held* – kept because nothing in the data speaks about it; *observable* – the data
//! determine it to the stated accuracy.

mod config;
pub mod core;
mod error;
mod estimator;
mod hygiene;
mod input;
mod interface;
mod laws;
mod memory;
pub mod models;
mod observability;
mod output;
mod plant;
mod selection;
mod sensors;
mod smoothing;
mod snapshot;
mod state;
mod trace;
pub mod unscented;

pub use config::{
    ConfigError, EstimatorConfig, HygieneSettings, ImmSettings, NoisePreset, PriorSettings, RateSettings,
    SensorSettings,
};
pub use error::FilterError;
pub use estimator::WagonEstimator;
pub use hygiene::{HeldInput, SensorWatch, TimeBase, TimeStep, Verdict};
pub use input::{EstimatorInput, WagonSample};
pub use interface::Estimator;
pub use memory::Memory;
pub use models::bogie_rig::BogieSample;
pub use models::traction_rig::TractionSample;
pub use models::{Build, FILTERS, FilterEntry, FilterState};
pub use observability::scaled_rank;
pub use output::{EstimatorOutput, InnovationRecord, MAX_OUTPUTS, flags};
pub use plant::{
    BogieBrake, BogieDrive, BogieLaw, BogieRigFile, BogieRigSensors, BogieRollers, MotorSensors, Plant,
    PlantError, PlantKind, Roller, RollerRigFile, TractionRigFile,
};
pub use selection::{DEFAULT_FILTER, estimator};
pub use sensors::SensorSigmas;
pub use smoothing::{SmoothedStep, smooth_record};
pub use snapshot::EstimatorSnapshot;
pub use state::EstimateState;
pub use trace::StepTrace;
