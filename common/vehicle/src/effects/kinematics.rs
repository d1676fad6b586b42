//! Effects on wheel geometry.

use super::{Effect, EffectSpec, ParameterSpec, Term};
use crate::wagon::Constants;

/// Radius error of the leading wheelset.
pub static WHEEL_RADIUS: EffectSpec = EffectSpec {
    id: "wheel_radius",
    term: Term::Kinematics,
    equation: "r_W,f = r_W (1 + e)",
    source: "differences of 0.2 to 1.5 % between wheelsets are usual between two turnings of the wheels",
    parameters: &[ParameterSpec {
        name: "relative_error_front",
        unit: "1",
        lower: -0.03,
        upper: 0.03,
        default: 0.005,
        neutral: Some(0.0),
        prior_sigma: f64::INFINITY,
    }],
    hidden: &[],
    twins: &["speed_scale"],
    separated_by: "coasting without brake or traction: the two wheelset speeds differ by a constant ratio",
};

/// See [`WHEEL_RADIUS`].
#[derive(Debug)]
pub struct WheelRadius {
    relative_error_front: f64,
}

impl WheelRadius {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { relative_error_front: values[0] })
    }
}

impl Effect for WheelRadius {
    fn spec(&self) -> &'static EffectSpec {
        &WHEEL_RADIUS
    }

    fn constants(&self, constants: &mut Constants) {
        constants.wheel_radius_m[0] *= 1.0 + self.relative_error_front;
    }
}
