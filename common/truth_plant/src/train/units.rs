//! What all parts of the train share.

/// Standard gravity, m/s².
pub(crate) const GRAVITY_M_S2: f64 = 9.806_65;

/// One value a wheelset, front first; wagons with two leave the rest at zero.
pub type PerWheelset = [f64; 4];
