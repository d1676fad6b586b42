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

/// What no train does: values beyond are not known, however a sensor or its line came to say them.
const SPEED_M_S: (f64, f64) = (-150.0, 150.0);
const WHEEL_SPEED_RAD_S: (f64, f64) = (-1e3, 1e3);
const PRESSING_FORCE_N: (f64, f64) = (-1e5, 1e6);
const DRIVE_TORQUE_NM: (f64, f64) = (-1e6, 1e6);
const GRADE_RAD: (f64, f64) = (-0.3, 0.3);
const LOAD_KG: (f64, f64) = (0.0, 1e6);
const BRAKE_DEMAND: (f64, f64) = (-0.5, 2.0);

impl Reading {
    /// Makes values that cannot be unknown; returns how many there were. NaN is unknown already.
    pub(crate) fn doubt(&mut self) -> u64 {
        let mut doubted = 0;
        let mut one = |value: &mut f64, (low, high): (f64, f64)| {
            if !value.is_nan() && !(low..=high).contains(value) {
                *value = f64::NAN;
                doubted += 1;
            }
        };
        one(&mut self.v_m_s, SPEED_M_S);
        self.wheel_speed_rad_s.iter_mut().for_each(|value| one(value, WHEEL_SPEED_RAD_S));
        self.pressing_force_n.iter_mut().for_each(|value| one(value, PRESSING_FORCE_N));
        self.drive_torque_nm.iter_mut().for_each(|value| one(value, DRIVE_TORQUE_NM));
        one(&mut self.grade_rad, GRADE_RAD);
        one(&mut self.load_kg, LOAD_KG);
        one(&mut self.brake_demand, BRAKE_DEMAND);
        doubted
    }
}
