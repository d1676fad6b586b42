//! The train at a glance.

pub mod model;
pub(crate) mod routes;
