//! railgrip vehicle.
