//! railgrip filter.
