//! How the source of samples fares.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::{SourceCount, Stamp, payload};

/// Places for counts; each belongs to the code of a [`SourceCount`].
pub const MAX_SOURCE_COUNTS: usize = 24;

/// What a source has counted, and its clock (channel `sources`, about once a second): of each wagon, and with wagon 0 of the
/// source as a whole. Counts go up from the start of the train, whoever is ingest.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("railgrip/SourceState/v1")]
pub struct SourceState {
    /// Counts the messages of one process.
    pub sequence: u64,
    /// When it was sent.
    pub stamp: Stamp,
    /// The wagon, or 0.
    pub wagon: u32,
    /// 1 if `drift_ppm` says something.
    pub drift_known: u32,
    /// How much faster our clock runs than that of the source, parts in a million.
    pub drift_ppm: f64,
    /// How often each thing happened, by the code of a [`SourceCount`].
    pub counts: [u64; MAX_SOURCE_COUNTS],
}
payload!(SourceState, "railgrip/SourceState/v1");

impl SourceState {
    /// How often that happened.
    #[must_use]
    pub const fn count(&self, what: SourceCount) -> u64 {
        self.counts[what.code() as usize]
    }
}
