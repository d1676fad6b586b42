//! railgrip estimator.
