//! The wagons: one line each, and everything about one.

pub mod model;
pub(crate) mod routes;
pub(crate) mod view;
