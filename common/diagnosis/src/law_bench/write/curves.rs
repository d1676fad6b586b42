//! The fitted curves of effects with their bands, and the curve of what is missing.

use super::estimates::{Z95, delta};
use crate::answer::schema::Regime;
use crate::answer::supplement::{Axis, Curve, CurvePoint};
use crate::law_bench::data::case::Kind;
use crate::law_bench::data::point::{Covariate, Point};
use crate::law_bench::fit::fitted::FittedModel;
use crate::law_bench::fit::noise::Noise;
use crate::law_bench::model::candidates::{Form, Place};
use crate::law_bench::model::discrepancy::{ActsOn, Discrepancy, residuals};

/// Points of an effect's curve.
const CURVE_POINTS: usize = 61;

/// Points of the curve of what is missing.
const MISSING_POINTS: usize = 41;

/// The fitted curve of form `index`, with its band and the data behind it.
pub fn effect_curve(
    fitted: &FittedModel,
    calibrated: &FittedModel,
    noise: &Noise,
    points: &[Point],
    index: usize,
) -> Curve {
    let form = &fitted.model.forms()[index];
    if form.spec.place == Place::CreepShape {
        return shape_curve(fitted, calibrated, noise, points, form);
    }
    let spread = form.scale.spread;
    let nuisance = if form.spec.place == Place::Stiffness { 1 } else { 0 };
    let shown = |x: f64| form.spec.covariate.shown(x);
    let law = |values: &[f64], x: f64| {
        values[nuisance] * form.shape().factor(x, fitted.model.values_of(index, values), &form.scale)
    };
    let curve = grid(spread.low, spread.high).map(|x| {
        let (y, error) = delta(fitted, noise, &|values| law(values, x));
        CurvePoint { x: shown(x), y, low: y - Z95 * error, high: y + Z95 * error }
    });
    let level = calibrated.fit.values[nuisance];
    let data = points.iter().filter_map(|point| {
        let x = form.spec.covariate.of(point);
        partial(fitted, point, nuisance).map(|share| [shown(x), law(&fitted.fit.values, x) * (1.0 + share)])
    });
    Curve {
        title: form.spec.id.to_owned(),
        equation: format!("{}; factor {}", form.spec.meaning, form.shape().equation()),
        x: axis(form.spec.covariate, points),
        y: level_axis(nuisance, fitted.model.nuisances()),
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
fn partial(fitted: &FittedModel, point: &Point, nuisance: usize) -> Option<f64> {
    let values = &fitted.fit.values;
    let predicted = fitted.model.predict(point, values);
    let (level, stiffness) = if nuisance == 0 { (1.001, 1.0) } else { (1.0, 1.001) };
    let slope = (fitted.model.predict_scaled(point, values, level, stiffness) - predicted) / 0.001;
    let telling = slope.abs() > 0.35 * predicted.abs() && slope != 0.0;
    telling.then(|| (point.measured - predicted) / slope)
}

/// Utilised adhesion over creepage for a changed creep shape.
fn shape_curve(
    fitted: &FittedModel,
    calibrated: &FittedModel,
    noise: &Noise,
    points: &[Point],
    form: &Form,
) -> Curve {
    let spread = form.scale.spread;
    let typical = typical(points);
    let at = |x: f64| Point { creepage: x, ..typical };
    let low = spread.low.max(1e-3 * spread.high);
    let curve = grid(low, spread.high).map(|x| {
        let (y, error) =
            delta(fitted, noise, &|values| fitted.model.predict(&at(x), values) / typical.load_n);
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

/// The curve of what is missing.
pub fn missing(
    discrepancy: &Discrepancy,
    fitted: &FittedModel,
    points: &[Point],
    noise: &Noise,
    regime: Option<&Regime>,
) -> Curve {
    let what = match discrepancy.acts_on {
        ActsOn::Level if fitted.model.kind() == Kind::Brake => {
            "missing change of pad friction, as a share of it"
        }
        ActsOn::Level => "missing change of adhesion, as a share of it",
        ActsOn::Stiffness => "missing change of contact stiffness, as a share of it",
        ActsOn::Force => "missing force, as a share of the load",
    };
    let points_of_curve = missing_curve(discrepancy, fitted, points, noise)
        .into_iter()
        .map(|[x, y, error]| (discrepancy.covariate.shown(x), y, error))
        .map(|(x, y, error)| CurvePoint { x, y, low: y - Z95 * error, high: y + Z95 * error });
    let points_of_curve: Vec<CurvePoint> = points_of_curve.collect();
    let ends = points_of_curve.first().zip(points_of_curve.last());
    Curve {
        title: format!("what is missing, over {}", discrepancy.covariate.name().replace('_', " ")),
        equation: String::new(),
        x: axis(discrepancy.covariate, points),
        y: Axis { label: what.to_owned(), unit: String::new() },
        reference: ends.map(|(a, b)| vec![[a.x, 0.0], [b.x, 0.0]]).unwrap_or_default(),
        points: points_of_curve,
        data: Vec::new(),
        region: regime
            .filter(|regime| regime.variable == discrepancy.covariate.name())
            .map(|regime| regime.range),
    }
}

/// The curve of what is missing over the variable of `discrepancy`: x, value and standard error. The value is the missing
/// share of the level or the stiffness, or of the normal load.
pub fn missing_curve(
    discrepancy: &Discrepancy,
    fitted: &FittedModel,
    points: &[Point],
    noise: &Noise,
) -> Vec<[f64; 3]> {
    let residuals = residuals(&fitted.model, points, &fitted.fit.values, noise.sigma);
    let scale = noise.unit().sqrt();
    let curve = discrepancy.curve(&residuals, points, MISSING_POINTS).unwrap_or_default();
    curve.into_iter().map(|[x, y, error]| [x, y, error * scale]).collect()
}
