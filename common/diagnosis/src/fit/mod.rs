//! Fits: the solver, what it minimises, and whole models fitted by it.

pub mod aligned;
mod bounded_step;
pub mod candidate;
pub mod discrepancies;
pub mod frozen;
pub mod hearing;
pub mod leaving;
pub mod linearisation;
pub mod margin;
pub mod objective;
pub mod solver;
pub mod windows;
