//! Prediction: one step ahead (which selects), open loop (by which the gap is defined), and with one place freed (which
//! says where).

pub mod disturbances;
pub(crate) mod local_disturbance;
pub mod localise;
pub mod natural;
pub mod one_step;
pub mod open_loop;
pub mod passes;
pub mod response;
