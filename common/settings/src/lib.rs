//! railgrip settings.

pub mod vehicle;
