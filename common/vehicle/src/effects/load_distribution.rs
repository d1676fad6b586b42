//! Effects on the normal loads of the wheelsets.

use super::{Effect, EffectSpec, ParameterSpec, Term, Twin};
use crate::wagon::Constants;

/// More or less load transfer than the height of the centre of mass says.
pub static LOAD_TRANSFER: EffectSpec = EffectSpec {
    id: "load_transfer",
    term: Term::LoadDistribution,
    equation: "dF_z = -+ (1 + e) (h / a) m dv/dt",
    source: "h / a of 0.1 to 0.25 is general knowledge; loads shift the slides to trailing wheelsets in 10.1371/journal.pone.0135459",
    parameters: &[ParameterSpec {
        name: "relative_error",
        lower: -1.0,
        upper: 5.0,
        default: 0.2,
        neutral: Some(0.0),
        starts: &[-0.3],
        ..ParameterSpec::PLAIN
    }],
    hidden: &[],
    twins: &[Twin::look_alike("self_cleaning")],
    separated_by: "traction at the adhesion limit, where the transfer changes its sign",
};

/// See [`LOAD_TRANSFER`].
#[derive(Debug)]
pub struct LoadTransfer {
    relative_error: f64,
}

impl LoadTransfer {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { relative_error: values[0] })
    }
}

impl Effect for LoadTransfer {
    fn spec(&self) -> &'static EffectSpec {
        &LOAD_TRANSFER
    }

    fn constants(&self, constants: &mut Constants) {
        constants.com_height_m *= 1.0 + self.relative_error;
    }
}
