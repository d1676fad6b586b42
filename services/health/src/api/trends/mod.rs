//! Where the indicators of a wagon are going.

pub mod model;
pub(crate) mod routes;
