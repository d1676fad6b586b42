//! Fitted values with their intervals, and the curves of effects with their bands.

use super::chance::Noise;
use super::fit::{inner, outer};
use super::forms::Shape;
use super::library::{Form, Place};
use super::points::{Covariate, Point};
use super::search::Trial;
use crate::answer::schema::ParameterEstimate;
use crate::answer::supplement::{Axis, Curve, CurvePoint, ParameterRow};
use nalgebra::DVector;
use std::collections::BTreeMap;

/// Normal quantile of a two-sided 95 % interval.
const Z95: f64 = 1.96;

/// Points of a curve.
const CURVE_POINTS: usize = 61;

/// Every parameter of a fitted model, nuisances first.
pub fn rows(trial: &Trial, noise: &Noise) -> Vec<ParameterRow> {
    let model = &trial.model;
    let mut rows = Vec::new();
    for (index, parameter) in model.parameters().iter().enumerate() {
        if parameter.form.is_some_and(|form| model.is_spline(form)) {
            continue;
        }
        let error = (trial.fit.covariance[(index, index)] * noise.unit()).max(0.0).sqrt();
        let z = inner(parameter.log, trial.fit.values[index]);
        let end =
            |sign: f64| outer(parameter.log, z + sign * Z95 * error).clamp(parameter.lower, parameter.upper);
        let form = parameter.form.map(|form| &model.forms()[form]);
        rows.push(ParameterRow {
            owner: form.map_or("nuisance", |form| form.spec.id).to_owned(),
            name: form.map_or_else(|| parameter.name.to_owned(), |form| form.name_of(parameter.name)),
            nominal: parameter.nominal,
            value: trial.fit.values[index],
            ci95: [end(-1.0), end(1.0)],
            bounds: [parameter.lower, parameter.upper],
        });
    }
    for index in 0..model.forms().len() {
        if model.is_spline(index) {
            rows.extend(spline_rows(trial, noise, index));
        }
    }
    rows
}

/// A spline's factor at the low end, the middle and the high end of its variable.
fn spline_rows(trial: &Trial, noise: &Noise, index: usize) -> Vec<ParameterRow> {
    let form = &trial.model.forms()[index];
    let spread = form.scale.spread;
    let names = form.spec.forms[form.index].1;
    let at = [spread.low, spread.median, spread.high];
    names
        .iter()
        .zip(at)
        .map(|(name, x)| {
            let log_factor = |values: &[f64]| {
                let own = trial.model.values_of(index, values);
                form.shape().factor(x, own, &form.scale).ln()
            };
            let (z, error) = delta(trial, noise, &log_factor);
            ParameterRow {
                owner: form.spec.id.to_owned(),
                name: (*name).to_owned(),
                nominal: None,
                value: z.exp(),
                ci95: [(z - Z95 * error).exp(), (z + Z95 * error).exp()],
                bounds: [0.02, 55.0],
            }
        })
        .collect()
}

/// Parameters of an effect by name.
pub fn by_name(rows: &[ParameterRow], id: &str) -> BTreeMap<String, ParameterEstimate> {
    let own = rows.iter().filter(|row| row.owner == id);
    own.map(|row| (row.name.clone(), ParameterEstimate { value: row.value, ci95: row.ci95 })).collect()
}

/// A function of the parameters and its standard error.
fn delta(trial: &Trial, noise: &Noise, function: &dyn Fn(&[f64]) -> f64) -> (f64, f64) {
    let values = &trial.fit.values;
    let at = function(values);
    let gradient = trial.model.parameters().iter().enumerate().map(|(index, parameter)| {
        let z = inner(parameter.log, values[index]);
        let h = 1e-5 * (inner(parameter.log, parameter.upper) - inner(parameter.log, parameter.lower));
        let mut moved = values.clone();
        moved[index] = outer(parameter.log, z + h);
        let ahead = function(&moved);
        moved[index] = outer(parameter.log, z - h);
        (ahead - function(&moved)) / (2.0 * h)
    });
    let gradient = DVector::from_iterator(values.len(), gradient);
    let variance = gradient.dot(&(&trial.fit.covariance * &gradient)) * noise.unit();
    (at, variance.max(0.0).sqrt())
}

/// The fitted curve of form `index`, with its band and the data behind it.
pub fn effect_curve(
    trial: &Trial,
    calibrated: &Trial,
    noise: &Noise,
    points: &[Point],
    index: usize,
) -> Curve {
    let form = &trial.model.forms()[index];
    if form.spec.place == Place::CreepShape {
        return shape_curve(trial, calibrated, noise, points, form);
    }
    let spread = form.scale.spread;
    let nuisance = if form.spec.place == Place::Stiffness { 1 } else { 0 };
    let shown = |x: f64| form.spec.covariate.shown(x);
    let law = |values: &[f64], x: f64| {
        values[nuisance] * form.shape().factor(x, trial.model.values_of(index, values), &form.scale)
    };
    let curve = grid(spread.low, spread.high).map(|x| {
        let (y, error) = delta(trial, noise, &|values| law(values, x));
        CurvePoint { x: shown(x), y, low: y - Z95 * error, high: y + Z95 * error }
    });
    let level = calibrated.fit.values[nuisance];
    let data = points.iter().filter_map(|point| {
        let x = form.spec.covariate.of(point);
        partial(trial, point, nuisance).map(|share| [shown(x), law(&trial.fit.values, x) * (1.0 + share)])
    });
    Curve {
        title: form.spec.id.to_owned(),
        equation: format!("{}; factor {}", form.spec.meaning, form.shape().equation()),
        x: axis(form.spec.covariate, points),
        y: level_axis(nuisance, trial.model.nuisances()),
        points: curve.collect(),
        reference: vec![[shown(spread.low), level], [shown(spread.high), level]],
        data: binned(data.collect(), 24),
        region: None,
    }
}

