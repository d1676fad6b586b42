//! Schwarz & Keck, "Simultaneous Estimation of Wheel-Rail Adhesion and Brake Friction Behaviour" (2020), section 4: the
//! roller rig with one wheelset, its two tests, and the study behind their Fig. 3.
//!
//! * [`rig`] – the rig with pneumatics and a slide protection of its own, under the programmes of the two tests;
//! * [`filter`] – the 4-state extended filter (19) with any Q and R, and friction law (8) or (9);
//! * [`judge`] – errors, and how long they last;
//! * `report`, `noise` and `beyond` – tables and figures.

mod beyond;
pub mod filter;
pub mod judge;
mod noise;
mod programme;
mod protection;
mod report;
pub mod rig;

pub use beyond::experiment as beyond_experiment;
pub use noise::experiment as noise_experiment;
pub use report::{sanding_experiment, wsp_experiment};
