//! The law of a bench with nuisances and any forms of candidates: parameters in, predictions out.

use super::candidates::{Form, LEAST_SHAPE_RATIO, Place};
use super::shape::Shape;
use crate::law_bench::data::case::{Kind, Nominal};
use crate::law_bench::data::point::Point;
use railgrip_vehicle::Contact;
use railgrip_vehicle::adhesion::creep_force;

/// How far a nuisance may stray from its nominal value, as a share of it.
pub const NUISANCE_SHARE: f64 = 0.30;

/// How far it may stray beside an effect, whose anchor need not be the nominal's; [`Model::penalties`] makes it costly.
const NUISANCE_SHARE_SOFT: f64 = 0.60;

/// Width of the soft edge of a nuisance's range, in its logarithm.
const SOFT_EDGE: f64 = 0.05;

/// Prior width of the logarithm of the stiffness beside a free creep shape.
const STIFFNESS_PRIOR: f64 = 0.15;

/// A parameter of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name; the unit is in it.
    pub name: &'static str,
    /// Index of its form, or `None` for a nuisance.
    pub form: Option<usize>,
    /// Smallest value.
    pub lower: f64,
    /// Largest value.
    pub upper: f64,
    /// Whether the optimiser sees the logarithm.
    pub log: bool,
    /// What the case states, for a nuisance.
    pub nominal: Option<f64>,
}

/// The law with its forms.
#[derive(Clone, Debug)]
pub struct Model {
    nominal: Nominal,
    forms: Vec<Form>,
    parameters: Vec<Parameter>,
    /// First parameter of each form.
    offsets: Vec<usize>,
}

impl Model {
    /// A model of the nominal law with `forms`.
    pub fn new(nominal: Nominal, forms: &[Form]) -> Self {
        let share = if forms.is_empty() { NUISANCE_SHARE } else { NUISANCE_SHARE_SOFT };
        let nuisance = |name, value: f64| Parameter {
            name,
            form: None,
            lower: value * (1.0 - share),
            upper: value * (1.0 + share),
            log: true,
            nominal: Some(value),
        };
        let mut parameters = match nominal {
            Nominal::Creep { mu0, stiffness_n, .. } => {
                vec![nuisance("mu0", mu0), nuisance("stiffness_n", stiffness_n)]
            }
            Nominal::Brake { friction_coefficient } => {
                vec![nuisance("friction_coefficient", friction_coefficient)]
            }
        };
        let mut offsets = Vec::with_capacity(forms.len());
        for (index, form) in forms.iter().enumerate() {
            offsets.push(parameters.len());
            parameters.extend(form.ranges(&nominal).into_iter().map(|range| Parameter {
                name: range.name,
                form: Some(index),
                lower: range.lower,
                upper: range.upper,
                log: range.log,
                nominal: None,
            }));
        }
        Self { nominal, forms: forms.to_vec(), parameters, offsets }
    }

    /// Which law.
    pub fn kind(&self) -> Kind {
        match self.nominal {
            Nominal::Creep { .. } => Kind::Creep,
            Nominal::Brake { .. } => Kind::Brake,
        }
    }

    /// The forms.
    pub fn forms(&self) -> &[Form] {
        &self.forms
    }

    /// The parameters: nuisances first, then those of each form.
    pub fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    /// Number of nuisances.
    pub fn nuisances(&self) -> usize {
        self.offsets.first().copied().unwrap_or(self.parameters.len())
    }

    /// Nominal values of the nuisances.
    pub fn nominal_values(&self) -> Vec<f64> {
        self.parameters.iter().filter_map(|parameter| parameter.nominal).collect()
    }

    /// The values of form `index` among all values.
    pub fn values_of<'a>(&self, index: usize, values: &'a [f64]) -> &'a [f64] {
        let start = self.offsets[index];
        &values[start..start + self.forms[index].shape().parameters()]
    }

    /// Index of the first parameter of form `index`.
    pub fn offset(&self, index: usize) -> usize {
        self.offsets[index]
    }

    /// What the model predicts at a point, in the unit of the measured column.
    pub fn predict(&self, point: &Point, values: &[f64]) -> f64 {
        self.predict_scaled(point, values, 1.0, 1.0)
    }

    /// The same with the level and the stiffness scaled on top.
    pub fn predict_scaled(&self, point: &Point, values: &[f64], level: f64, stiffness: f64) -> f64 {
        let (mut level, mut stiffness) = (level, stiffness);
        let mut shape = None;
        for (index, form) in self.forms.iter().enumerate() {
            let own = self.values_of(index, values);
            match form.spec.place {
                Place::Level => level *= form.factor(point, own),
                Place::Stiffness => stiffness *= form.factor(point, own),
                Place::CreepShape => shape = Some((own[0], own[1])),
            }
        }
        match self.nominal {
            Nominal::Brake { .. } => values[0] * level,
            Nominal::Creep { k_a, k_s, .. } => {
                let least = LEAST_SHAPE_RATIO.min(k_s / k_a);
                let (k_a, k_s) = shape.map_or((k_a, k_s), |(a, s)| (a, s.max(least * a)));
                polach(point, values[0] * level, values[1] * stiffness, k_a, k_s)
            }
        }
    }

    /// Square roots of the cost of nuisances beyond their range; zero within it.
    pub fn penalties(&self, values: &[f64], out: &mut Vec<f64>) {
        if self.forms.is_empty() {
            return;
        }
        for (parameter, &value) in self.parameters.iter().zip(values) {
            let Some(nominal) = parameter.nominal else { continue };
            let ratio = value / nominal;
            let above = (ratio / (1.0 + NUISANCE_SHARE)).ln().max(0.0);
            let below = (ratio / (1.0 - NUISANCE_SHARE)).ln().min(0.0);
            out.push((above + below) / SOFT_EDGE);
        }
        // Force depends on K k_A and K k_S alone: without a prior on K the shape would have a direction nobody sees.
        if let Nominal::Creep { stiffness_n, .. } = self.nominal
            && self.forms.iter().any(|form| form.spec.place == Place::CreepShape)
        {
            out.push((values[1] / stiffness_n).ln() / STIFFNESS_PRIOR);
        }
    }

    /// Whether form `index` is a spline.
    pub fn is_spline(&self, index: usize) -> bool {
        self.forms[index].shape() == Shape::Spline
    }
}

/// Polach's law over creepage: the vehicle's own at a reference speed of 1 m/s.
fn polach(point: &Point, mu: f64, stiffness_n: f64, k_a: f64, k_s: f64) -> f64 {
    let contact = Contact { stiffness_n, k_a, k_s, friction_ratio: 1.0, friction_decay_s_per_m: 0.0 };
    creep_force(&contact, 1.0 + point.creepage, 1.0, point.load_n, mu).force_n
}
