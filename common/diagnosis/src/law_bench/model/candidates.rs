//! The candidates of each kind of bench: which variable, at which place of the law, in which forms.

use super::shape::{Range, Scale, Shape};
use crate::law_bench::data::case::{Kind, Nominal};
use crate::law_bench::data::point::{Covariate, Point, Spread};

/// Temperature to which fade is referred, °C.
pub const REFERENCE_TEMPERATURE_C: f64 = 20.0;

/// Speed to which adhesion over speed is referred, m/s; as in the catalogue of wagon effects.
pub const REFERENCE_SPEED_M_S: f64 = 15.0;

/// Smallest ratio k_S / k_A that a creep shape may have. Below 1/8 Polach's law itself has a maximum and would imitate
/// falling friction; published pairs lie between 0.25 and 1.
pub const LEAST_SHAPE_RATIO: f64 = 0.2;

/// Where in the law a candidate acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Factor on adhesion or pad friction.
    Level,
    /// Factor on the contact's stiffness.
    Stiffness,
    /// Replaces k_A and k_S.
    CreepShape,
}

/// Point at which a factor is 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Anchor {
    Zero,
    Median,
    ReferenceTemperature,
    ReferenceSpeed,
}

/// A candidate.
#[derive(Debug, PartialEq)]
pub struct CandidateSpec {
    /// Stable id.
    pub id: &'static str,
    /// Place in the equations.
    pub term: &'static str,
    /// Place in the law.
    pub place: Place,
    /// The variable.
    pub covariate: Covariate,
    /// Forms, the preferred one first, with the names of their parameters.
    pub forms: &'static [(Shape, &'static [&'static str])],
    anchor: Anchor,
    /// What the effect is, for people.
    pub meaning: &'static str,
    /// What to vary, and what to hold, to see this effect alone.
    pub isolate: &'static str,
}

static CREEP: [CandidateSpec; 5] = [
    CandidateSpec {
        id: "falling_friction",
        term: "adhesion",
        place: Place::Level,
        covariate: Covariate::SlipVelocity,
        forms: &[
            (Shape::Exponential, &["friction_ratio", "friction_decay_s_per_m"]),
            (Shape::Rational, &["friction_ratio", "half_slip_velocity_m_s"]),
            (Shape::Gaussian, &["friction_ratio", "slip_velocity_scale_m_s"]),
            (Shape::Linear, &["friction_slope_s_per_m"]),
            (Shape::Spline, &["factor_at_low", "factor_at_middle", "factor_at_high"]),
        ],
        anchor: Anchor::Zero,
        meaning: "adhesion falls with slip velocity",
        isolate: "sweep the creepage far into saturation at two or more speeds, so that slip velocity and creepage part",
    },
    CandidateSpec {
        id: "adhesion_speed",
        term: "adhesion",
        place: Place::Level,
        covariate: Covariate::Speed,
        forms: &[
            (Shape::Hyperbola, &["decay_s_per_m"]),
            (Shape::Rational, &["adhesion_ratio", "half_speed_m_s"]),
            (Shape::Exponential, &["adhesion_ratio", "speed_decay_s_per_m"]),
            (Shape::Linear, &["adhesion_slope_s_per_m"]),
            (Shape::Gaussian, &["adhesion_ratio", "speed_scale_m_s"]),
            (Shape::Spline, &["factor_at_low", "factor_at_middle", "factor_at_high"]),
        ],
        anchor: Anchor::ReferenceSpeed,
        meaning: "adhesion changes with vehicle speed",
        isolate: "repeat the same creepage sweep at three or more speeds, holding the slip velocity of the last point",
    },
    CandidateSpec {
        id: "adhesion_load",
        term: "adhesion",
        place: Place::Level,
        covariate: Covariate::Load,
        forms: &[
            (Shape::Power, &["load_exponent"]),
            (Shape::Linear, &["adhesion_slope_per_n"]),
            (Shape::Spline, &["factor_at_low", "factor_at_middle", "factor_at_high"]),
        ],
        anchor: Anchor::Median,
        meaning: "adhesion changes with normal load",
        isolate: "repeat saturated points at three or more loads with all else held",
    },
    CandidateSpec {
        id: "creep_stiffness_load",
        term: "adhesion",
        place: Place::Stiffness,
        covariate: Covariate::Load,
        forms: &[(Shape::Power, &["stiffness_exponent"])],
        anchor: Anchor::Median,
        meaning: "contact stiffness changes with normal load (2/3 after Hertz)",
        isolate: "measure the initial slope at creepages well below saturation, at three or more loads",
    },
    CandidateSpec {
        id: "creep_shape",
        term: "adhesion",
        place: Place::CreepShape,
        covariate: Covariate::Creepage,
        forms: &[(Shape::CreepShape, &["k_a", "k_s"])],
        anchor: Anchor::Zero,
        meaning: "the curve saturates in another shape than k_A and k_S say (contamination, roughness)",
        isolate: "measure densely around the knee of the curve at one low speed, where the slip velocity stays small",
    },
];

static BRAKE: [CandidateSpec; 3] = [
    CandidateSpec {
        id: "brake_friction_speed",
        term: "brake_friction",
        place: Place::Level,
        covariate: Covariate::Speed,
        forms: &[
            (Shape::Rise, &["rise", "decay_speed_m_s"]),
            (Shape::Rational, &["friction_ratio", "half_speed_m_s"]),
            (Shape::Linear, &["friction_slope_s_per_m"]),
            (Shape::Gaussian, &["friction_ratio", "speed_scale_m_s"]),
            (Shape::Spline, &["factor_at_low", "factor_at_middle", "factor_at_high"]),
        ],
        anchor: Anchor::Zero,
        meaning: "pad friction changes with speed",
        isolate: "drag the brake at constant speeds from 5 m/s to the highest, each from the same disc temperature and force",
    },
    CandidateSpec {
        id: "brake_fade",
        term: "brake_friction",
        place: Place::Level,
        covariate: Covariate::Temperature,
        forms: &[
            (Shape::Linear, &["alpha_per_k"]),
            (Shape::Ramp, &["alpha_per_k", "onset_c", "softness_k"]),
            (Shape::Step, &["depth", "centre_c", "softness_k"]),
            (Shape::Quadratic, &["alpha_per_k", "beta_per_k2"]),
            (Shape::Spline, &["factor_at_low", "factor_at_middle", "factor_at_high"]),
        ],
        anchor: Anchor::ReferenceTemperature,
        meaning: "pad friction changes with disc temperature",
        isolate: "repeat the same application at the same speed and force from a cold and from a hot disc",
    },
    CandidateSpec {
        id: "brake_friction_pressure",
        term: "brake_friction",
        place: Place::Level,
        covariate: Covariate::PressingForce,
        forms: &[
            (Shape::Power, &["exponent"]),
            (Shape::Linear, &["friction_slope_per_n"]),
            (Shape::Spline, &["factor_at_low", "factor_at_middle", "factor_at_high"]),
        ],
        anchor: Anchor::Median,
        meaning: "pad friction changes with pressing force",
        isolate: "apply three or more force levels at the same speed and disc temperature",
    },
];

/// Candidates of a kind of bench, tried or not.
pub fn candidates(kind: Kind) -> &'static [CandidateSpec] {
    match kind {
        Kind::Creep => &CREEP,
        Kind::Brake => &BRAKE,
    }
}

