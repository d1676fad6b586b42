//! Noise of the sensors: level and colour.

use railgrip_vehicle::Sensors;
use railgrip_vehicle::fast::SPEEDS;

/// Noise of one output: a white part and a part with the correlation of a first-order lag.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorNoise {
    /// Standard deviation of the white part.
    pub white: f64,
    /// Standard deviation of the coloured part.
    pub coloured: f64,
    /// Correlation time of the coloured part, s.
    pub time_s: f64,
}

impl SensorNoise {
    /// White noise of this standard deviation.
    pub fn white(sigma: f64) -> Self {
        Self { white: sigma, coloured: 0.0, time_s: 1.0 }
    }

    /// What a vehicle file says of its sensors.
    pub fn of_file(sensors: &Sensors) -> [Self; SPEEDS] {
        let wheel = Self::white(sensors.wheel_speed_sigma_rad_s);
        let mut noise = [wheel; SPEEDS];
        noise[0] = Self::white(sensors.speed_sigma_m_s);
        noise
    }

    /// Standard deviation of one reading.
    pub fn level(&self) -> f64 {
        self.white.hypot(self.coloured)
    }
}
