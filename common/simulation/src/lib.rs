//! A train in closed loop: driver, track, pneumatics, wheel-slide protection (WSP), wagons and their sensors.
//!
//! A [`Scenario`] says what happens; a [`Train`] makes it happen, one sample of all wagons at a time ([`Train::step`]), with
//! the truth that no sensor sees beside it; [`run`] does a whole recording. There is no clock here: time is counted.
//!
//! # Choices
//! * **Each wagon keeps its own speed**, as in the published estimator, which knows one wagon and no couplers; the driver's
//!   demand and the track hold the train together. With `[couplers]` a scenario ties the wagons by springs and dampers;
//!   estimators do not measure that force.
//! * **A wagon's random numbers are its own**: every wagon has its own streams, so that neither the number of wagons nor their
//!   order changes what one wagon does (unless coupled). The track's unevenness is the same for all.
//! * The same scenario, vehicle and seed give the same bits.
//!
//! # Glossary
//! * *demand* – what the driver asks for: a share of full traction or of full service braking, or a speed.
//! * *supply pressure* – what the train brake gives a wagon; *cylinder pressure* – what WSP lets through of it.
//! * *slide* – rim slower than the vehicle in braking; *spin* – rim faster in traction.
//! * *truth* – the state of the models, to measure estimators against.

mod disturbance;
mod driver;
mod error;
mod fault;
mod pneumatics;
mod random;
mod sample;
pub mod scenario;
mod sensors;
mod track;
mod traction;
mod train;
mod wagon;
mod whole_run;
mod wsp;

pub use error::ScenarioError;
pub use sample::{WagonSample, WagonTruth};
pub use scenario::Scenario;
pub use train::{Train, TrainSample};
pub use whole_run::{WagonRun, run};
