//! railgrip simulation.
