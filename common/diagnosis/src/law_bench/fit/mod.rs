//! Fitting a model to the points of a bench, how noisy these are, and how well it predicts what was left out.

pub mod fitted;
pub mod left_out;
pub mod noise;
pub mod solver;
