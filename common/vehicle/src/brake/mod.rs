//! Friction brake: pad friction and brake-cylinder dynamics.

mod cylinder;
mod friction;

pub use cylinder::BrakeCylinder;
pub use friction::FirstOrderFriction;
