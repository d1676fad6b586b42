//! From findings to a report, its figures, the prediction files and a vehicle.

pub mod curves;
pub mod estimates;
pub mod figures;
pub mod findings;
pub mod predictions;
pub mod report;
pub mod vehicle;
pub mod words;
