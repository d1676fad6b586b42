//! What the nominal, the calibrated and the extended model predict, and the gap that they leave.

pub mod gaps;
