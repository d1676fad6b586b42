//! railgrip diagnosis.
