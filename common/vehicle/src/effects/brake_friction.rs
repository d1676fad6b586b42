//! Effects on the coefficient between pad and disc.

use super::{Effect, EffectSpec, Operating, ParameterSpec, Term};
use crate::MAX_WHEELSETS;

/// Thermal fade.
pub static FADE: EffectSpec = EffectSpec {
    id: "brake_fade",
    term: Term::BrakeFriction,
    equation: "mu = mu0 (1 - alpha (T - T0)), C dT/dt = P_brake - (T - T0) C / tau",
    source: "linear fade over a lumped disc temperature; organic pads lose 2e-4 to 1.5e-3 of their friction per kelvin",
    parameters: &[
        ParameterSpec {
            name: "alpha_per_k",
            unit: "1/K",
            lower: -3e-3,
            upper: 3e-3,
            default: 5e-4,
            neutral: Some(0.0),
            prior_sigma: f64::INFINITY,
        },
        ParameterSpec {
            name: "heat_capacity_j_per_k",
            unit: "J/K",
            lower: 5e3,
            upper: 5e5,
            default: 6e4,
            neutral: None,
            prior_sigma: f64::INFINITY,
        },
        ParameterSpec {
            name: "cooling_time_s",
            unit: "s",
            lower: 20.0,
            upper: 2000.0,
            default: 300.0,
            neutral: None,
            prior_sigma: f64::INFINITY,
        },
    ],
    hidden: &["temperature rise of each wheelset's discs, K"],
    twins: &["brake_friction_speed"],
    separated_by: "two stops from the same speed in quick succession, and one after a long cool-down",
};

/// See [`FADE`].
#[derive(Debug)]
pub struct Fade {
    alpha_per_k: f64,
    heat_capacity_j_per_k: f64,
    cooling_time_s: f64,
}

impl Fade {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { alpha_per_k: values[0], heat_capacity_j_per_k: values[1], cooling_time_s: values[2] })
    }
}

impl Effect for Fade {
    fn spec(&self) -> &'static EffectSpec {
        &FADE
    }

    fn hidden_len(&self, _sample_period_s: f64) -> usize {
        MAX_WHEELSETS
    }

    fn advance(&self, at: &Operating, dt_s: f64, hidden: &mut [f64]) {
        let decay = (-dt_s / self.cooling_time_s).exp();
        for (rise, power) in hidden.iter_mut().zip(at.brake_power_w) {
            let steady = power * self.cooling_time_s / self.heat_capacity_j_per_k;
            *rise = steady + (*rise - steady) * decay;
        }
    }

    fn brake_friction(&self, wheelset: usize, _at: &Operating, hidden: &[f64], friction: f64) -> f64 {
        friction * (1.0 - self.alpha_per_k * hidden[wheelset]).max(0.05)
    }
}
