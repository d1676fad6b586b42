//! One instant of a wagon's sensors.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::{MAX_WHEELSETS, Stamp, payload};

/// Bits of [`Sample::valid`]: which values are present. A missing value is 0 and its bit is clear.
pub mod valid {
    /// `v_m_s`.
    pub const SPEED: u32 = 1 << 0;
    /// `grade_rad`.
    pub const GRADE: u32 = 1 << 13;
    /// `sanding`.
    pub const SANDING: u32 = 1 << 14;
    /// `position_m`.
    pub const POSITION: u32 = 1 << 15;
    /// `wsp_active`.
    pub const WSP: u32 = 1 << 16;
    /// `load_kg`.
    pub const LOAD: u32 = 1 << 17;
    /// `brake_demand`.
    pub const BRAKE_DEMAND: u32 = 1 << 18;

    /// `wheel_speed_rad_s[wheelset]`.
    #[must_use]
    pub const fn wheel_speed(wheelset: usize) -> u32 {
        1 << (1 + wheelset)
    }

    /// `pressing_force_n[wheelset]`.
    #[must_use]
    pub const fn pressing_force(wheelset: usize) -> u32 {
        1 << (5 + wheelset)
    }

    /// `drive_torque_nm[wheelset]`.
    #[must_use]
    pub const fn drive_torque(wheelset: usize) -> u32 {
        1 << (9 + wheelset)
    }
}

/// Bits of [`Sample::flags`].
pub mod sample_flags {
    /// The time base begins anew with this sample (a replay starts over, a source restarted): what the filter knows
    /// about the past does not belong to it.
    pub const TIME_BASE_RESTARTED: u32 = 1 << 0;
}

/// What the sensors of one wagon say at one instant (channel `samples/N`).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("railgrip/Sample/v2")]
pub struct Sample {
    /// Counts the samples of this wagon, without gaps.
    pub sequence: u64,
    /// When the sample was taken; every later message carries it on.
    pub acquired: Stamp,
    /// Time base of the sensors, s; the filter steps on its differences.
    pub time_s: f64,
    /// Speed over ground, m/s.
    pub v_m_s: f64,
    /// Angular speed of each wheelset, rad/s, positive rolling forward.
    pub wheel_speed_rad_s: [f64; MAX_WHEELSETS],
    /// Force that presses the pads of each wheelset, N, inferred from brake-cylinder pressure.
    pub pressing_force_n: [f64; MAX_WHEELSETS],
    /// Traction torque at each wheelset, N m, positive driving forward.
    pub drive_torque_nm: [f64; MAX_WHEELSETS],
    /// Slope of the track, rad, positive uphill.
    pub grade_rad: f64,
    /// Sand on the rail, 0 none to 1 full.
    pub sanding: f64,
    /// Position along the track, m.
    pub position_m: f64,
    /// Mass by load sensors (air springs, axle load), kg.
    pub load_kg: f64,
    /// Brake that is ordered, 0 to 1.
    pub brake_demand: f64,
    /// Which values are present, see [`valid`].
    pub valid: u32,
    /// Wheelsets whose slide protection acts, bit mask.
    pub wsp_active: u32,
    /// Wheelsets of this wagon.
    pub wheelsets: u32,
    /// See [`sample_flags`].
    pub flags: u32,
}
payload!(Sample, "railgrip/Sample/v2");

impl Sample {
    /// True if every bit of `bits` (see [`valid`]) is set.
    #[must_use]
    pub const fn has(&self, bits: u32) -> bool {
        self.valid & bits == bits
    }

    /// Wheelsets in use, never more than there are places.
    #[must_use]
    pub const fn wheelset_count(&self) -> usize {
        let count = self.wheelsets as usize;
        if count < MAX_WHEELSETS { count } else { MAX_WHEELSETS }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_has_a_bit_of_its_own() {
        let mut bits = vec![
            valid::SPEED,
            valid::GRADE,
            valid::SANDING,
            valid::POSITION,
            valid::WSP,
            valid::LOAD,
            valid::BRAKE_DEMAND,
        ];
        for wheelset in 0..MAX_WHEELSETS {
            bits.extend([
                valid::wheel_speed(wheelset),
                valid::pressing_force(wheelset),
                valid::drive_torque(wheelset),
            ]);
        }
        assert_eq!(bits.iter().fold(0, |all, bit| all | bit).count_ones() as usize, bits.len());
    }

    #[test]
    fn a_wrong_count_of_wheelsets_stays_in_bounds() {
        let sample = Sample { wheelsets: 77, ..Sample::default() };
        assert_eq!(sample.wheelset_count(), MAX_WHEELSETS);
    }
}
