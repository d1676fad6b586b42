//! One instant of one simulated wagon: what its sensors say, and what no sensor sees.

use railgrip_recording::{Row, TruthRow};
use railgrip_vehicle::{PerWheelset, RailClass};

/// One instant of one wagon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WagonSample {
    /// What the sensors say; NaN = missing, also beyond the wagon's own wheelsets.
    pub row: Row,
    /// Whether the wagon sends this sample at all.
    pub present: bool,
    /// Number of wheelsets.
    pub wheelsets: usize,
    /// What no sensor sees.
    pub truth: WagonTruth,
}

/// The state of the models behind one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WagonTruth {
    /// What a truth file holds.
    pub row: TruthRow,
    /// Position of the wagon's middle.
    pub position_m: f64,
    /// Angular speed of each wheelset.
    pub wheel_speed_rad_s: PerWheelset,
    /// Pressing force of each wheelset.
    pub pressing_force_n: PerWheelset,
    /// Adhesion available under each wheelset.
    pub adhesion_available: PerWheelset,
    /// Normal load of each wheelset.
    pub normal_load_n: PerWheelset,
    /// Contact force of each wheelset, forward positive.
    pub contact_force_n: PerWheelset,
    /// Running resistance, positive against forward motion.
    pub resistance_n: f64,
    /// Acceleration of the body.
    pub acceleration_m_s2: f64,
    /// Rail class under the wagon's middle.
    pub rail: RailClass,
}
