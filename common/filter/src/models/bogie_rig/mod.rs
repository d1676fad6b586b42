//! Adhesion of the bogie rig of Shrestha, Spiryagin & Wu (2021) from torque transducer, load cell and pulse counters,
//! and what its decision-maker makes of it.
//!
//! * [`slip_based`] – the paper's (2) and (3), and (3) with the inertia terms that it leaves out;
//! * [`BogieFilter`] – a Kalman filter for the same sensors: adhesion, slip and zero errors, with innovations;
//! * [`DecisionMaker`] – heard condition, Polach curve, the rule of 0.2, and the optimum slip; [`RailListener`] is the
//!   seam that a classifier of rolling noise fits.
//!
//! Adhesion `mu_w` is that of the whole bogie, signed like the contact forces (braking negative): neither the link
//! nor the shaft can tell its wheelsets apart. The paper's λ and μ̂_c are positive in braking.
//!
//! Everything here is advice: nothing drives a brake.

mod decision;
mod filter;
mod model;
mod sample;
pub mod slip_based;
mod watch;

pub use decision::{
    Decision, DecisionMaker, HeardCondition, OptimumSlip, RULE_DIFFERENCE, RailListener, optimum_slip,
};
pub use filter::{BogieFilter, GATE_SIGMA};
pub use model::{BogieModel, BogieNoise, BogieVector, STATES, index};
pub use sample::{BogieEstimate, BogieInputState, BogieSample, OUTPUTS};
