//! What may be wrong: nuisances, candidates of the library, and flexible discrepancies.

pub mod candidates;
pub mod discrepancy;
pub mod parameters;
pub mod places;
pub mod track_offset;
