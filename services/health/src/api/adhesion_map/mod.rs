//! Where along the track the rail is low.

pub mod model;
pub(crate) mod routes;
