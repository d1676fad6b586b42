//! The 1/5 scale traction rig of Zhao, Liang & Iwnicki (VSD 52 (S1), 2014): an induction motor drives a wheelset
//! through a gear, the wheels drive rollers, and a DC generator loads the rollers.
//!
//! ```text
//! J_eqv ω̇_motor  = T_e − 2 R_wheel F_γ / i ,   J_eqv = J_motor + J_wheel / i²       (3-1), mended
//! ω_wheel         = ω_motor / i                                                      (3-2)
//! J_roller ω̇_roll = 2 R_roller F_γ − T_load                                          (3-3)
//! γ = (R_wheel ω_wheel − R_roller ω_roller) / V ,  V = ½ (R_roller ω_roller + R_wheel ω_wheel)
//! ```
//!
//! `F_γ` is the creep force of one of the two wheels, positive in traction. The paper's (3-1) multiplies the contact
//! torque by the gear ratio instead of dividing by it, which creates power; (3-4) holds for a number of poles,
//! not of pole pairs; rows B and D of its Table 1 are exchanged. All three are mended here and pinned by tests.
//!
//! # Glossary
//! * *α, β* – axes of the stator's frame; amplitude-invariant two-phase quantities.
//! * *creepage* γ and *slip velocity* w = γ V – between wheel and roller, positive in traction.
//! * *load coefficient* – T_load over ω_roller, N m s/rad, set by the load resistance.

mod drive;
mod generator;
mod motor;
mod parameters;
mod rig;

pub use drive::{Drive, DriveParameters};
pub use generator::Generator;
pub use motor::{Motor, MotorParameters, MotorState};
pub use parameters::{Drivetrain, RigParameters, Surface};
pub use rig::{RigState, TractionRig, WheelContact};
