//! The filters of Zhao et al.'s traction rig: creep force, creepage and friction from motor currents, voltages and
//! speeds.
//!
//! State (5-3), 13: `[I_α, I_β, ψ_α, ψ_β, ω_motor, U_α, U_β, γ, F_γ, ω_roller, μ, μ0, I_dc]`; the paper's noise
//! vector w_k lists twelve values for it, here every state has one. Measured (5-4), 7:
//! `[I_α, I_β, ω_motor, U_α, U_β, ω_roller, I_dc]`, each a state, so that the measurement is linear.
//!
//! # What the model adds to the paper's
//! * The contact is stiffer than the sample rate: F_γ drives the speeds through one linearly implicit step.
//! * The voltage vector turns with the flux instead of standing still between samples (the paper's random walk).
//! * μ0 is carried as its logarithm, so that it stays positive and its sigma is relative.
//! * μ0 forgets: without evidence it returns to what is known beforehand, with that sigma, instead of wandering
//!   without bound. That makes "nothing seen" visible as a sigma near the prior's.
//!
//! [`TractionUkf`] and [`TractionEkf`] run the same model on the same samples.

mod filters;
mod model;
mod sample;

pub use filters::{Extended, TractionBelief, TractionEkf, TractionFilter, TractionUkf, Unscented};
pub use model::{PRIOR_LN_SIGMA, STATES, State, TractionModel, TractionNoise, adhesion_peak, index};
pub use sample::{OUTPUTS, TractionEstimate, TractionSample, TractionState};
