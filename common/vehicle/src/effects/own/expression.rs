//! Expressions over the quantities of an operating point.

use crate::effects::Operating;
use exmex::prelude::*;
use exmex::{FloatOpsFactory, MatchLiteral, literal_matcher_from_pattern};

// Numbers as elsewhere in files: 0.5, .5, 350e3, 1e-3.
literal_matcher_from_pattern!(Number, r"^([0-9]+(\.[0-9]*)?|\.[0-9]+)([eE][+-]?[0-9]+)?");

type Flat = FlatEx<f64, FloatOpsFactory<f64>, Number>;

/// Reads a quantity of a wheelset.
type Read = fn(&Operating, usize) -> f64;

/// What an expression may name beside `value`, `state` and its parameters. Names end in their unit; what a wheelset has is
/// that of the wheelset which is asked, or of the first where the law is the wagon's.
pub const QUANTITIES: [(&str, Read); 16] = [
    ("time_s", |at, _| at.time_s),
    ("v_m_s", |at, _| at.v_m_s),
    ("acceleration_m_s2", |at, _| at.acceleration_m_s2),
    ("position_m", |at, _| at.position_m),
    ("wheelset_position_m", |at, i| at.position_m + at.wheelset_position_m[i]),
    ("sanding", |at, _| at.sanding),
    ("grade_rad", |at, _| at.grade_rad),
    ("adhesion_peak", |at, i| at.adhesion_peak[i]),
    ("wheel_speed_rad_s", |at, i| at.wheel_speed_rad_s[i]),
    ("wheel_acceleration_rad_s2", |at, i| at.wheel_acceleration_rad_s2[i]),
    ("wheel_angle_rad", |at, i| at.wheel_angle_rad[i]),
    ("pressing_force_n", |at, i| at.pressing_force_n[i]),
    ("drive_torque_nm", |at, i| at.drive_torque_nm[i]),
    ("brake_power_w", |at, i| at.brake_power_w[i]),
    ("slip_power_w", |at, i| at.slip_power_w[i]),
    ("wheelset", |_, i| (i + 1) as f64),
];

/// What an expression may name beside the quantities.
pub(super) struct Scope<'a> {
    /// Its parameters, in the order of their values.
    pub(super) parameters: &'a [&'a str],
    /// Whether there is a hidden state.
    pub(super) state: bool,
    /// Whether there is a value of the law.
    pub(super) value: bool,
}

/// Where a variable's value comes from.
#[derive(Clone, Copy, Debug)]
enum Source {
    Quantity(Read),
    Parameter(usize),
    State,
    Value,
}

/// An expression that was read once and is evaluated often.
#[derive(Clone, Debug)]
pub(super) struct Expression {
    flat: Flat,
    /// In the order in which `flat` takes them.
    sources: Vec<Source>,
}

/// Most characters of one expression.
const MOST_CHARACTERS: usize = 4096;
/// Most variables of one expression.
const MOST_VARIABLES: usize = 24;

impl Expression {
    /// Reads an expression.
    ///
    /// # Errors
    /// What is wrong with it; of a name that does not exist, which ones do.
    pub(super) fn parse(text: &str, scope: &Scope<'_>) -> Result<Self, String> {
        if text.len() > MOST_CHARACTERS {
            return Err(format!("{} characters, at most {MOST_CHARACTERS}", text.len()));
        }
        let flat = Flat::parse(text).map_err(|error| format!("{text:?} cannot be read: {error}"))?;
        let sources = flat
            .var_names()
            .iter()
            .map(|name| source(name, scope).ok_or_else(|| unknown(name, scope)))
            .collect::<Result<Vec<_>, _>>()?;
        if sources.len() > MOST_VARIABLES {
            return Err(format!("{} names in one expression, at most {MOST_VARIABLES}", sources.len()));
        }
        Ok(Self { flat, sources })
    }

    /// Its value for a wheelset at an operating point; not a number where it has none.
    pub(super) fn at(
        &self,
        at: &Operating,
        wheelset: usize,
        parameters: &[f64],
        state: f64,
        value: f64,
    ) -> f64 {
        let mut variables = [0.0; MOST_VARIABLES];
        for (variable, source) in variables.iter_mut().zip(&self.sources) {
            *variable = match *source {
                Source::Quantity(read) => read(at, wheelset),
                Source::Parameter(index) => parameters.get(index).copied().unwrap_or(f64::NAN),
                Source::State => state,
                Source::Value => value,
            };
        }
        self.flat.eval(&variables[..self.sources.len()]).unwrap_or(f64::NAN)
    }
}

fn source(name: &str, scope: &Scope<'_>) -> Option<Source> {
    let parameter = scope.parameters.iter().position(|known| *known == name).map(Source::Parameter);
    let quantity =
        || QUANTITIES.iter().find(|(known, _)| *known == name).map(|(_, read)| Source::Quantity(*read));
    match name {
        "state" if scope.state => Some(Source::State),
        "value" if scope.value => Some(Source::Value),
        _ => parameter.or_else(quantity),
    }
}

/// What to say of a name that does not exist.
fn unknown(name: &str, scope: &Scope<'_>) -> String {
    let own = [("value", scope.value), ("state", scope.state)].into_iter().filter(|(_, there)| *there);
    let names: Vec<&str> = own
        .map(|(name, _)| name)
        .chain(scope.parameters.iter().copied())
        .chain(QUANTITIES.iter().map(|(name, _)| *name))
        .collect();
    // A quantity in another unit begins alike.
    let stem = name.split('_').next().unwrap_or(name);
    let alike: Vec<&str> =
        names.iter().copied().filter(|known| known.split('_').next() == Some(stem)).collect();
    let hint = if alike.is_empty() { String::new() } else { format!(" (perhaps {}?)", alike.join(" or ")) };
    format!("nothing is called `{name}`{hint}; there are {}", names.join(", "))
}
