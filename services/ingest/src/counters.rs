//! What ingest counts.

/// What was counted; it goes into the heartbeats.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub struct Counters {
    /// Samples that came from the source.
    pub received: u64,
    /// Samples, or single values, that validation refused.
    pub rejected: u64,
    /// Samples with a time that is not after that of their predecessor. Those of a live source are dropped; those of a
    /// recording travel on, and the filter decides.
    pub late: u64,
    /// Samples sent.
    pub published: u64,
}
