//! Effects that are written in a file instead of Rust: an expression over named quantities, parameters with bounds and, where
//! the past matters, one hidden state a wheelset.
//!
//! ```toml
//! schema = 1
//!
//! [[effect]]
//! id = "resin_fade"
//! term = "brake_friction"
//! law = "brake_friction"
//! expression = "value * (1 - depth * min(state / 200, 1))"
//!
//! [effect.state]
//! rate = "brake_power_w / 350e3 - state / 120"
//!
//! [effect.parameters.depth]
//! upper = 0.6
//! default = 0.1
//! neutral = 0.0
//! ```
//!
//! `value` is what the law gives without the effect, `state` the hidden state of the wheelset that is asked. What else an
//! expression may name is in [`QUANTITIES`], what it may change in [`LAWS`]. An effect that was read is known to the whole
//! process under its id, like one of the catalogue.

mod error;
mod expression;
mod law;
mod trial;
mod unit;

pub use error::OwnEffectError;
pub use expression::QUANTITIES;
pub use law::{LAWS, Law};

use super::catalogue::{CATALOGUE, Constructor};
use super::{Effect, EffectSpec, Observation, Operating, ParameterSpec, Term, Twin};
use crate::MAX_WHEELSETS;
use expression::{Expression, Scope};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::sync::{Arc, PoisonError, RwLock};

/// A file of own effects.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OwnEffects {
    /// Layout of the file; only 1 is known.
    pub schema: u32,
    /// The effects.
    #[serde(rename = "effect")]
    pub effects: Vec<OwnEffect>,
}

/// One effect of a file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OwnEffect {
    /// Id: lower-case letters, digits and underscores; none of the catalogue's.
    pub id: String,
    /// Name of the [`Term`] that it belongs to.
    pub term: String,
    /// Name of the [`Law`] that it changes.
    pub law: String,
    /// What the law gives with the effect.
    pub expression: String,
    /// The one wheelset that it acts on, counted from 1; absent: all of them.
    #[serde(default)]
    pub wheelset: Option<usize>,
    /// Hidden state of each wheelset.
    #[serde(default)]
    pub state: Option<OwnState>,
    /// Parameters by name.
    #[serde(default)]
    pub parameters: BTreeMap<String, OwnParameter>,
    /// Where the law comes from.
    #[serde(default)]
    pub source: String,
    /// Ids of effects that look alike.
    #[serde(default)]
    pub twins: Vec<String>,
    /// The run that tells it from them, in words.
    #[serde(default)]
    pub separated_by: String,
}

/// A hidden state, one for each wheelset.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OwnState {
    /// Its value at the start of a run.
    #[serde(default)]
    pub start: f64,
    /// Its change per second.
    pub rate: String,
}

/// A parameter of an own effect.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OwnParameter {
    /// Unit, for people: symbols such as `N s/m`, `1/K`, `%`; `1` where there is none.
    #[serde(default = "one")]
    pub unit: String,
    /// Smallest allowed value.
    #[serde(default)]
    pub lower: f64,
    /// Largest allowed value.
    pub upper: f64,
    /// Start of a fit.
    pub default: f64,
    /// Value at which the effect does nothing.
    #[serde(default)]
    pub neutral: Option<f64>,
    /// One sigma of the prior around the default; absent: nothing is known.
    #[serde(default)]
    pub prior_sigma: Option<f64>,
    /// Further values from which a fit starts.
    #[serde(default)]
    pub starts: Vec<f64>,
}

fn one() -> String {
    "1".to_owned()
}

/// An effect that was read.
struct Known {
    written: OwnEffect,
    spec: &'static EffectSpec,
    constructor: Constructor,
}

static KNOWN: RwLock<Vec<Known>> = RwLock::new(Vec::new());

/// The own effects that were read so far.
pub(super) fn known() -> Vec<(&'static EffectSpec, Constructor)> {
    let known = KNOWN.read().unwrap_or_else(PoisonError::into_inner);
    known.iter().map(|known| (known.spec, known.constructor)).collect()
}

