//! What all parts of a family wagon share.

/// Most wheelsets of a wagon.
pub const MOST_WHEELSETS: usize = 4;

/// One value a wheelset, front first; the rest is zero.
pub type PerWheelset = [f64; MOST_WHEELSETS];
