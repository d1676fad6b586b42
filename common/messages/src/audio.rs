//! What a microphone hears: the header of a block of audio, and what was made of a window.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::{Condition, HearingState, Stamp, payload, zero_default};

/// Name and version of what travels on `audio/N`: this header, and behind it samples (`f32`, full scale ±1).
pub const AUDIO_TYPE_NAME: &str = "railgrip/AudioBlock/v1";

/// The header of a block of audio (channel `audio/N`); the block itself is a slice of any length.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
#[type_name("railgrip/AudioBlock/v1")]
pub struct AudioHeader {
    /// Counts the blocks of this microphone, without gaps.
    pub sequence: u64,
    /// When the last sample of the block was taken.
    pub acquired: Stamp,
    /// The wagon whose microphone it is.
    pub wagon: u32,
    /// Samples a second.
    pub sample_rate_hz: u32,
    /// See [`crate::sample_flags`].
    pub flags: u32,
    /// Always 0.
    pub reserved: u32,
}
zero_default!(AudioHeader);

/// What was made of one second of audio (channel `heard/N`, once a second; late joiners get the last one).
///
/// The second half is advice: what the decision-maker of Shrestha et al. makes of it with measured slip and adhesion.
/// Nothing in railgrip drives a brake.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("railgrip/Heard/v1")]
pub struct Heard {
    /// Counts the windows of this listener, without gaps.
    pub sequence: u64,
    /// When the last sample of the window was taken; without audio, now.
    pub acquired: Stamp,
    /// When this was published, monotonic clock, ns.
    pub published_monotonic_ns: u64,
    /// The wagon.
    pub wagon: u32,
    /// Code of a [`HearingState`].
    pub state: u32,
    /// Code of the [`Condition`] assigned, dry or wet; `u32::MAX` while there is none.
    pub condition: u32,
    /// 1 if `wet_probability` holds a figure: in state `heard` only.
    pub known: u32,
    /// Probability that the rail is wet.
    pub wet_probability: f64,
    /// Root mean square of the window over that of a full-scale square wave, dB; −200 in silence.
    pub level_db: f64,
    /// Blocks that never arrived.
    pub missed: u64,
    /// 1 if the decision below holds.
    pub decided: u32,
    /// Code of the [`Condition`] decided.
    pub decided_condition: u32,
    /// 1 if heard curve and measured adhesion differ by more than 0.2, so that the decision before stands.
    pub kept: u32,
    /// Samples a second of the audio; 0 without audio.
    pub sample_rate_hz: u32,
    /// Adhesion to go by.
    pub decided_adhesion: f64,
    /// Slip at which the curve of the decided condition peaks at this speed.
    pub optimum_slip: f64,
    /// Adhesion there.
    pub optimum_adhesion: f64,
}
payload!(Heard, "railgrip/Heard/v1");

impl Heard {
    /// The state, unless a newer process sent it.
    #[must_use]
    pub const fn state(&self) -> Option<HearingState> {
        HearingState::from_code(self.state)
    }

    /// The condition assigned, if there is one.
    #[must_use]
    pub const fn condition(&self) -> Option<Condition> {
        Condition::from_code(self.condition)
    }

    /// The probability of wet, if something could be heard.
    #[must_use]
    pub const fn wet(&self) -> Option<f64> {
        if self.known == 0 { None } else { Some(self.wet_probability) }
    }
}
