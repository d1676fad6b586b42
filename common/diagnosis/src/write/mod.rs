//! From decisions to the report: numbers, curves and tables.

pub(crate) mod details;
pub(crate) mod effect_curve;
pub(crate) mod events;
pub mod predictions;
pub mod regime;
pub(crate) mod report;
