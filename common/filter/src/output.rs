//! What the estimator gives out, sample by sample. All `sigma` are one standard deviation.

use crate::EstimateState;
use railgrip_vehicle::MAX_WHEELSETS;
use serde::Serialize;

/// Places for measured outputs: of a wagon its speed and the speed of each wheelset, of a driven rig the seven of (5-4).
pub const MAX_OUTPUTS: usize = 8;

/// Bits of [`EstimatorOutput::flags`].
pub mod flags {
    /// Some input or state is held, because nothing in the data speaks about it.
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
    /// The sample was late, duplicated or without a time: the estimate repeats the last one.
    pub const IGNORED: u32 = 1 << 6;
}

/// What came beside what the filter expected, refused values too.
/// Of a wagon, output 0 is the speed (m/s) and output `1 + i` the speed of wheelset `i` (rad/s); of a driven rig the
/// outputs are those of Zhao et al. (5-4), in that order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct InnovationRecord {
    /// Measured minus predicted; 0 where nothing was measured.
    pub innovation: [f64; MAX_OUTPUTS],
    /// Its predicted variance.
    pub innovation_variance: [f64; MAX_OUTPUTS],
    /// Square of innovation over gate; above 1 the gate refuses.
    pub test_ratio: [f64; MAX_OUTPUTS],
    /// Outputs refused (gate, stuck sensor, nonsense), bit mask.
    pub rejected: u32,
    /// Outputs used, bit mask.
    pub fused: u32,
}

impl InnovationRecord {
    /// Normalised innovation squared over every output that was compared, refused ones too, and its degrees of freedom.
    pub fn nis(&self) -> (f64, u32) {
        let mut nis = 0.0;
        let mut dof = 0;
        for (innovation, variance) in self.innovation.iter().zip(&self.innovation_variance) {
            if *variance > 0.0 {
                nis += innovation * innovation / variance;
                dof += 1;
            }
        }
        (nis, dof)
    }
}

/// Adhesion and brake friction of one wagon at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct EstimatorOutput {
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
    /// Pad friction of each wheelset: brake torque over brake radius and measured pressing force.
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
    /// Normalised innovation squared of this step.
    pub nis: f64,
    /// Measurements behind `nis`: its degrees of freedom.
    pub nis_dof: u32,
    /// Wheelsets whose pad friction the data determine, bit mask.
    pub observable: u32,
    /// Wheelsets that slide or spin, bit mask.
    pub sliding: u32,
    /// Wheelsets whose slide protection acts, bit mask.
    pub wsp_active: u32,
    /// Outputs refused, bit mask: bit 0 the speed, bit `1 + i` wheelset `i`.
    pub rejected: u32,
    /// Rank of the local observability matrix.
    pub observability_rank: u32,
    /// See [`flags`].
    pub flags: u32,
    /// Wheelsets of this wagon.
    pub wheelsets: u32,
    /// What the estimate is worth.
    pub state: EstimateState,
    /// Adhesion that the contact offers at most (μ0); 0 where the filter does not estimate it.
    pub adhesion_peak: f64,
    /// 1 σ of `adhesion_peak`.
    pub adhesion_peak_sigma: f64,
    /// What came beside what was expected.
    pub innovations: InnovationRecord,
}
