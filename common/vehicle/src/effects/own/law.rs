//! The laws that an own effect can change.

/// A law of the model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// Force that arrives at the pads of a wheelset, N.
    PadForce,
    /// Pad friction of a wheelset.
    BrakeFriction,
    /// Torque with which a wheelset is held back, N m.
    BrakeTorque,
    /// Drive torque on a wheelset, N m.
    DriveTorque,
    /// Adhesion available under a wheelset.
    Adhesion,
    /// Headwind, m/s.
    Headwind,
    /// Force on the body beyond contact, resistance and grade, N.
    BodyForce,
    /// What the sensor of vehicle speed reads, m/s.
    SpeedReading,
    /// What the sensor of a wheelset's speed reads, rad/s.
    WheelSpeedReading,
}

/// The laws by name; names end in their unit.
pub const LAWS: [(&str, Law); 9] = [
    ("pad_force_n", Law::PadForce),
    ("brake_friction", Law::BrakeFriction),
    ("brake_torque_nm", Law::BrakeTorque),
    ("drive_torque_nm", Law::DriveTorque),
    ("adhesion_peak", Law::Adhesion),
    ("headwind_m_s", Law::Headwind),
    ("body_force_n", Law::BodyForce),
    ("speed_reading_m_s", Law::SpeedReading),
    ("wheel_speed_reading_rad_s", Law::WheelSpeedReading),
];

impl Law {
    /// The law of that name.
    pub fn from_name(name: &str) -> Option<Self> {
        LAWS.iter().find(|(known, _)| *known == name).map(|(_, law)| *law)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        LAWS.iter().find(|(_, law)| *law == self).map_or("", |(name, _)| name)
    }
}

/// All names.
pub(super) fn names() -> String {
    LAWS.map(|(name, _)| name).join(", ")
}
