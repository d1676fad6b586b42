//! What the estimator takes in: the sensors of one wagon, or of one rig, at one instant.

use railgrip_vehicle::MAX_WHEELSETS;
use serde::{Deserialize, Serialize};

/// The sensors of a driven rig at one instant: Zhao et al. (5-4). A value that is missing is NaN.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MotorInput {
    /// Stator current (α, β), A.
    pub current_a: [f64; 2],
    /// Stator voltage (α, β), V.
    pub voltage_v: [f64; 2],
    /// Speed of the motor, rad/s.
    pub motor_speed_rad_s: f64,
    /// Speed of the roller, rad/s.
    pub roller_speed_rad_s: f64,
    /// Current of the generator, A.
    pub generator_current_a: f64,
}

impl MotorInput {
    /// Nothing is known.
    pub const MISSING: Self = Self {
        current_a: [f64::NAN; 2],
        voltage_v: [f64::NAN; 2],
        motor_speed_rad_s: f64::NAN,
        roller_speed_rad_s: f64::NAN,
        generator_current_a: f64::NAN,
    };
}

/// The sensors of a bogie rig at one instant: Shrestha et al., section 2. A value that is missing is NaN.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BogieInput {
    /// T_e between motor and gear, N m.
    pub shaft_torque_nm: f64,
    /// Force of the link, N, positive in braking.
    pub load_cell_n: f64,
    /// Pressure at the calipers, Pa.
    pub brake_pressure_pa: f64,
    /// Normal load of the bogie from its preloaded mass, N.
    pub load_n: f64,
    /// Pulses of the rollers' encoder in the window that ends now; NaN within a window.
    pub roller_pulses: f64,
    /// Pulses of each wheelset's encoder since the last sample.
    pub wheel_pulses: [f64; 2],
}

impl BogieInput {
    /// Nothing is known.
    pub const MISSING: Self = Self {
        shaft_torque_nm: f64::NAN,
        load_cell_n: f64::NAN,
        brake_pressure_pa: f64::NAN,
        load_n: f64::NAN,
        roller_pulses: f64::NAN,
        wheel_pulses: [f64::NAN; 2],
    };
}

/// The sensors of one wagon at one instant. A value that is missing is NaN.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EstimatorInput {
    /// Time base of the sensors, s; the filter steps on its differences.
    pub time_s: f64,
    /// Speed over ground, m/s.
    pub v_m_s: f64,
    /// Angular speed of each wheelset, rad/s, positive rolling forward; front first.
    pub wheel_speed_rad_s: [f64; MAX_WHEELSETS],
    /// Pressing force of the pads of each wheelset, N.
    pub pressing_force_n: [f64; MAX_WHEELSETS],
    /// Traction torque at each wheelset, N m, positive driving forward.
    pub drive_torque_nm: [f64; MAX_WHEELSETS],
    /// Slope of the track, rad, positive uphill.
    pub grade_rad: f64,
    /// Sand on the rail, 0 none to 1 full.
    pub sanding: f64,
    /// Position along the track, m.
    pub position_m: f64,
    /// Wheelsets whose slide protection says that it acts, bit mask; handed through.
    pub wsp_active: u32,
    /// Motor and rollers of a driven rig; all missing on a wagon.
    pub motor: MotorInput,
    /// Torque, link force, pulses and pressure of a bogie rig; all missing elsewhere.
    pub bogie: BogieInput,
}

impl EstimatorInput {
    /// An instant of which nothing but the time is known.
    pub const fn missing(time_s: f64) -> Self {
        Self {
            time_s,
            v_m_s: f64::NAN,
            wheel_speed_rad_s: [f64::NAN; MAX_WHEELSETS],
            pressing_force_n: [f64::NAN; MAX_WHEELSETS],
            drive_torque_nm: [f64::NAN; MAX_WHEELSETS],
            grade_rad: f64::NAN,
            sanding: f64::NAN,
            position_m: f64::NAN,
            wsp_active: 0,
            motor: MotorInput::MISSING,
            bogie: BogieInput::MISSING,
        }
    }
}
