//! Figures that several places of the program share, each once. A figure of one law alone stands beside that law.

/// Standard gravity g, m/s², as the 3rd CGPM (1901) defined it. Local gravity differs by up to 0.3 %.
///
/// What may not use this crate (the indicators) takes the same figure from the crate of the messages.
pub const GRAVITY_M_S2: f64 = 9.80665;

/// Speed below which creepage is referred to this speed instead, m/s: keeps it finite at standstill.
pub const CREEPAGE_SPEED_FLOOR_M_S: f64 = 0.5;

/// Heat capacity of the discs of one wheelset, J/K: two steel discs of about 60 kg with 500 J/(kg K). It scales rises of
/// temperature, and with them whatever is said per kelvin.
pub const DISC_HEAT_CAPACITY_J_PER_K: f64 = 6e4;

/// Time constant with which the friction ring of a disc cools, s: it hands its heat to the hub and to the air of a moving
/// train. This is what friction feels within a stop and shortly after it, hence the start of a fit of fade.
///
/// The indicators cool the *whole* disc, between stops, by `standard.disc_cooling_s` (600 s).
pub const FRICTION_RING_COOLING_S: f64 = 120.0;

/// Adhesion available above which a rail counts as dry.
pub const DRY_RAIL_ADHESION: f64 = 0.2;
