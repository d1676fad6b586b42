//! railgrip settings.
