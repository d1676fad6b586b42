//! Effects on running resistance, wind and grade.

use super::{Effect, EffectSpec, Operating, ParameterSpec, Term, Twin, window_share};
use crate::GRAVITY_M_S2;
use crate::resistance::rolling_resistance;
use crate::wagon::Constants;
use std::sync::OnceLock;

/// The map of grades is wrong over a stretch.
pub static GRADE: EffectSpec = EffectSpec {
    id: "grade",
    term: Term::Resistance,
    equation: "F = -m g i for x in [x0, x0 + L]",
    source: "maps err by 1 to 5 permil; general knowledge",
    parameters: &[
        ParameterSpec {
            name: "start_m",
            unit: "m",
            lower: -200.0,
            upper: 20000.0,
            default: 150.0,
            starts: &[0.0, 300.0, 600.0],
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "length_m",
            unit: "m",
            lower: 10.0,
            upper: 20000.0,
            default: 150.0,
            starts: &[],
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "error_permil",
            unit: "permil",
            lower: -40.0,
            upper: 40.0,
            default: 2.0,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &[],
    twins: &[Twin::look_alike("running_resistance"), Twin::look_alike("low_adhesion_patch")],
    separated_by: "coasting over the stretch in both directions",
};

/// See [`GRADE`].
#[derive(Debug)]
pub struct Grade {
    start_m: f64,
    length_m: f64,
    error_permil: f64,
    /// Mass of the model, known once it is built.
    mass_kg: OnceLock<f64>,
}

/// Width over which a grade sets in, m.
const EDGE_M: f64 = 12.0;

impl Grade {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self {
            start_m: values[0],
            length_m: values[1],
            error_permil: values[2],
            mass_kg: OnceLock::new(),
        })
    }
}

impl Effect for Grade {
    fn spec(&self) -> &'static EffectSpec {
        &GRADE
    }

    fn constants(&self, constants: &mut Constants) {
        self.mass_kg.get_or_init(|| constants.mass_kg);
    }

    fn body_force_n(&self, at: &Operating, _hidden: &[f64], force_n: f64) -> f64 {
        let inside = window_share(at.position_m, self.start_m, self.length_m, EDGE_M);
        let mass = self.mass_kg.get().copied().unwrap_or(0.0);
        force_n - mass * GRAVITY_M_S2 * 1e-3 * self.error_permil * inside
    }
}

/// Another running resistance than the file says.
pub static RUNNING: EffectSpec = EffectSpec {
    id: "running_resistance",
    term: Term::Resistance,
    equation: "F = -(da + db v)",
    source: "coast-down tests differ from the Davis formula by factors of 0.7 to 1.3",
    parameters: &[
        ParameterSpec {
            name: "constant_n",
            unit: "N",
            lower: -4e3,
            upper: 6e3,
            default: 150.0,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
        ParameterSpec {
            name: "linear_n_s_per_m",
            unit: "N s/m",
            lower: -150.0,
            upper: 300.0,
            default: 10.0,
            neutral: Some(0.0),
            ..ParameterSpec::PLAIN
        },
    ],
    hidden: &[],
    twins: &[Twin::same_model("headwind"), Twin::look_alike("dragging_brake"), Twin::look_alike("grade")],
    separated_by: "coasting in both directions: wind changes its sign with the direction, resistance does not",
};

/// See [`RUNNING`].
#[derive(Debug)]
pub struct Running {
    constant_n: f64,
    linear_n_s_per_m: f64,
}

impl Running {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { constant_n: values[0], linear_n_s_per_m: values[1] })
    }
}

impl Effect for Running {
    fn spec(&self) -> &'static EffectSpec {
        &RUNNING
    }

    fn body_force_n(&self, at: &Operating, _hidden: &[f64], force_n: f64) -> f64 {
        let rolling = rolling_resistance(self.constant_n, at.v_m_s);
        force_n - rolling - self.linear_n_s_per_m * at.v_m_s
    }
}

/// Steady wind along the track.
pub static HEADWIND: EffectSpec = EffectSpec {
    id: "headwind",
    term: Term::Resistance,
    equation: "F = -k_d (v + w)|v + w|",
    source: "wind of 0 to 12 m/s; general knowledge",
    parameters: &[ParameterSpec {
        name: "headwind_m_s",
        unit: "m/s",
        lower: -20.0,
        upper: 25.0,
        default: 3.0,
        neutral: Some(0.0),
        starts: &[-3.0],
        ..ParameterSpec::PLAIN
    }],
    hidden: &[],
    twins: &[Twin::same_model("running_resistance")],
    separated_by: "the same coasting run in both directions",
};

/// See [`HEADWIND`].
#[derive(Debug)]
pub struct Headwind {
    headwind_m_s: f64,
}

impl Headwind {
    /// From the values of the spec's parameters.
    pub fn boxed(values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { headwind_m_s: values[0] })
    }
}

impl Effect for Headwind {
    fn spec(&self) -> &'static EffectSpec {
        &HEADWIND
    }

    fn headwind_m_s(&self, _at: &Operating, _hidden: &[f64], wind_m_s: f64) -> f64 {
        wind_m_s + self.headwind_m_s
    }
}
