//! Friction brake: torque of the pads, dynamics of their friction, and brake cylinders.
//!
//! | equation | source | where |
//! | --- | --- | --- |
//! | `T_B = μ_B F_⊥ r_B` | Schwarz & Keck (6), (7) | [`pad_torque_nm`] |
//! | `μ̇_B = (μ_0 − μ_B) / (t_μ μ_B)` | Schwarz & Keck (9) | [`FirstOrderFriction`] |
//! | first-order filling and venting | UIC 540 | [`BrakeCylinder`] |

mod cylinder;
mod friction;
mod pad;

pub use cylinder::BrakeCylinder;
pub use friction::FirstOrderFriction;
pub use pad::{pad_torque_nm, pressing_force_for_n};
