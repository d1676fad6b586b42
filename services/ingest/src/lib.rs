//! railgrip ingest.
