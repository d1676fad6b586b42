//! A sample after hygiene: what drives the prediction, complete and finite, and what was measured.

use railgrip_vehicle::MAX_WHEELSETS;

/// One instant as a filter sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrivenSample {
    /// Vehicle speed, m/s; NaN if not measured.
    pub v_m_s: f64,
    /// Wheelset speeds, rad/s; NaN where not measured.
    pub wheel_speed_rad_s: [f64; MAX_WHEELSETS],
    /// Pressing force now, N.
    pub pressing_force_n: [f64; MAX_WHEELSETS],
    /// Pressing force over the step that ends now, N.
    pub step_force_n: [f64; MAX_WHEELSETS],
    /// Change of pressing force over that step, N.
    pub force_change_n: [f64; MAX_WHEELSETS],
    /// Wheelsets whose pressing force is known (measured, or held for a short time), bit mask.
    pub force_known: u32,
    /// Drive torque over the step, N m.
    pub drive_torque_nm: [f64; MAX_WHEELSETS],
    /// Brake torque of the model with its effects over the same without: 1 for the nominal model.
    pub torque_factor: [f64; MAX_WHEELSETS],
    /// Grade, couplers and effects as acceleration of the wagon, m/s², forward positive.
    pub other_acceleration_m_s2: f64,
    /// Headwind that the model knows of, m/s.
    pub wind_m_s: f64,
    /// Uncertainty of the grade, rad.
    pub grade_sigma_rad: f64,
    /// Sand on the rail, 0 to 1.
    pub sanding: f64,
    /// Mass of the wagon as a load sensor tells it, kg; NaN if not measured.
    pub load_kg: f64,
}

impl Default for DrivenSample {
    fn default() -> Self {
        Self {
            v_m_s: f64::NAN,
            wheel_speed_rad_s: [f64::NAN; MAX_WHEELSETS],
            pressing_force_n: [0.0; MAX_WHEELSETS],
            step_force_n: [0.0; MAX_WHEELSETS],
            force_change_n: [0.0; MAX_WHEELSETS],
            force_known: (1 << MAX_WHEELSETS) - 1,
            drive_torque_nm: [0.0; MAX_WHEELSETS],
            torque_factor: [1.0; MAX_WHEELSETS],
            other_acceleration_m_s2: 0.0,
            wind_m_s: 0.0,
            grade_sigma_rad: 0.0,
            sanding: 0.0,
            load_kg: f64::NAN,
        }
    }
}

impl DrivenSample {
    /// True if the pressing force of `wheelset` is known.
    #[inline]
    pub fn knows_force(&self, wheelset: usize) -> bool {
        self.force_known & (1 << wheelset) != 0
    }

    /// The measured value of an output: 0 the vehicle speed, `1 + i` wheelset `i`.
    #[inline]
    pub fn measured(&self, output: usize) -> f64 {
        if output == 0 { self.v_m_s } else { self.wheel_speed_rad_s[output - 1] }
    }

    /// The vehicle speed, or the best substitute the sample has: the fastest wheelset rim, m/s.
    pub fn speed_or_rim_m_s(&self, wheel_radius_m: &[f64]) -> f64 {
        if self.v_m_s.is_finite() {
            return self.v_m_s;
        }
        let rims = self.wheel_speed_rad_s.iter().zip(wheel_radius_m).map(|(speed, radius)| speed * radius);
        rims.filter(|rim| rim.is_finite()).fold(0.0, f64::max)
    }
}
