//! Accuracy of the sensors that a filter works with.

use crate::EstimatorConfig;
use railgrip_vehicle::VehicleParameters;

/// One sigma of each sensor: the vehicle file's, unless the settings say otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorSigmas {
    /// Vehicle speed, m/s.
    pub speed_m_s: f64,
    /// Wheelset speed, rad/s.
    pub wheel_speed_rad_s: f64,
    /// Pressing force, N.
    pub pressing_force_n: f64,
}

impl SensorSigmas {
    /// From settings and vehicle.
    pub fn new(config: &EstimatorConfig, vehicle: &VehicleParameters) -> Self {
        let (own, declared) = (&config.sensors, &vehicle.sensors);
        Self {
            speed_m_s: own.speed_sigma_m_s.unwrap_or(declared.speed_sigma_m_s),
            wheel_speed_rad_s: own.wheel_speed_sigma_rad_s.unwrap_or(declared.wheel_speed_sigma_rad_s),
            pressing_force_n: own.pressing_force_sigma_n.unwrap_or(declared.pressing_force_sigma_n),
        }
    }

    /// Variance of an output: 0 the vehicle speed, others wheelset speeds.
    #[inline]
    pub fn variance(&self, output: usize) -> f64 {
        let sigma = if output == 0 { self.speed_m_s } else { self.wheel_speed_rad_s };
        sigma * sigma
    }
}