/// A form of a candidate, scaled to the data of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Form {
    /// Its candidate.
    pub spec: &'static CandidateSpec,
    /// Index among the candidate's forms.
    pub index: usize,
    /// Anchor and spread of the variable.
    pub scale: Scale,
    /// Whether the bench has a speed column.
    pub has_speed: bool,
}

impl CandidateSpec {
    /// The candidate's forms on these points; none where the bench does not have or does not vary the variable.
    pub fn forms_on(&'static self, points: &[Point]) -> Vec<Form> {
        let Some(spread) = Spread::of(points, self.covariate) else { return Vec::new() };
        let anchor = match self.anchor {
            Anchor::Zero => 0.0,
            Anchor::Median => spread.median,
            Anchor::ReferenceTemperature => REFERENCE_TEMPERATURE_C,
            Anchor::ReferenceSpeed => REFERENCE_SPEED_M_S,
        };
        let has_speed = points.iter().all(|point| !point.speed_m_s.is_nan());
        let scale = Scale { anchor, spread };
        (0..self.forms.len()).map(|index| Form { spec: self, index, scale, has_speed }).collect()
    }
}

impl Form {
    /// The shape.
    pub fn shape(&self) -> Shape {
        self.spec.forms[self.index].0
    }

    /// Parameters with their ranges.
    pub fn ranges(&self, nominal: &Nominal) -> Vec<Range> {
        let spread = &self.scale.spread;
        let (width, reach) = (spread.width(), spread.high.abs().max(spread.width()));
        let least_ratio = if self.spec.id == "falling_friction" { (0.02, 1.0) } else { (0.02, 4.0) };
        let limits: Vec<(f64, f64, bool)> = match self.shape() {
            Shape::Exponential => {
                vec![(least_ratio.0, least_ratio.1, false), (0.05 / reach, 60.0 / reach, true)]
            }
            Shape::Rise => vec![(-0.6, 4.0, false), (0.01 * reach, 20.0 * reach, true)],
            Shape::Hyperbola => vec![(-0.6 / reach, 30.0 / reach, false)],
            Shape::Rational | Shape::Gaussian => {
                vec![(least_ratio.0, least_ratio.1, false), (0.01 * reach, 20.0 * reach, true)]
            }
            Shape::Linear => vec![(-2.0 / width, 0.98 / width, false)],
            Shape::Quadratic => {
                vec![(-3.0 / width, 3.0 / width, false), (-3.0 / width.powi(2), 3.0 / width.powi(2), false)]
            }
            Shape::Step => {
                vec![(-1.0, 0.98, false), (spread.low, spread.high, false), (0.01 * width, width, true)]
            }
            Shape::Ramp => vec![
                (-3.0 / width, 3.0 / width, false),
                (spread.low, spread.high, false),
                (0.005 * width, 0.3 * width, true),
            ],
            Shape::Power => vec![(-1.5, 1.5, false)],
            Shape::Spline => vec![(-5.0, 5.0, false); 3],
            Shape::CreepShape => {
                let ratio = match nominal {
                    Nominal::Creep { k_a, k_s, .. } => LEAST_SHAPE_RATIO.min(k_s / k_a),
                    Nominal::Brake { .. } => LEAST_SHAPE_RATIO,
                };
                vec![(0.02, 5.0, true), (0.02 * ratio, 5.0, true)]
            }
        };
        let names = self.spec.forms[self.index].1;
        let named = names.iter().zip(limits);
        named.map(|(&name, (lower, upper, log))| Range { name, lower, upper, log }).collect()
    }

    /// The form in words.
    pub fn description(&self) -> String {
        match self.shape() {
            Shape::CreepShape => Shape::CreepShape.equation().to_owned(),
            shape => format!("{} over {}", shape.equation(), self.spec.covariate.name().replace('_', " ")),
        }
    }

    /// Name of a parameter in the report: without a speed column a slip velocity is a creepage.
    pub fn reported_name(&self, name: &str) -> String {
        if self.spec.covariate != Covariate::SlipVelocity || self.has_speed {
            return name.to_owned();
        }
        let plain = name.strip_suffix("_s_per_m").or_else(|| name.strip_suffix("_m_s")).unwrap_or(name);
        plain.replace("slip_velocity", "creepage")
    }

    /// The factor at a point.
    pub fn factor(&self, point: &Point, values: &[f64]) -> f64 {
        self.shape().factor(self.spec.covariate.of(point), values, &self.scale)
    }
}
