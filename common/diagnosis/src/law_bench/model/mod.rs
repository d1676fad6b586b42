//! The law of a bench, and what may be wrong with it.
//!
//! [`law`] predicts from parameters; [`candidates`] are the effects that can be named, each in several [`shape`]s;
//! [`discrepancy`] is any smooth error, for what no candidate describes.

pub mod candidates;
pub mod discrepancy;
pub mod law;
pub mod shape;
