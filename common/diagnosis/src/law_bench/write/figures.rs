//! What the HTML report shows of a law-level case.

use super::curves::{axis, binned};
use crate::answer::supplement::{Axis, CandidateDetail, HeatGroup, HeatMap, RunRow, Scatter};
use crate::law_bench::data::case::Kind;
use crate::law_bench::data::point::{Covariate, Point};
use crate::law_bench::decide::selection::Selection;
use crate::law_bench::predict::gaps::{Predictions, edges, within};

/// Points of a model's line in a scatter.
const LINE_POINTS: usize = 24;

/// Levels that a line may connect across any distance.
const FEW_LEVELS: usize = 12;

/// Most points that a scatter shows.
const MOST_POINTS: usize = 400;

/// Gap of the fit points by region of every variable.
pub fn heat_map(kind: Kind, predictions: &Predictions<'_>) -> HeatMap {
    let points = &predictions.set.points;
    let groups = kind.variables().iter().filter(|&&c| own_axis(points, c)).filter_map(|&covariate| {
        let edges = edges(points, covariate)?;
        let regions: Vec<(f64, f64, bool)> =
            edges.windows(2).enumerate().map(|(i, w)| (w[0], w[1], i + 2 == edges.len())).collect();
        let gaps = regions.iter().map(|&(low, high, closed)| {
            let inside = |point: &Point| within(covariate.of(point), low, high, closed);
            (predictions.gaps(inside), points.iter().filter(|point| inside(point)).count())
        });
        let (gaps, samples): (Vec<[f64; 3]>, Vec<usize>) = gaps.unzip();
        Some(HeatGroup {
            variable: covariate.name().to_owned(),
            unit: covariate.si_unit().to_owned(),
            edges,
            samples,
            calibrated: vec![gaps.iter().map(|gap| gap[1]).collect()],
            extended: vec![gaps.iter().map(|gap| gap[2]).collect()],
        })
    });
    HeatMap { signals: vec![kind.signal().to_owned()], groups: groups.collect() }
}

/// Whether a variable says something that another does not: without a speed column, slip velocity is creepage.
fn own_axis(points: &[Point], covariate: Covariate) -> bool {
    covariate != Covariate::SlipVelocity || points.iter().all(|point| !point.speed_m_s.is_nan())
}

/// Measured points and models over `main`, and what the calibrated model misses over every variable that the set varies.
pub fn scatters(
    kind: Kind,
    predictions: &Predictions<'_>,
    main: Option<Covariate>,
    title: &str,
) -> Vec<Scatter> {
    let points = &predictions.set.points;
    let varied: Vec<Covariate> = kind
        .variables()
        .iter()
        .copied()
        .filter(|&covariate| own_axis(points, covariate) && edges(points, covariate).is_some())
        .collect();
    let main = match kind {
        Kind::Creep => Some(Covariate::Creepage),
        Kind::Brake => main.or(varied.first().copied()),
    };
    let whole = main.filter(|main| varied.contains(main)).map(|main| plain(kind, predictions, main, title));
    whole
        .into_iter()
        .chain(varied.iter().map(|&covariate| missed(kind, predictions, covariate, title)))
        .collect()
}

/// Measured points and the three models.
fn plain(kind: Kind, predictions: &Predictions<'_>, covariate: Covariate, title: &str) -> Scatter {
    let label = match kind {
        Kind::Creep => "force over load",
        Kind::Brake => "pad friction",
    };
    let line = |predicted: &[f64]| panel_line(kind, predictions, covariate, predicted);
    let measured: Vec<f64> = predictions.set.points.iter().map(|point| point.measured).collect();
    let x = axis(covariate, &predictions.set.points);
    Scatter {
        title: format!("{title}: {label} over {}", x.label),
        y: Axis { label: label.to_owned(), unit: String::new() },
        measured: dots(kind, predictions, covariate, &measured),
        nominal: line(&predictions.nominal),
        calibrated: line(&predictions.calibrated),
        extended: line(&predictions.extended),
        x,
    }
}

