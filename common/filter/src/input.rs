//! What an estimator takes in: one sample of what it watches.

use crate::models::bogie_rig::BogieSample;
use crate::models::traction_rig::TractionSample;
use railgrip_vehicle::MAX_WHEELSETS;
use serde::{Deserialize, Serialize};

/// One sample, by what is watched. An estimator of another plant ignores it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EstimatorInput {
    /// Of a wagon, or of a roller rig, which has the same sensors.
    Wagon(WagonSample),
    /// Of a rig with a driven wheelset.
    Traction(TractionSample),
    /// Of a braked bogie on driven rollers.
    Bogie(BogieSample),
}

impl EstimatorInput {
    /// Time base of the sensors, s; the filter steps on its differences.
    pub const fn time_s(&self) -> f64 {
        match self {
            Self::Wagon(sample) => sample.time_s,
            Self::Traction(sample) => sample.time_s,
            Self::Bogie(sample) => sample.time_s,
        }
    }
}

impl From<WagonSample> for EstimatorInput {
    fn from(sample: WagonSample) -> Self {
        Self::Wagon(sample)
    }
}

/// The sensors of one wagon at one instant. A value that is missing is NaN.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WagonSample {
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
    /// Mass of the wagon as a load sensor tells it, kg.
    pub load_kg: f64,
    /// Wheelsets whose slide protection says that it acts, bit mask; handed through.
    pub wsp_active: u32,
}

impl WagonSample {
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
            load_kg: f64::NAN,
            wsp_active: 0,
        }
    }
}
