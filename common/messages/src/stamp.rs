//! When something was measured.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

/// One instant on two clocks.
///
/// People and archives read `unix_ns`. Ages and latencies are differences of `monotonic_ns`, so that a jump of the wall
/// clock disturbs neither. The monotonic clock is that of this host since boot; it means nothing on another host.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Pod, Zeroable, ZeroCopySend)]
#[type_name("railgrip/Stamp/v1")]
pub struct Stamp {
    /// `CLOCK_REALTIME`, nanoseconds since 1970.
    pub unix_ns: i64,
    /// `CLOCK_MONOTONIC`, nanoseconds.
    pub monotonic_ns: u64,
}

impl Stamp {
    /// Age in seconds at the monotonic instant `now_monotonic_ns`; 0 for a stamp from the future.
    #[must_use]
    pub fn age_s(&self, now_monotonic_ns: u64) -> f64 {
        now_monotonic_ns.saturating_sub(self.monotonic_ns) as f64 * 1e-9
    }
}
