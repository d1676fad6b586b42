//! The indicators of one wagon, as the estimator computes them at full rate.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::{Grade, MAX_WHEELSETS, Stamp, Text, payload, zero_default};

/// Places for indicators of a wagon.
pub const MAX_INDICATORS: usize = 20;
/// Places for indicators of a wheelset.
pub const MAX_WHEELSET_INDICATORS: usize = 10;

/// One judged figure with its 95 % interval, its grade and the reason in words. Which indicator stands in which place of
/// [`Health`] says the table of indicators, `INDICATORS` in the crate of the indicators.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("railgrip/Indicator/v1")]
pub struct Indicator {
    /// The figure, in the unit that the field of the indicator names.
    pub value: f64,
    /// Lower end of the 95 % interval; equal to `value` when there is none.
    pub low: f64,
    /// Upper end of the 95 % interval; equal to `value` when there is none.
    pub high: f64,
    /// Code of a [`Grade`].
    pub grade: u32,
    /// 1 if `value` holds a figure, 0 if nothing is known yet.
    pub known: u32,
    /// Why this grade.
    pub reason: Text,
}
zero_default!(Indicator);

impl Indicator {
    /// The grade; unknown codes read as [`Grade::Unknown`].
    #[must_use]
    pub const fn grade(&self) -> Grade {
        match Grade::from_code(self.grade) {
            Some(grade) => grade,
            None => Grade::Unknown,
        }
    }

    /// The figure, if there is one.
    #[must_use]
    pub const fn figure(&self) -> Option<f64> {
        if self.known == 0 { None } else { Some(self.value) }
    }
}

/// The part of [`Health`] that belongs to one wheelset.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("railgrip/WheelsetHealth/v3")]
pub struct WheelsetHealth {
    /// Its indicators, in the places that the table of indicators gives them.
    pub indicator: [Indicator; MAX_WHEELSET_INDICATORS],
    /// Pad friction, mean over braking, over its nominal value.
    pub brake_friction_ratio: f64,
    /// Energy dissipated by sliding, J.
    pub slide_energy_j: f64,
    /// Time spent sliding, s.
    pub slide_s: f64,
    /// Pad friction now, and its 1 σ.
    pub mu_b: f64,
    /// 1 σ of `mu_b`.
    pub mu_b_sigma: f64,
    /// Adhesion utilised now, signed.
    pub mu_w: f64,
    /// 1 σ of `mu_w`.
    pub mu_w_sigma: f64,
    /// Creepage now.
    pub slip: f64,
    /// Pressing force now, N.
    pub pressing_force_n: f64,
    /// 1 if the adhesion available is only a lower bound.
    pub adhesion_available_is_bound: u32,
    /// 1 if the pad friction is observable now.
    pub observable: u32,
    /// 1 if the wheelset slides or spins now.
    pub sliding: u32,
    /// 1 if its slide protection acts now.
    pub wsp_active: u32,
}
zero_default!(WheelsetHealth);

/// The indicators of one wagon (channel `health/N`, about 5 Hz; late joiners get the last one).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("railgrip/Health/v4")]
pub struct Health {
    /// Sequence of the last sample that went in.
    pub sequence: u64,
    /// When that sample was taken: the age of everything here.
    pub acquired: Stamp,
    /// When this was published, monotonic clock, ns.
    pub published_monotonic_ns: u64,
    /// Time base of the sensors at that sample, s.
    pub time_s: f64,
    /// The wagon.
    pub wagon: u32,
    /// Wheelsets of this wagon.
    pub wheelsets: u32,
    /// Code of the worst [`Grade`] of all indicators.
    pub grade: u32,
    /// Code of the most probable [`crate::Condition`]; `u32::MAX` if unknown.
    pub condition: u32,
    /// Probability of each condition, in the order of the codes of [`crate::Condition`].
    pub condition_probability: [f64; 4],
    /// Speed now, m/s.
    pub v_m_s: f64,
    /// Adhesion utilised by the wagon now, signed, with its 1 σ.
    pub mu_w: f64,
    /// 1 σ of `mu_w`.
    pub mu_w_sigma: f64,
    /// Pad friction now, mean of the wheelsets weighted with their pressing forces.
    pub mu_b_mean: f64,
    /// 1 σ of `mu_b_mean`.
    pub mu_b_mean_sigma: f64,
    /// Position along the track, m; 0 if unknown.
    pub position_m: f64,
    /// Braking so far, s.
    pub braking_s: f64,
    /// Samples taken in.
    pub samples: u64,
    /// Samples that never arrived.
    pub missed: u64,
    /// Outputs refused by the gate.
    pub rejected: u64,
    /// Its indicators, in the places that the table of indicators gives them.
    pub indicator: [Indicator; MAX_INDICATORS],
    /// When the latest brake application began; zeros before the first.
    pub brake_applied: Stamp,
    /// Brake applications so far.
    pub brake_applications: u64,
    /// Pressing force of all wheelsets now, N.
    pub pressing_force_n: f64,
    /// Sand on the rail now, 0 to 1.
    pub sanding_now: f64,
    /// By wheelset.
    pub wheelset: [WheelsetHealth; MAX_WHEELSETS],
    /// 1 if the adhesion available is only a lower bound.
    pub adhesion_available_is_bound: u32,
    /// Sensors that are missing, refused or dead, bits as in [`crate::valid`].
    pub faulty_sensors: u32,
    /// Number of the vehicle, as it is written; empty where nobody has given one.
    pub vehicle: Text,
}
payload!(Health, "railgrip/Health/v4");

impl Health {
    /// Wheelsets in use, never more than there are places.
    #[must_use]
    pub const fn wheelset_count(&self) -> usize {
        let count = self.wheelsets as usize;
        if count < MAX_WHEELSETS { count } else { MAX_WHEELSETS }
    }

    /// The worst grade; unknown codes read as [`Grade::Unknown`].
    #[must_use]
    pub const fn grade(&self) -> Grade {
        match Grade::from_code(self.grade) {
            Some(grade) => grade,
            None => Grade::Unknown,
        }
    }
}
