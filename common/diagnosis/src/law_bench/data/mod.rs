//! What was measured on the bench and what the simulator believes.

pub mod case;
pub mod error;
pub mod load;
pub mod point;
