//! railgrip tests.
