//! Wheel–rail adhesion: tangential force over creepage, and the adhesion available over speed.
//!
//! | equation | source | where |
//! | --- | --- | --- |
//! | `F = sign(s) (2 Q μ/π) [k_A ε/(1+(k_A ε)²) + atan(k_S ε)]`, `ε = K \|s\|/(Q μ)` | Polach, Wear 258 (2005); Zhao et al. (3-9), (3-10) | [`creep_force`] |
//! | `μ(w) = μ0 [(1−A) e^(−B w) + A]` | Polach; Zhao et al. (3-11) | [`friction`] |
//! | `μ(v) = 7.5/(3.6 v + 44) + 0.161` | Curtius & Kniffler (1944) | [`curtius_kniffler`] |

mod curtius_kniffler;
mod polach;

pub use curtius_kniffler::{ASYMPTOTE_SHARE, SPEED_DECAY_S_PER_M, curtius_kniffler, share_of_standstill};
pub(crate) use polach::creep_force_pair_at;
pub use polach::{ContactForce, creep_force, creep_force_at, friction, initial_creep_slope_n};
