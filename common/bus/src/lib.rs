//! railgrip bus.
