//! Effects on wheel geometry.

use super::brake_actuation::WHEELSET;
use super::{Effect, EffectSpec, ParameterSpec, Term, Twin};
use crate::MAX_WHEELSETS;
use crate::wagon::Constants;

/// Which wheelset, counted from the front; 0 means all alike, as after many thousand kilometres without reprofiling.
const WHICH: ParameterSpec = ParameterSpec { lower: 0.0, starts: &[1.0, 2.0, 3.0, 4.0, 0.0], ..WHEELSET };

/// Radius error of one wheelset, or of all.
pub static WHEEL_RADIUS: EffectSpec = EffectSpec {
    id: "wheel_radius",
    term: Term::Kinematics,
    equation: "r_W,i = r_W (1 + e) on one wheelset, or on all of them",
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
        WHICH,
    ],
    hidden: &[],
    twins: &[Twin::look_alike("speed_scale")],
    separated_by: "coasting without brake or traction: wheelset speeds differ by a constant ratio; of all alike only a second \
                   measurement of the vehicle's way tells (satellite, balises)",
};

/// See [`WHEEL_RADIUS`].
#[derive(Debug)]
pub struct WheelRadius {
    relative_error: f64,
    /// `None` for all.
    wheelset: Option<usize>,
}

impl WheelRadius {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        let wheelset = (values[1] as usize).min(MAX_WHEELSETS).checked_sub(1);
        Box::new(Self { relative_error: values[0], wheelset })
    }
}

impl Effect for WheelRadius {
    fn spec(&self) -> &'static EffectSpec {
        &WHEEL_RADIUS
    }

    fn constants(&self, constants: &mut Constants) {
        for (i, radius_m) in constants.wheel_radius_m.iter_mut().enumerate() {
            if self.wheelset.is_none_or(|own| own == i) {
                *radius_m *= 1.0 + self.relative_error;
            }
        }
    }
}
