//! What the rig's filter takes in and gives out.

use crate::InnovationRecord;

/// Number of measured values.
pub const OUTPUTS: usize = 7;

/// The sensors of a traction rig at one instant, in the order of Zhao et al. (5-4). A value that is missing is NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TractionSample {
    /// Time, s.
    pub time_s: f64,
    /// Stator current (α, β), A.
    pub current_a: [f64; 2],
    /// Speed of the motor, rad/s.
    pub motor_speed_rad_s: f64,
    /// Stator voltage (α, β), V.
    pub voltage_v: [f64; 2],
    /// Speed of the roller, rad/s.
    pub roller_speed_rad_s: f64,
    /// Current of the generator, A.
    pub generator_current_a: f64,
}

impl TractionSample {
    /// An instant of which nothing but the time is known.
    pub const fn missing(time_s: f64) -> Self {
        Self {
            time_s,
            current_a: [f64::NAN; 2],
            motor_speed_rad_s: f64::NAN,
            voltage_v: [f64::NAN; 2],
            roller_speed_rad_s: f64::NAN,
            generator_current_a: f64::NAN,
        }
    }

    /// The measured values in the order of (5-4).
    pub fn outputs(&self) -> [f64; OUTPUTS] {
        [
            self.current_a[0],
            self.current_a[1],
            self.motor_speed_rad_s,
            self.voltage_v[0],
            self.voltage_v[1],
            self.roller_speed_rad_s,
            self.generator_current_a,
        ]
    }
}

/// What an estimate of μ0 is worth.
pub type TractionState = crate::EstimateState;

/// Contact of the rig at one instant. All `sigma` are one standard deviation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TractionEstimate {
    /// That of the sample, s.
    pub time_s: f64,
    /// Creepage γ.
    pub creepage: f64,
    /// 1 σ of it.
    pub creepage_sigma: f64,
    /// Creep force of one wheel F_γ, N.
    pub creep_force_n: f64,
    /// 1 σ of it, N.
    pub creep_force_sigma_n: f64,
    /// Traction coefficient μ at the present slip velocity.
    pub friction: f64,
    /// Friction coefficient μ0.
    pub adhesion_peak: f64,
    /// 1 σ of it.
    pub adhesion_peak_sigma: f64,
    /// What `adhesion_peak` is worth.
    pub state: TractionState,
    /// Normalised innovation squared of this step.
    pub nis: f64,
    /// Values behind `nis`.
    pub nis_dof: u32,
    /// Values refused by the gate, bit mask in the order of (5-4).
    pub rejected: u32,
    /// What came beside what was expected, in the order of (5-4).
    pub innovations: InnovationRecord,
}