/// What the calibrated model misses: measured and extended minus calibrated.
fn missed(kind: Kind, predictions: &Predictions<'_>, covariate: Covariate, title: &str) -> Scatter {
    let label = match kind {
        Kind::Creep => "force over load, minus calibrated",
        Kind::Brake => "pad friction, minus calibrated",
    };
    let minus = |values: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
        values.zip(&predictions.calibrated).map(|(value, calibrated)| value - calibrated).collect()
    };
    let measured = minus(&mut predictions.set.points.iter().map(|point| point.measured));
    let extended = minus(&mut predictions.extended.iter().copied());
    let x = axis(covariate, &predictions.set.points);
    let zero = vec![0.0; measured.len()];
    Scatter {
        title: format!("{title}: what the calibrated model misses, over {}", x.label),
        y: Axis { label: label.to_owned(), unit: String::new() },
        measured: dots(kind, predictions, covariate, &measured),
        nominal: Vec::new(),
        calibrated: panel_line(kind, predictions, covariate, &zero),
        extended: panel_line(kind, predictions, covariate, &extended),
        x,
    }
}

/// A value as panels show it: a creep force as a share of its load, signed like the creepage.
fn shown(kind: Kind, point: &Point, value: f64) -> f64 {
    match kind {
        Kind::Creep => value * point.creepage.signum() / point.load_n,
        Kind::Brake => value,
    }
}

fn panel_line(
    kind: Kind,
    predictions: &Predictions<'_>,
    covariate: Covariate,
    values: &[f64],
) -> Vec<[f64; 2]> {
    let pairs = predictions.set.points.iter().zip(values);
    let pairs = pairs.map(|(point, &y)| [covariate.shown(covariate.of(point)), shown(kind, point, y)]);
    broken(binned(pairs.collect(), LINE_POINTS))
}

fn dots(kind: Kind, predictions: &Predictions<'_>, covariate: Covariate, values: &[f64]) -> Vec<[f64; 2]> {
    let step = values.len().div_ceil(MOST_POINTS).max(1);
    let pairs = predictions.set.points.iter().zip(values).step_by(step);
    pairs.map(|(point, &y)| [covariate.shown(covariate.of(point)), shown(kind, point, y)]).collect()
}

/// Breaks a line where there is no data for more than a third of its range, unless it stands on a few levels anyway.
fn broken(line: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    let (Some(first), Some(last)) = (line.first(), line.last()) else { return line };
    if line.len() <= FEW_LEVELS {
        return line;
    }
    let widest = (last[0] - first[0]) / 3.0;
    let mut pieces: Vec<[f64; 2]> = Vec::with_capacity(line.len());
    for point in line {
        if pieces.last().is_some_and(|before| point[0] - before[0] > widest) {
            pieces.push([f64::NAN, f64::NAN]);
        }
        pieces.push(point);
    }
    pieces
}

/// Rows of the table of runs.
pub fn runs(predictions: &Predictions<'_>, holdout: bool) -> Vec<RunRow> {
    let files = predictions.set.files.iter().enumerate();
    files
        .map(|(file, name)| {
            let [nominal, calibrated, extended] = predictions.gaps(|point| point.file == file);
            let samples = predictions.set.points.iter().filter(|point| point.file == file).count();
            RunRow { name: name.clone(), holdout, samples, duration_s: None, nominal, calibrated, extended }
        })
        .collect()
}

/// More about every candidate.
pub fn candidates(selection: &Selection) -> Vec<CandidateDetail> {
    selection
        .alone
        .iter()
        .map(|scored| CandidateDetail {
            id: scored.spec.id.to_owned(),
            cv_gain_interval: Some([scored.cv_gain - scored.cv_spread, scored.cv_gain + scored.cv_spread]),
            form: scored.fitted.model.forms().last().map(|form| form.description()).unwrap_or_default(),
            on_bound: scored.on_bound.iter().map(|name| (*name).to_owned()).collect(),
        })
        .collect()
}
