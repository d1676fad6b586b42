//! Zhao, Liang & Iwnicki, "Friction coefficient estimation using an unscented Kalman filter" (VSD 52 (S1), 2014).
//!
//! Fifteen tests (Table 2: load cases 0 to 4 on base, water and oil) of 35 s under the speed profile (5-5), sampled at
//! 1 kHz with sensor noise v_k. The truth is our rig, so that every estimate has something to be compared with.
//!
//! * [`run`] – the rig under its profile;
//! * [`analysis`] – filters on the samples, means, and the Polach fit of (γ, F_γ);
//! * `report` – table and figures.

pub mod analysis;
mod report;
pub mod run;

pub use report::experiment;
