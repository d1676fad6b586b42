//! Effects on wheel geometry.

use super::brake_actuation::WHEELSET;
use super::{Effect, EffectSpec, ParameterSpec, Term, Twin};
use crate::MAX_WHEELSETS;
use crate::wagon::Constants;

/// Radius error of one wheelset.
pub static WHEEL_RADIUS: EffectSpec = EffectSpec {
    id: "wheel_radius",
    term: Term::Kinematics,
    equation: "r_W,i = r_W (1 + e) on one wheelset",
    source: "differences of 0.2 to 1.5 % between wheelsets are usual; calibrated online on a high-speed train in arXiv 1803.02237",
    parameters: &[
        ParameterSpec {
            name: "relative_error",
            lower: -0.06,
            upper: 0.06,
            default: 0.005,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
        WHEELSET,
    ],
    hidden: &[],
    twins: &[Twin::look_alike("speed_scale")],
    separated_by: "coasting without brake or traction: the two wheelset speeds differ by a constant ratio",
};

/// See [`WHEEL_RADIUS`].
#[derive(Debug)]
pub struct WheelRadius {
    relative_error: f64,
    wheelset: usize,
}

impl WheelRadius {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self {
            relative_error: values[0],
            wheelset: (values[1] as usize).clamp(1, MAX_WHEELSETS) - 1,
        })
    }
}

impl Effect for WheelRadius {
    fn spec(&self) -> &'static EffectSpec {
        &WHEEL_RADIUS
    }

    fn constants(&self, constants: &mut Constants) {
        constants.wheel_radius_m[self.wheelset] *= 1.0 + self.relative_error;
    }
}
