//! A process is alive.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::{ProcessKind, Stamp, payload};

/// Sign of life and counters of one process (channel `heartbeats`, about once a second).
/// Counters count since the process started and never go back.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("railgrip/Heartbeat/v2")]
pub struct Heartbeat {
    /// Counts the heartbeats of one process.
    pub sequence: u64,
    /// When it was sent.
    pub stamp: Stamp,
    /// Code of a [`ProcessKind`].
    pub process: u32,
    /// The wagon it serves, or 0.
    pub wagon: u32,
    /// Its process id.
    pub pid: u32,
    /// Samples that were sent while nobody was there, from the last one of a predecessor to its own first one, over all processes of
    /// its kind and wagon since the train has started.
    pub unseen: u32,
    /// Samples taken in.
    pub received: u64,
    /// Samples that never arrived (gaps of the sequence).
    pub missed: u64,
    /// Samples refused by validation.
    pub rejected: u64,
    /// Samples dropped because their time is not after that of the sample before.
    pub late: u64,
    /// Samples or estimates sent.
    pub published: u64,
    /// Median time of one step, ns; 0 when the process makes no steps.
    pub step_p50_ns: u64,
    /// 99th percentile of the time of one step, ns.
    pub step_p99_ns: u64,
    /// Median time from acquisition to publication, ns.
    pub latency_p50_ns: u64,
    /// 99th percentile of the time from acquisition to publication, ns.
    pub latency_p99_ns: u64,
    /// Since the process started, s.
    pub uptime_s: f64,
}
payload!(Heartbeat, "railgrip/Heartbeat/v2");

impl Heartbeat {
    /// The kind of process, unless a newer one sent it.
    #[must_use]
    pub const fn process(&self) -> Option<ProcessKind> {
        ProcessKind::from_code(self.process)
    }
}
