//! What was recorded and what the simulator believes.

pub mod case;
pub mod load;
pub mod units;