/// Makes the effects of a file known under their ids. Reading the same effect twice changes nothing.
///
/// # Errors
/// What is wrong with the first effect that is; none of the file is known then.
pub fn register(file: &OwnEffects) -> Result<(), OwnEffectError> {
    if file.schema != 1 {
        return Err(OwnEffectError::Schema { found: file.schema });
    }
    for effect in &file.effects {
        let there = |id: &String| {
            CATALOGUE.iter().any(|(spec, _)| spec.id == id)
                || known().iter().any(|(spec, _)| spec.id == id)
                || file.effects.iter().any(|other| other.id == *id && *id != effect.id)
        };
        if let Some(id) = effect.twins.iter().find(|id| !there(id)) {
            let problem = format!("no effect is called {id:?}; `railgrip gap effects` lists them");
            return Err(OwnEffectError::Effect { id: effect.id.clone(), what: "twins", problem });
        }
    }
    let laws = file.effects.iter().map(compile).collect::<Result<Vec<_>, _>>()?;
    let mut known = KNOWN.write().unwrap_or_else(PoisonError::into_inner);
    let mut fresh: Vec<(OwnEffect, Compiled)> = Vec::new();
    for (effect, law) in file.effects.iter().zip(laws) {
        let before = known.iter().map(|k| &k.written).chain(fresh.iter().map(|(written, _)| written));
        match before.into_iter().find(|written| written.id == effect.id) {
            Some(written) if written == effect => {}
            Some(_) => return Err(OwnEffectError::Twice { id: effect.id.clone() }),
            None => fresh.push((effect.clone(), law)),
        }
    }
    known.extend(fresh.into_iter().map(|(written, law)| publish(written, law)));
    Ok(())
}

/// An effect with its expressions ready to be evaluated.
#[derive(Clone, Debug)]
struct Compiled {
    law: Law,
    term: Term,
    wheelset: Option<usize>,
    value: Expression,
    state: Option<(f64, Expression)>,
}

fn compile(effect: &OwnEffect) -> Result<Compiled, OwnEffectError> {
    let of =
        |what: &'static str, problem: String| OwnEffectError::Effect { id: effect.id.clone(), what, problem };
    let letters = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    if !effect.id.starts_with(|c: char| c.is_ascii_lowercase()) || !effect.id.chars().all(letters) {
        return Err(of("id", "lower-case letters, digits and underscores make an id".to_owned()));
    }
    if CATALOGUE.iter().any(|(spec, _)| spec.id == effect.id) {
        return Err(of("id", "the catalogue has an effect of this id".to_owned()));
    }
    let terms = || Term::ALL.map(Term::name).join(", ");
    let term = Term::ALL.into_iter().find(|term| term.name() == effect.term);
    let term = term.ok_or_else(|| of("term", format!("no term {:?}; there are {}", effect.term, terms())))?;
    let law = Law::from_name(&effect.law)
        .ok_or_else(|| of("law", format!("no law {:?}; there are {}", effect.law, law::names())))?;
    if let Some(wheelset) = effect.wheelset.filter(|number| !(1..=MAX_WHEELSETS).contains(number)) {
        return Err(of("wheelset", format!("is {wheelset}, allowed is 1 to {MAX_WHEELSETS}")));
    }
    for (name, parameter) in &effect.parameters {
        check_parameter(name, parameter).map_err(|problem| of("parameters", problem))?;
    }
    let names: Vec<&str> = effect.parameters.keys().map(String::as_str).collect();
    let scope = |value: bool| Scope { parameters: &names, state: effect.state.is_some(), value };
    let value =
        Expression::parse(&effect.expression, &scope(true)).map_err(|problem| of("expression", problem))?;
    let state = match &effect.state {
        Some(state) if !state.start.is_finite() => {
            return Err(of("state.start", "is not a number".to_owned()));
        }
        Some(state) => {
            let rate =
                Expression::parse(&state.rate, &scope(false)).map_err(|problem| of("state.rate", problem))?;
            Some((state.start, rate))
        }
        None => None,
    };
    let start = state.as_ref().map_or(0.0, |(start, _)| *start);
    let values: Vec<[f64; 3]> = effect.parameters.values().map(|p| [p.default, p.lower, p.upper]).collect();
    if !trial::gives_a_number(law, &value, &values, start) {
        return Err(of("expression", trial::NEVER.to_owned()));
    }
    if let Some((start, rate)) = &state
        && !trial::gives_a_number(law, rate, &values, *start)
    {
        return Err(of("state.rate", trial::NEVER.to_owned()));
    }
    Ok(Compiled { law, term, wheelset: effect.wheelset.map(|number| number - 1), value, state })
}

