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
//! # Where an equation stands
//! | what | equation | module |
//! | --- | --- | --- |
//! | motion of wheelset and body | Schwarz & Keck (1), (6) | [`motion`] |
//! | normal loads and their transfer | Schwarz & Keck (2), (4), (5), (11) | [`load`] |
//! | creep force, falling friction | Polach; Zhao et al. (3-9) to (3-12) | [`adhesion`] |
//! | adhesion over vehicle speed | Curtius & Kniffler | [`adhesion`] |
//! | brake torque, pad friction, cylinders | Schwarz & Keck (6), (7), (9); UIC 540 | [`brake`] |
//! | running resistance, grade | Schwarz & Keck (1); Davis | [`resistance`] |
//! | what else a model may need | one file a term | [`effects`] |
//! | roller rig with one braked wheelset | Schwarz & Keck, section 3 | [`roller_rig`] |
//! | braked bogie on rollers | Shrestha et al., section 2 | [`bogie_rig`] |
//! | driven wheelset with its motor | Zhao et al., chapter 3 | [`traction_rig`] |
//!
//! Figures that several places share are [`constants`].
//!
//! All quantities are SI `f64`; wheelsets are counted from the front, at most [`MAX_WHEELSETS`].

pub mod adhesion;
pub mod bogie_rig;
pub mod brake;
pub mod constants;
pub mod effects;
pub mod load;
pub mod motion;
mod parameters;
pub mod resistance;
pub mod roller_rig;
pub mod traction_rig;
mod wagon;

pub use constants::{CREEPAGE_SPEED_FLOOR_M_S, GRAVITY_M_S2};
pub use effects::ModelError;
pub use parameters::{
    Body, Bogie, Brake, Contact, EffectEntry, ParameterError, Rail, RailClass, Resistance, Running, Sensors,
    VehicleParameters, Wheelset,
};
pub use wagon::fast;
pub use wagon::{Constants, Forces, Loading, SampleStep, Slopes, WagonInput, WagonModel, WagonState};

/// Most wheelsets that a wagon can have; arrays per wheelset have this length, and entries beyond the wagon's own
/// count are zero.
pub const MAX_WHEELSETS: usize = 4;

/// One value for each wheelset, leading wheelset first.
pub type PerWheelset = [f64; MAX_WHEELSETS];

/// Creepage `(r ω − v) / max(v, 0.5 m/s)` of a wheel of circumferential speed `rim_speed_m_s` on a vehicle of speed
/// `v_m_s`; dimensionless, negative while braking.
#[inline]
pub fn creepage(rim_speed_m_s: f64, v_m_s: f64) -> f64 {
    (rim_speed_m_s - v_m_s) / v_m_s.max(CREEPAGE_SPEED_FLOOR_M_S)
}
