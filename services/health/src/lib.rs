//! railgrip health.