fn level_axis(nuisance: usize, nuisances: usize) -> Axis {
    let (label, unit) = match (nuisance, nuisances) {
        (1, _) => ("contact stiffness K", "N"),
        (_, 2) => ("adhesion available", ""),
        _ => ("pad friction", ""),
    };
    Axis { label: label.to_owned(), unit: unit.to_owned() }
}

/// By which share the level at a point differs from the model's, as far as the point can tell.
fn partial(trial: &Trial, point: &Point, nuisance: usize) -> Option<f64> {
    let values = &trial.fit.values;
    let predicted = trial.model.predict(point, values);
    let (level, stiffness) = if nuisance == 0 { (1.001, 1.0) } else { (1.0, 1.001) };
    let slope = (trial.model.predict_scaled(point, values, level, stiffness) - predicted) / 0.001;
    let telling = slope.abs() > 0.35 * predicted.abs() && slope != 0.0;
    telling.then(|| (point.measured - predicted) / slope)
}

/// Utilised adhesion over creepage for a changed creep shape.
fn shape_curve(trial: &Trial, calibrated: &Trial, noise: &Noise, points: &[Point], form: &Form) -> Curve {
    let spread = form.scale.spread;
    let typical = typical(points);
    let at = |x: f64| Point { creepage: x, ..typical };
    let low = spread.low.max(1e-3 * spread.high);
    let curve = grid(low, spread.high).map(|x| {
        let (y, error) = delta(trial, noise, &|values| trial.model.predict(&at(x), values) / typical.load_n);
        CurvePoint { x, y, low: y - Z95 * error, high: y + Z95 * error }
    });
    let reference = grid(low, spread.high)
        .map(|x| [x, calibrated.model.predict(&at(x), &calibrated.fit.values) / typical.load_n]);
    let data = points.iter().map(|p| [p.creepage.abs(), p.measured * p.creepage.signum() / p.load_n]);
    Curve {
        title: form.spec.id.to_owned(),
        equation: form.spec.meaning.to_owned(),
        x: axis(Covariate::Creepage, points),
        y: Axis { label: "adhesion utilised at the median load".to_owned(), unit: String::new() },
        points: curve.collect(),
        reference: reference.collect(),
        data: binned(data.collect(), 30),
        region: None,
    }
}

/// A point with the median of every variable.
fn typical(points: &[Point]) -> Point {
    let median = |of: fn(&Point) -> f64| {
        let mut values: Vec<f64> = points.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values[values.len() / 2]
    };
    Point {
        file: 0,
        sequence: 0.5,
        creepage: median(|p| p.creepage.abs()),
        load_n: median(|p| p.load_n),
        speed_m_s: median(|p| p.speed_m_s),
        temperature_c: median(|p| p.temperature_c),
        pressing_force_n: median(|p| p.pressing_force_n),
        measured: 0.0,
    }
}

fn grid(low: f64, high: f64) -> impl Iterator<Item = f64> {
    (0..CURVE_POINTS).map(move |i| low + (high - low) * i as f64 / (CURVE_POINTS - 1) as f64)
}

/// The axis of a variable.
pub fn axis(covariate: Covariate, points: &[Point]) -> Axis {
    let unit = match covariate {
        Covariate::SlipVelocity if points.iter().any(|p| p.speed_m_s.is_nan()) => "",
        other => other.unit(),
    };
    Axis { label: covariate.name().replace('_', " "), unit: unit.to_owned() }
}

/// Means over about `count` groups of neighbours in x; points at the same x stay together.
pub fn binned(mut points: Vec<[f64; 2]>, count: usize) -> Vec<[f64; 2]> {
    points.retain(|point| point.iter().all(|value| value.is_finite()));
    points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return points };
    let (same, apart) = (1e-3 * (last[0] - first[0]), (last[0] - first[0]) / 6.0);
    let size = points.len().div_ceil(count).max(1);
    let mut bins: Vec<([f64; 2], f64, f64)> = Vec::new();
    for [x, y] in points {
        match bins.last_mut() {
            Some((sum, n, latest)) if x - *latest < apart && (*n < size as f64 || x - *latest <= same) => {
                *sum = [sum[0] + x, sum[1] + y];
                *n += 1.0;
                *latest = x;
            }
            _ => bins.push(([x, y], 1.0, x)),
        }
    }
    bins.into_iter().map(|(sum, n, _)| [sum[0] / n, sum[1] / n]).collect()
}

impl Form {
    /// Name of a parameter in the report: without a speed column a slip velocity is a creepage.
    fn name_of(&self, name: &str) -> String {
        if self.spec.covariate != Covariate::SlipVelocity || self.has_speed {
            return name.to_owned();
        }
        let plain = name.strip_suffix("_s_per_m").or_else(|| name.strip_suffix("_m_s")).unwrap_or(name);
        plain.replace("slip_velocity", "creepage")
    }

    /// The form in words.
    pub fn description(&self) -> String {
        match self.shape() {
            Shape::CreepShape => Shape::CreepShape.equation().to_owned(),
            shape => format!("{} over {}", shape.equation(), self.spec.covariate.name().replace('_', " ")),
        }
    }
}
