//! Effects on mass and moments of inertia.

use super::{Effect, EffectSpec, ParameterSpec, Term, Twin};
use crate::wagon::Constants;

/// Another mass than the file says.
pub static MASS: EffectSpec = EffectSpec {
    id: "mass_error",
    term: Term::Inertia,
    equation: "m (1 + e)",
    source: "payload is rarely weighed: 5 to 10 % either way; general knowledge",
    parameters: &[ParameterSpec {
        name: "relative_error",
        lower: -0.3,
        upper: 0.5,
        default: 0.05,
        neutral: Some(0.0),
        starts: &[-0.05],
        ..ParameterSpec::PLAIN
    }],
    hidden: &[],
    twins: &[Twin::look_alike("rotating_inertia")],
    separated_by: "coasting over a known grade, slides (where load sets the force), and a run at another payload",
};

/// See [`MASS`].
#[derive(Debug)]
pub struct Mass {
    relative_error: f64,
}

impl Mass {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { relative_error: values[0] })
    }
}

impl Effect for Mass {
    fn spec(&self) -> &'static EffectSpec {
        &MASS
    }

    fn constants(&self, constants: &mut Constants) {
        constants.mass_kg *= 1.0 + self.relative_error;
    }
}

/// Another moment of inertia than the file says.
pub static ROTATING: EffectSpec = EffectSpec {
    id: "rotating_inertia",
    term: Term::Inertia,
    equation: "J (1 + e)",
    source: "rotating masses add 4 to 10 % of a trailer's mass and up to 30 % of a motor car's; general knowledge",
    parameters: &[ParameterSpec {
        name: "relative_error",
        lower: -0.5,
        upper: 1.5,
        default: 0.15,
        neutral: Some(0.0),
        starts: &[-0.15],
        ..ParameterSpec::PLAIN
    }],
    hidden: &[],
    twins: &[Twin::look_alike("mass_error")],
    separated_by: "slides, in which the wheelset's own inertia decides how fast it falls out and back",
};

/// See [`ROTATING`].
#[derive(Debug)]
pub struct Rotating {
    relative_error: f64,
}

impl Rotating {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { relative_error: values[0] })
    }
}

impl Effect for Rotating {
    fn spec(&self) -> &'static EffectSpec {
        &ROTATING
    }

    fn constants(&self, constants: &mut Constants) {
        constants.inertia_kg_m2.iter_mut().for_each(|inertia| *inertia *= 1.0 + self.relative_error);
    }
}
