//! One instant of the sensors of a driven rig.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::{Stamp, payload};

/// Bits of [`MotorSample::valid`]: which values are present. A missing value is 0 and its bit is clear.
pub mod motor_valid {
    /// `current_a[axis]`, α 0 and β 1.
    #[must_use]
    pub const fn current(axis: usize) -> u32 {
        1 << axis
    }
    /// `voltage_v[axis]`.
    #[must_use]
    pub const fn voltage(axis: usize) -> u32 {
        1 << (2 + axis)
    }
    /// `motor_speed_rad_s`.
    pub const MOTOR_SPEED: u32 = 1 << 4;
    /// `roller_speed_rad_s`.
    pub const ROLLER_SPEED: u32 = 1 << 5;
    /// `generator_current_a`.
    pub const GENERATOR_CURRENT: u32 = 1 << 6;
}

/// What the sensors of a driven rig say at one instant (channel `motors/N`), at 1 kHz or more.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("railgrip/MotorSample/v1")]
pub struct MotorSample {
    /// Counts the samples of this rig, without gaps.
    pub sequence: u64,
    /// When the sample was taken; every later message carries it on.
    pub acquired: Stamp,
    /// Time base of the sensors, s; the filter steps on its differences.
    pub time_s: f64,
    /// Stator current (α, β), A.
    pub current_a: [f64; 2],
    /// Stator voltage (α, β), V.
    pub voltage_v: [f64; 2],
    /// Speed of the motor, rad/s.
    pub motor_speed_rad_s: f64,
    /// Speed of the roller, rad/s.
    pub roller_speed_rad_s: f64,
    /// Current of the generator that loads the rollers, A.
    pub generator_current_a: f64,
    /// Which values are present, see [`motor_valid`].
    pub valid: u32,
    /// See [`crate::sample_flags`].
    pub flags: u32,
}
payload!(MotorSample, "railgrip/MotorSample/v1");

impl MotorSample {
    /// True if every bit of `bits` (see [`motor_valid`]) is set.
    #[must_use]
    pub const fn has(&self, bits: u32) -> bool {
        self.valid & bits == bits
    }
}
