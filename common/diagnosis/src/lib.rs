//! The sim-to-real gap.

pub mod case;
pub mod innovations;
pub mod kernel;
pub mod library;
pub mod load;
pub mod metric;
pub mod objective;
pub mod parameters;
pub mod search;
pub mod solver;
pub mod bench;
pub mod html;
pub mod report;
