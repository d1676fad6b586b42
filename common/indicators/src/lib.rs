//! railgrip indicators.
