//! One instant of the sensors of a bogie rig.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::{Stamp, payload};

/// Bits of [`BogieSample::valid`]: which values are present. A missing value is 0 and its bit is clear.
pub mod bogie_valid {
    /// `shaft_torque_nm`.
    pub const SHAFT_TORQUE: u32 = 1 << 0;
    /// `load_cell_n`.
    pub const LOAD_CELL: u32 = 1 << 1;
    /// `brake_pressure_pa`.
    pub const BRAKE_PRESSURE: u32 = 1 << 2;
    /// `load_n`.
    pub const LOAD: u32 = 1 << 3;
    /// `roller_pulses`: a window of the rollers' counter ended with this sample.
    pub const ROLLER_PULSES: u32 = 1 << 4;
    /// `wheel_pulses[wheelset]`.
    #[must_use]
    pub const fn wheel_pulses(wheelset: usize) -> u32 {
        1 << (5 + wheelset)
    }
}

/// What the sensors of a bogie rig say at one instant (channel `bogies/N`).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("railgrip/BogieSample/v1")]
pub struct BogieSample {
    /// Counts the samples of this rig, without gaps.
    pub sequence: u64,
    /// When the sample was taken; every later message carries it on.
    pub acquired: Stamp,
    /// Time base of the sensors, s; the filter steps on its differences.
    pub time_s: f64,
    /// Torque between motor and gear, N m.
    pub shaft_torque_nm: f64,
    /// Force of the link that holds the bogie, N, positive in braking.
    pub load_cell_n: f64,
    /// Pressure at the calipers, Pa.
    pub brake_pressure_pa: f64,
    /// Normal load of the bogie, N.
    pub load_n: f64,
    /// Pulses of the rollers' encoder in the window that ends now.
    pub roller_pulses: f64,
    /// Pulses of each wheelset's encoder since the last sample.
    pub wheel_pulses: [f64; 2],
    /// Which values are present, see [`bogie_valid`].
    pub valid: u32,
    /// See [`crate::sample_flags`].
    pub flags: u32,
}
payload!(BogieSample, "railgrip/BogieSample/v1");

impl BogieSample {
    /// True if every bit of `bits` (see [`bogie_valid`]) is set.
    #[must_use]
    pub const fn has(&self, bits: u32) -> bool {
        self.valid & bits == bits
    }
}
