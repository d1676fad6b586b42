//! What travels between the processes of a train: fixed-size payloads, and what each must fulfil ([`Checked`]).
//!
//! Every payload is `repr(C)`, free of padding and of pointers, and its type name carries a layout version
//! (`railgrip/Sample/v2`). iceoryx2 compares names and sizes when a process opens a channel, but two fields that
//! swap places at equal size go unnoticed: **whoever changes a layout raises the version**. The test in
//! `tests/layout.rs` pins sizes and offsets, so it cannot be forgotten.
//!
//! | payload | channel | meaning |
//! | --- | --- | --- |
//! | [`Sample`] | `samples/N` | one instant of the sensors of wagon N, in batches |
//! | [`MotorSample`] | `motors/N` | one instant of the motor of rig N, 1 kHz or more, in batches |
//! | [`BogieSample`] | `bogies/N` | one instant of the sensors of bogie rig N, in batches |
//! | [`Estimate`] | `estimates/N` | what the filter makes of each sample, in batches |
//! | [`Innovation`] | `innovations/N` | what the filter expected and what came, in batches |
//! | [`AudioHeader`] and samples | `audio/N` | a block of audio of the microphone of wagon N, of any length |
//! | [`Heard`] | `heard/N` | what was made of a second of it |
//! | [`Health`] | `health/N` | the indicators of wagon N, a few times a second |
//! | [`Verdicts`] | `verdicts` | what is wrong with the train, by all its wagons together |
//! | [`Event`] | `events` | something happened that people care about |
//! | [`SourceState`] | `sources` | what ingest counted, and the clocks of the sources |
//! | [`Heartbeat`] | `heartbeats` | a process is alive, with its counters |
//!
//! # Glossary
//! * **wagon**: number of a vehicle in the train, 1 first; 0 means "no wagon".
//! * **wheelset**: index in a wagon, 0 leading; arrays have [`MAX_WHEELSETS`] places, of which `wheelsets` are in use.
//! * **bit mask per wheelset**: bit `1 << i` belongs to wheelset `i`.
//! * **sequence**: counts the samples of one wagon without gaps; a gap at the reader is a lost sample.
//! * signs: forward is positive; braking gives negative adhesion and negative creepage (slide), traction positive (spin).

mod audio;
mod bogie;
mod check;
mod codes;
mod estimate;
mod event;
mod health;
mod heartbeat;
mod motor;
mod sample;
mod source;
mod stamp;
mod text;
mod verdict;

pub use audio::{AUDIO_TYPE_NAME, AudioHeader, Heard};
pub use bogie::{BogieSample, bogie_valid};
pub use check::{Checked, Refusal, Validated};
pub use codes::{Condition, EstimateState, EventKind, Grade, HearingState, ProcessKind, SourceCount};
pub use estimate::{Estimate, Innovation, MAX_OUTPUTS, flags};
pub use event::{Event, NO_WHEELSET};
pub use health::{Health, Indicator, MAX_INDICATORS, MAX_WHEELSET_INDICATORS, WheelsetHealth};
pub use heartbeat::Heartbeat;
pub use motor::{MotorSample, motor_valid};
pub use sample::{Sample, sample_flags, valid};
pub use source::{MAX_SOURCE_COUNTS, SourceState};
pub use stamp::Stamp;
pub use text::Text;
pub use verdict::{MAX_RUNNERS, MAX_VERDICTS, Verdict, Verdicts};

/// Places for wheelsets in every payload; a wagon with two wheelsets uses the first two.
pub const MAX_WHEELSETS: usize = 4;

/// Standard gravity g, m/s²: the one figure of physics here, for what computes with payloads and may not use the crate of
/// the vehicle, where it stands too.
pub const GRAVITY_M_S2: f64 = 9.80665;

/// The wagon number that means "no wagon".
pub const NO_WAGON: u32 = 0;

/// A payload that travels on a channel of its own, with the name under which its layout is known.
pub trait Payload:
    bytemuck::Pod + std::fmt::Debug + iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend
{
    /// Name and version of the layout, for example `railgrip/Sample/v2`.
    const TYPE_NAME: &'static str;

    /// The running number of this item.
    fn sequence(&self) -> u64;
}

/// Makes all zeros the default of a part of a payload.
macro_rules! zero_default {
    ($type:ty) => {
        impl Default for $type {
            fn default() -> Self {
                bytemuck::Zeroable::zeroed()
            }
        }
    };
}
pub(crate) use zero_default;

/// Gives a payload its name, and all zeros as its default.
macro_rules! payload {
    ($type:ty, $name:literal) => {
        impl $crate::Payload for $type {
            const TYPE_NAME: &'static str = $name;

            fn sequence(&self) -> u64 {
                self.sequence
            }
        }
        $crate::zero_default!($type);
    };
}
pub(crate) use payload;
