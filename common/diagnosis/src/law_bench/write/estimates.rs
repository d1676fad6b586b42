//! Fitted values with their intervals.

use crate::answer::schema::ParameterEstimate;
use crate::answer::supplement::ParameterRow;
use crate::law_bench::fit::fitted::FittedModel;
use crate::law_bench::fit::noise::Noise;
use crate::law_bench::fit::solver::{inner, outer};
use nalgebra::DVector;
use std::collections::BTreeMap;

/// Normal quantile of a two-sided 95 % interval.
pub const Z95: f64 = 1.96;

/// Every parameter of a fitted model, nuisances first.
pub fn rows(fitted: &FittedModel, noise: &Noise) -> Vec<ParameterRow> {
    let model = &fitted.model;
    let mut rows = Vec::new();
    for (index, parameter) in model.parameters().iter().enumerate() {
        if parameter.form.is_some_and(|form| model.is_spline(form)) {
            continue;
        }
        let error = (fitted.fit.covariance[(index, index)] * noise.unit()).max(0.0).sqrt();
        let z = inner(parameter.log, fitted.fit.values[index]);
        let end =
            |sign: f64| outer(parameter.log, z + sign * Z95 * error).clamp(parameter.lower, parameter.upper);
        let form = parameter.form.map(|form| &model.forms()[form]);
        rows.push(ParameterRow {
            owner: form.map_or("nuisance", |form| form.spec.id).to_owned(),
            name: form.map_or_else(|| parameter.name.to_owned(), |form| form.reported_name(parameter.name)),
            nominal: parameter.nominal,
            value: fitted.fit.values[index],
            ci95: [end(-1.0), end(1.0)],
            bounds: [parameter.lower, parameter.upper],
        });
    }
    for index in 0..model.forms().len() {
        if model.is_spline(index) {
            rows.extend(spline_rows(fitted, noise, index));
        }
    }
    rows
}

/// A spline's factor at the low end, the middle and the high end of its variable.
fn spline_rows(fitted: &FittedModel, noise: &Noise, index: usize) -> Vec<ParameterRow> {
    let form = &fitted.model.forms()[index];
    let spread = form.scale.spread;
    let names = form.spec.forms[form.index].1;
    let at = [spread.low, spread.median, spread.high];
    names
        .iter()
        .zip(at)
        .map(|(name, x)| {
            let log_factor = |values: &[f64]| {
                let own = fitted.model.values_of(index, values);
                form.shape().factor(x, own, &form.scale).ln()
            };
            let (z, error) = delta(fitted, noise, &log_factor);
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
    own.map(|row| (row.name.clone(), ParameterEstimate::new(row.value, row.ci95))).collect()
}

/// A function of the parameters and its standard error, by the delta method.
pub fn delta(fitted: &FittedModel, noise: &Noise, function: &dyn Fn(&[f64]) -> f64) -> (f64, f64) {
    let values = &fitted.fit.values;
    let at = function(values);
    let gradient = fitted.model.parameters().iter().enumerate().map(|(index, parameter)| {
        let z = inner(parameter.log, values[index]);
        let h = 1e-5 * (inner(parameter.log, parameter.upper) - inner(parameter.log, parameter.lower));
        let mut moved = values.clone();
        moved[index] = outer(parameter.log, z + h);
        let ahead = function(&moved);
        moved[index] = outer(parameter.log, z - h);
        (ahead - function(&moved)) / (2.0 * h)
    });
    let gradient = DVector::from_iterator(values.len(), gradient);
    let variance = gradient.dot(&(&fitted.fit.covariance * &gradient)) * noise.unit();
    (at, variance.max(0.0).sqrt())
}
