//! Something happened.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::{EventKind, Grade, Stamp, Text, payload};

/// The wheelset index that means "no wheelset".
pub const NO_WHEELSET: u32 = u32::MAX;

/// A change that people care about (channel `events`).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("railgrip/Event/v1")]
pub struct Event {
    /// Counts the events of one process, without gaps.
    pub sequence: u64,
    /// When it happened; for an event in the data, when the sample was taken.
    pub stamp: Stamp,
    /// Time base of the sensors, s; 0 for events of processes.
    pub time_s: f64,
    /// Code of an [`EventKind`].
    pub kind: u32,
    /// The wagon, or 0.
    pub wagon: u32,
    /// The wheelset, or [`NO_WHEELSET`].
    pub wheelset: u32,
    /// Code of a [`Grade`]: how bad it is.
    pub grade: u32,
    /// Figures; their meaning is that of the kind.
    pub values: [f64; 4],
    /// The same in words.
    pub text: Text,
}
payload!(Event, "railgrip/Event/v1");

impl Event {
    /// The kind, unless a newer process sent it.
    #[must_use]
    pub const fn kind(&self) -> Option<EventKind> {
        EventKind::from_code(self.kind)
    }

    /// The grade; unknown codes read as [`Grade::Unknown`].
    #[must_use]
    pub const fn grade(&self) -> Grade {
        match Grade::from_code(self.grade) {
            Some(grade) => grade,
            None => Grade::Unknown,
        }
    }
}
