//! What goes in: what is believed of a wagon, and what its sensors say.

/// Most wheelsets of a wagon.
pub const MAX_WHEELSETS: usize = 4;

/// What is believed of a wagon.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct WagonFile {
    /// Wheelsets, at most [`MAX_WHEELSETS`].
    pub wheelsets: usize,
    /// Mass, kg.
    pub mass_kg: f64,
    /// One sigma of the mass, relative.
    pub mass_sigma: f64,
    /// Rolling radius, m.
    pub radius_m: f64,
    /// Inertia of one wheelset, kg m².
    pub inertia_kg_m2: f64,
    /// Radius at which the pads act, m.
    pub pad_radius_m: f64,
    /// Pad friction.
    pub pad_friction: f64,
    /// Creepage over tangential force of one wheelset at small creepage, 1/N.
    pub compliance_per_n: f64,
    /// Running resistance: N, N s/m, N s²/m².
    pub resistance: [f64; 3],
    /// One sigma of the speed (m/s) and of wheel speeds (rad/s).
    pub speed_sigma_m_s: f64,
    /// One sigma of a wheel speed, rad/s.
    pub wheel_speed_sigma_rad_s: f64,
}

/// What the sensors of one wagon say at one instant; NaN where nothing came.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Speed, m/s.
    pub v_m_s: f64,
    /// Wheel speeds, front first, rad/s.
    pub wheel_speed_rad_s: [f64; MAX_WHEELSETS],
    /// Pressing forces from cylinder pressure, N.
    pub pressing_force_n: [f64; MAX_WHEELSETS],
    /// Drive torques, braking negative, N m; NaN counts as none.
    pub drive_torque_nm: [f64; MAX_WHEELSETS],
    /// Slope, uphill positive, rad.
    pub grade_rad: f64,
    /// Mass by load sensors, kg.
    pub load_kg: f64,
    /// Brake that is ordered, 0 to 1.
    pub brake_demand: f64,
}

impl Default for Reading {
    fn default() -> Self {
        let none = [f64::NAN; MAX_WHEELSETS];
        Self {
            v_m_s: f64::NAN,
            wheel_speed_rad_s: none,
            pressing_force_n: none,
            drive_torque_nm: none,
            grade_rad: f64::NAN,
            load_kg: f64::NAN,
            brake_demand: f64::NAN,
        }
    }
}
