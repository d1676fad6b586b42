//! railgrip recording.