fn check_parameter(name: &str, parameter: &OwnParameter) -> Result<(), String> {
    let OwnParameter { lower, upper, default, .. } = *parameter;
    if QUANTITIES.iter().any(|(known, _)| *known == name) || ["value", "state"].contains(&name) {
        return Err(format!("`{name}` is the name of a quantity"));
    }
    unit::check(&parameter.unit).map_err(|problem| format!("`{name}`: unit: {problem}"))?;
    if !(lower.is_finite() && upper.is_finite() && lower < upper) {
        return Err(format!("`{name}`: lower is {lower}, upper {upper}; lower must be below upper"));
    }
    let within = |value: f64| (lower..=upper).contains(&value);
    match std::iter::once(default).chain(parameter.starts.iter().copied()).find(|value| !within(*value)) {
        Some(value) => Err(format!("`{name}`: {value} is not within {lower} to {upper}")),
        None if parameter.prior_sigma.is_some_and(|sigma| !(sigma > 0.0 && sigma.is_finite())) => {
            Err(format!("`{name}`: prior_sigma must be above 0"))
        }
        None => Ok(()),
    }
}

/// What separates an effect from its twins where the file does not say.
const DESIGNED: &str = "the run that `railgrip gap plan` designs";

/// The entry of an effect. It stays for the life of the process, as the catalogue does.
fn publish(written: OwnEffect, law: Compiled) -> Known {
    let kept = |text: &str| -> &'static str { Box::leak(text.to_owned().into_boxed_str()) };
    let parameters: Vec<ParameterSpec> = written
        .parameters
        .iter()
        .map(|(name, p)| ParameterSpec {
            name: kept(name),
            unit: kept(&p.unit),
            lower: p.lower,
            upper: p.upper,
            default: p.default,
            neutral: p.neutral,
            prior_sigma: p.prior_sigma.unwrap_or(f64::INFINITY),
            starts: Vec::leak(p.starts.clone()),
            discrete: false,
            scale: None,
        })
        .collect();
    let twins: Vec<Twin> = written.twins.iter().map(|id| Twin::look_alike(kept(id))).collect();
    let hidden: Vec<&'static str> = match law.state {
        Some(_) => vec!["own state of each wheelset", "slope of its rate, 1/s"],
        None => Vec::new(),
    };
    let spec: &'static EffectSpec = Box::leak(Box::new(EffectSpec {
        id: kept(&written.id),
        term: law.term,
        equation: kept(&format!("{} = {}", law.law.name(), written.expression)),
        source: if written.source.is_empty() { "a file of own effects" } else { kept(&written.source) },
        parameters: Vec::leak(parameters),
        hidden: Vec::leak(hidden),
        twins: Vec::leak(twins),
        separated_by: if written.separated_by.is_empty() { DESIGNED } else { kept(&written.separated_by) },
    }));
    let law = Arc::new(law);
    let constructor: Constructor = Box::leak(Box::new(move |values: &[f64]| -> Box<dyn Effect> {
        Box::new(Own { spec, law: Arc::clone(&law), values: values.to_vec() })
    }));
    Known { written, spec, constructor }
}

/// An own effect at some values of its parameters.
#[derive(Debug)]
struct Own {
    spec: &'static EffectSpec,
    law: Arc<Compiled>,
    values: Vec<f64>,
}

/// Change of a state in one sample, relative, from which the slope of its rate is taken anew.
const MUCH: f64 = 0.01;
/// Change of a state over which its rate is differenced, relative and absolute.
const STATE_CHANGE: f64 = 1e-6;

