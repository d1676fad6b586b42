//! railgrip truth-plant.
