//! Estimation of adhesion and brake friction: Kalman filters, their models, and the estimator of one wagon.
//!
//! * [`core`] – the mathematics, which knows no physics;
//! * [`unscented`] – the same for sigma points, in square-root form;
//! * [`models`] – the filters by name, which couple it to the vehicle's equations;
//! * [`WagonEstimator`] – hygiene of the data around a filter: a pure step from [`EstimatorInput`] to
//!   [`EstimatorOutput`], the same live and offline.
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
mod laws;
pub mod models;
mod observability;
mod output;
mod sensors;
mod snapshot;
pub mod unscented;

pub use config::{
    ConfigError, EstimatorConfig, HygieneSettings, NoisePreset, PriorSettings, RateSettings, SensorSettings,
};
pub use error::FilterError;
pub use estimator::{Memory, WagonEstimator};
pub use hygiene::{HeldInput, SensorWatch, TimeBase, TimeStep, Verdict};
pub use input::EstimatorInput;
pub use models::{FILTERS, FilterState};
pub use observability::scaled_rank;
pub use output::{EstimatorOutput, InnovationRecord, MAX_OUTPUTS, flags};
pub use sensors::SensorSigmas;
pub use snapshot::EstimatorSnapshot;
