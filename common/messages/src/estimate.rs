//! What the filter says, sample by sample.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::{EstimateState, MAX_WHEELSETS, Stamp, payload};

/// Places for measured outputs: of a wagon its speed and the speed of each wheelset, of a driven rig currents,
/// voltages, speeds and the generator's current, of a bogie rig torque, link force and counted angles.
pub const MAX_OUTPUTS: usize = 8;

/// Bits of [`Estimate::flags`].
pub mod flags {
    /// Some state is held, because nothing in the data speaks about it.
    pub const HELD: u32 = 1 << 0;
    /// No usable measurement came with this sample; the estimate is a prediction.
    pub const PREDICTED: u32 = 1 << 1;
    /// The filter started anew with this sample.
    pub const RESTARTED: u32 = 1 << 2;
    /// Samples are missing right before this one.
    pub const GAP: u32 = 1 << 3;
    /// The filter went on from a snapshot with this sample.
    pub const RESUMED: u32 = 1 << 4;
    /// The filter has not converged yet.
    pub const CONVERGING: u32 = 1 << 5;
}

/// Adhesion and brake friction of one wagon at one instant (channel `estimates/N`). All `sigma` are 1 σ.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("railgrip/Estimate/v2")]
pub struct Estimate {
    /// That of the sample.
    pub sequence: u64,
    /// That of the sample.
    pub acquired: Stamp,
    /// When the estimate was published, monotonic clock, ns.
    pub published_monotonic_ns: u64,
    /// That of the sample, s.
    pub time_s: f64,
    /// Speed over ground, m/s.
    pub v_m_s: f64,
    /// Adhesion utilised by the wagon, signed like the contact force (braking negative).
    pub mu_w: f64,
    /// 1 σ of `mu_w`.
    pub mu_w_sigma: f64,
    /// Adhesion utilised by each wheelset, signed.
    pub mu_w_wheelset: [f64; MAX_WHEELSETS],
    /// 1 σ of `mu_w_wheelset`.
    pub mu_w_wheelset_sigma: [f64; MAX_WHEELSETS],
    /// Pad friction of each wheelset.
    pub mu_b: [f64; MAX_WHEELSETS],
    /// 1 σ of `mu_b`.
    pub mu_b_sigma: [f64; MAX_WHEELSETS],
    /// Pad friction of the wagon, mean of the wheelsets weighted with their pressing forces.
    pub mu_b_mean: f64,
    /// 1 σ of `mu_b_mean`.
    pub mu_b_mean_sigma: f64,
    /// Creepage of each wheelset, dimensionless, negative sliding in braking.
    pub slip: [f64; MAX_WHEELSETS],
    /// Normal load of each wheelset, N.
    pub normal_load_n: [f64; MAX_WHEELSETS],
    /// Pressing force of each wheelset as the filter used it, N.
    pub pressing_force_n: [f64; MAX_WHEELSETS],
    /// Adhesion that the contact offers at most (μ0), where the filter estimates it and `state` says so; else 0.
    pub adhesion_peak: f64,
    /// 1 σ of `adhesion_peak`.
    pub adhesion_peak_sigma: f64,
    /// Normalised innovation squared of this step.
    pub nis: f64,
    /// Measurements behind `nis` (its degrees of freedom).
    pub nis_dof: u32,
    /// Wheelsets whose pad friction the data determine, bit mask.
    pub observable: u32,
    /// Wheelsets that slide or spin, bit mask.
    pub sliding: u32,
    /// Wheelsets whose slide protection acts, bit mask.
    pub wsp_active: u32,
    /// Outputs refused by the gate, bit mask: bit 0 the speed, bit `1 + i` wheelset `i`.
    pub rejected: u32,
    /// Rank of the local observability matrix.
    pub observability_rank: u32,
    /// See [`flags`].
    pub flags: u32,
    /// Wheelsets of this wagon.
    pub wheelsets: u32,
    /// Code of an [`EstimateState`]: what the estimate is worth.
    pub state: u32,
    /// Always 0.
    pub reserved: u32,
}
payload!(Estimate, "railgrip/Estimate/v2");

impl Estimate {
    /// Wheelsets in use, never more than there are places.
    #[must_use]
    pub const fn wheelset_count(&self) -> usize {
        let count = self.wheelsets as usize;
        if count < MAX_WHEELSETS { count } else { MAX_WHEELSETS }
    }

    /// What the estimate is worth, unless a newer process sent it.
    #[must_use]
    pub const fn state(&self) -> Option<EstimateState> {
        EstimateState::from_code(self.state)
    }

    /// From acquisition to publication, s.
    #[must_use]
    pub fn latency_s(&self) -> f64 {
        self.acquired.age_s(self.published_monotonic_ns)
    }
}

/// What came beside what the filter expected, refused values too (channel `innovations/N`).
/// Of a wagon, output 0 is the speed (m/s), output `1 + i` the speed of wheelset `i` (rad/s); of a driven rig the outputs
/// are I_α, I_β, ω_motor, U_α, U_β, ω_roller, I_dc; of a bogie rig torque (N m), link force (N) and the angles that
/// rollers and wheelsets turned since their last reading (rad).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("railgrip/Innovation/v2")]
pub struct Innovation {
    /// That of the sample.
    pub sequence: u64,
    /// That of the sample, s.
    pub time_s: f64,
    /// Measured minus predicted.
    pub innovation: [f64; MAX_OUTPUTS],
    /// Its predicted variance.
    pub innovation_variance: [f64; MAX_OUTPUTS],
    /// Innovation squared over gate squared times variance; above 1 the gate refuses.
    pub test_ratio: [f64; MAX_OUTPUTS],
    /// Outputs refused, bit mask.
    pub rejected: u32,
    /// Outputs used, bit mask.
    pub fused: u32,
}
payload!(Innovation, "railgrip/Innovation/v2");
