//! The longitudinal physics of a railway wagon: wheelsets, contact, brakes, resistance and actuation.
//!
//! # Sign convention
//! Position, speed and forces on the wagon are forward positive; a wheel speed is positive when the wheel rolls
//! forward. The contact force acts *on the wagon*. Creepage `s = (r ω − v) / max(v, 0.5 m/s)` is negative while
//! braking (slide) and positive in traction (spin). A brake torque opposes rotation: it can stop a wheel and hold
//! it, never turn it backwards.
//!
//! # Glossary
//! * *adhesion utilised* – tangential over normal force at the contact, signed like the force;
//!   *adhesion available* (`adhesion_peak`) – its limit.
//! * *brake friction* – coefficient between pad and disc; *pressing force* – normal force on the pad as inferred
//!   from brake-cylinder pressure; *pad force* – what arrives at the pad.
//! * *effect* – a law modifier that composes with the laws of [`WagonModel`], see [`effects`].
//!
//! All quantities are SI `f64`; wheelsets are counted from the front, at most [`MAX_WHEELSETS`].

pub mod adhesion;
pub mod bogie_rig;
pub mod brake;
pub mod effects;
pub mod load;
mod parameters;
pub mod resistance;
pub mod roller_rig;
pub mod traction_rig;
mod wagon;

pub use parameters::{
    Body, Brake, Contact, EffectEntry, ParameterError, Rail, RailClass, Resistance, Sensors,
    VehicleParameters, Wheelset,
};
pub use wagon::fast;
pub use wagon::{Constants, Forces, Loading, ModelError, WagonInput, WagonModel, WagonState};

/// Most wheelsets that a wagon can have; arrays per wheelset have this length, and entries beyond the wagon's own
/// count are zero.
pub const MAX_WHEELSETS: usize = 4;

/// One value for each wheelset, leading wheelset first.
pub type PerWheelset = [f64; MAX_WHEELSETS];

/// Standard gravity, m/s².
pub const GRAVITY_M_S2: f64 = 9.80665;

/// Speed below which creepage is referred to this speed instead, m/s (keeps it finite at standstill).
pub const CREEPAGE_SPEED_FLOOR_M_S: f64 = 0.5;

/// Creepage `(r ω − v) / max(v, 0.5 m/s)` of a wheel of circumferential speed `rim_speed_m_s` on a vehicle of speed
/// `v_m_s`; dimensionless, negative while braking.
#[inline]
pub fn creepage(rim_speed_m_s: f64, v_m_s: f64) -> f64 {
    (rim_speed_m_s - v_m_s) / v_m_s.max(CREEPAGE_SPEED_FLOOR_M_S)
}
