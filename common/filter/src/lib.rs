//! railgrip filter.
pub mod core;
