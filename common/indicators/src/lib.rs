//! The health indicators of a wagon: pure arithmetic from samples and estimates, no clock, no channel, no file.
//!
//! [`WagonIndicators`] takes each sample with its estimate at full rate and gives a [`railgrip_messages::Health`] on
//! demand: figures with 95 % intervals, a grade each, and the reason in words.
//!
//! | indicator | what it is | what it cannot see |
//! | --- | --- | --- |
//! | brake friction | mean over braking; of a wheelset only where the filter calls it observable | errors of mass and radii (declared as `systematic_share`) |
//! | asymmetry | front minus rear over their mean | anything while both wheelsets merely roll |
//! | adhesion utilised | largest magnitude in a window | – |
//! | adhesion available | what a slide showed; else a lower bound: what was utilised without sliding | the limit while rolling |
//! | rail | probability of dry, wet, low, very low ([`belief`]) | the cause of low adhesion |
//! | slides | count and energy: friction force times slip velocity, over time | the form of the wheel |
//! | slide protection | share of the braking time with the protection active | – |
//! | sensors | share of values missing or refused | a bias that all sensors share |
//! | filter | mean normalised innovation squared over its degrees of freedom, 1 when model and data agree | a mismatch that another state absorbs |
//!
//! # Glossary
//! *Utilised* and *available* as in the vehicle crate. *Memory*: older data count less, by a factor e per memory.

mod applications;
pub mod belief;
mod brakes;
mod dead;
mod dragging;
mod isolation;
mod judge;
mod judge_brakes;
mod mean;
mod rail_view;
mod report;
mod sanding;
mod settings;
mod slides;
mod standard;
pub mod stopping;
pub mod track;
pub mod trend;
mod wagon;
mod window;

pub use settings::{
    AdhesionSettings, AsymmetrySettings, BrakeFrictionSettings, DraggingSettings, FilterSettings,
    IndicatorSettings, IsolatedSettings, ResponseSettings, SandingSettings, SensorSettings, SettingError,
    SlideSettings, StandardSettings, WspSettings,
};
pub use wagon::{IndicatorState, Nominal, WagonIndicators};
