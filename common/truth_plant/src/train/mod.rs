//! A judging train: wagons, coupled or alone, on a day of stops, with one fault or none. It shares no formula and no
//! constant with the models under test, nor with the single wagons of this crate.
//!
//! **Glossary.** *Order*: what is wanted of a train. *Spec*: a train before it runs, drawn from a seed. *File*: what is
//! believed of a wagon. *Defects*: what is wrong with it, in numbers that are zero when nothing is. *Fault*: one row of
//! the table [`faults::FAULTS`] with size, onset and place. *Reading*: a row of a recording. *Truth*: what no sensor sees.
//! *Tick*: one round of the controllers; *step*: one of the equations of motion.
//!
//! **Order of a tick**: driver → brake pipe → gear and motors → rail → motion (some steps) → sensors and slide protection.

mod car;
mod contact;
mod coupler;
mod driver;
mod dynamics;
mod family;
pub mod faults;
pub mod files;
mod gear;
mod journey;
pub mod label;
mod line;
mod pipe;
mod pitch;
mod protection;
mod sensors;
mod spec;
mod traction;
mod truth;
mod units;
mod wagon;
mod weather;

#[cfg(test)]
mod tests;

pub use coupler::DrawGear;
pub use driver::DriverStyle;
pub use family::BrakeLine;
pub use gear::{GearPlan, Pads};
pub use journey::Journey;
pub use line::{Line, LowStretch};
pub use pitch::Bogies;
pub use protection::ProtectionPlan;
pub use sensors::{Reading, SensorPlan};
pub use spec::{FaultWish, OrderError, TrainOrder, TrainSpec, deck};
pub use truth::Truth;
pub use units::PerWheelset;
pub use wagon::{RealWagon, Wagon, WagonFile};
pub use weather::Weather;
