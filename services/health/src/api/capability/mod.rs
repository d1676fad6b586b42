//! How far the train needs to stop now.

pub mod model;
pub(crate) mod routes;
