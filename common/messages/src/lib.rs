//! railgrip messages.
