//! Wheel–rail adhesion: tangential force over creepage, and the adhesion available.

mod curtius_kniffler;
mod polach;

pub use curtius_kniffler::curtius_kniffler;
pub use polach::{ContactForce, creep_force, creep_force_at, creep_force_pair, friction};
