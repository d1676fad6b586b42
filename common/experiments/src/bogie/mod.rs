//! Shrestha, Spiryagin & Wu, "Experimental prototyping of the adhesion braking control system design concept for a
//! mechatronic bogie" (Railway Engineering Science 29, 2021).
//!
//! * [`run`] – the rig in closed loop: drive, brakes, sensors, filter, decision-maker, controller;
//! * [`controller`] – none, conventional fixed zone, proposed; in simulation only, nothing here drives a brake;
//! * [`listener`] – what stands for the acoustic classifier: conditions heard with a stated accuracy;
//! * [`ear`] – the product's own network at the rig; `acoustics` – Fig. 11 with it, accuracy and confusion;
//! * `peak` – Figs. 8 and 12 to 16; `transition` – Figs. 11 and 17; `stopping` – Figs. 18 to 20.

mod acoustics;
pub mod controller;
pub mod ear;
pub mod listener;
mod peak;
pub mod run;
pub(crate) mod stopping;
pub(crate) mod transition;

pub use acoustics::acoustics_experiment;
pub use peak::peak_experiment;
pub use stopping::stopping_experiment;
pub use transition::transition_experiment;
