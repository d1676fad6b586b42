//! What was recorded and what the simulator believes.

pub mod align;
pub mod case;
mod dead;
pub mod lacks;
pub mod load;
mod long;
pub mod noise;
pub mod unit_watch;
pub mod units;