impl Own {
    /// The law's value with the effect; without it where the law is another one, the wheelset another one, or the expression
    /// gives no number.
    fn changed(&self, law: Law, wheelset: usize, at: &Operating, hidden: &[f64], value: f64) -> f64 {
        if self.law.law != law || self.law.wheelset.is_some_and(|own| own != wheelset) {
            return value;
        }
        let state = hidden.get(wheelset).copied().unwrap_or(0.0);
        let changed = self.law.value.at(at, wheelset, &self.values, state, value);
        if changed.is_finite() { changed } else { value }
    }
}

impl Effect for Own {
    fn spec(&self) -> &'static EffectSpec {
        self.spec
    }

    fn hidden_len(&self, _sample_period_s: f64) -> usize {
        if self.law.state.is_some() { 2 * MAX_WHEELSETS } else { 0 }
    }

    fn start(&self, _at: &Operating, hidden: &mut [f64]) {
        if let Some((start, _)) = &self.law.state {
            let (states, slopes) = hidden.split_at_mut(MAX_WHEELSETS);
            states.fill(*start);
            slopes.fill(f64::NAN);
        }
    }

    /// One step of the exponential Euler method, stable however quick the state is. The slope of the rate over the state is
    /// kept beside the states and taken anew where the state moves much.
    fn advance(&self, at: &Operating, dt_s: f64, hidden: &mut [f64]) {
        let Some((_, rate)) = &self.law.state else { return };
        let (states, slopes) = hidden.split_at_mut(MAX_WHEELSETS);
        let wheelsets = if at.wheelsets == 0 { MAX_WHEELSETS } else { at.wheelsets };
        for (wheelset, (state, slope)) in states.iter_mut().zip(slopes).enumerate().take(wheelsets) {
            let of = |state: f64| rate.at(at, wheelset, &self.values, state, 0.0);
            let now = of(*state);
            let size = 1.0 + state.abs();
            if !slope.is_finite() || (dt_s * now).abs() > MUCH * size || (dt_s * *slope).abs() > MUCH {
                let by = STATE_CHANGE * size;
                *slope = (of(*state + by) - now) / by;
            }
            let stiff = dt_s * *slope;
            let step = if stiff.abs() < 1e-6 { 1.0 } else { stiff.exp_m1() / stiff };
            let next = *state + dt_s * step * now;
            if next.is_finite() {
                *state = next;
            }
        }
    }

    fn pad_force_n(&self, wheelset: usize, at: &Operating, hidden: &[f64], force_n: f64) -> f64 {
        self.changed(Law::PadForce, wheelset, at, hidden, force_n).max(0.0)
    }

    fn brake_friction(&self, wheelset: usize, at: &Operating, hidden: &[f64], friction: f64) -> f64 {
        self.changed(Law::BrakeFriction, wheelset, at, hidden, friction).max(0.0)
    }

    fn brake_torque_nm(&self, wheelset: usize, at: &Operating, hidden: &[f64], torque_nm: f64) -> f64 {
        self.changed(Law::BrakeTorque, wheelset, at, hidden, torque_nm).max(0.0)
    }

    fn drive_torque_nm(&self, wheelset: usize, at: &Operating, hidden: &[f64], torque_nm: f64) -> f64 {
        self.changed(Law::DriveTorque, wheelset, at, hidden, torque_nm)
    }

    fn adhesion_peak(&self, wheelset: usize, at: &Operating, hidden: &[f64], peak: f64) -> f64 {
        self.changed(Law::Adhesion, wheelset, at, hidden, peak).max(0.0)
    }

    fn headwind_m_s(&self, at: &Operating, hidden: &[f64], wind_m_s: f64) -> f64 {
        self.changed(Law::Headwind, 0, at, hidden, wind_m_s)
    }

    fn body_force_n(&self, at: &Operating, hidden: &[f64], force_n: f64) -> f64 {
        self.changed(Law::BodyForce, 0, at, hidden, force_n)
    }

    fn observe(&self, at: &Operating, hidden: &[f64], reading: &mut Observation) {
        reading.v_m_s = self.changed(Law::SpeedReading, 0, at, hidden, reading.v_m_s);
        for (wheelset, speed) in reading.wheel_speed_rad_s.iter_mut().enumerate() {
            *speed = self.changed(Law::WheelSpeedReading, wheelset, at, hidden, *speed);
        }
    }
}
