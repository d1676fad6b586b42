//! The fits that the report is about: on the contract's own windows, from where the fits on innovations ended.

use crate::data::case::{Case, Run};
use crate::fit::candidate::Fitted;
use crate::fit::margin;
use crate::fit::objective::Windows;
use crate::fit::solver::{self, Effort, Problem};
use crate::model::parameters::{Built, Shape};
use crate::predict::open_loop::{self, Tally, sigmas};
use railgrip_vehicle::{EffectEntry, VehicleParameters};
use std::ops::Range;

/// Rounds of reweighting the windows that fall on the wrong side between holding and sliding.
const ROUNDS: usize = 3;
const EFFORT: Effort = Effort { iterations: 6, slow_columns: 0, refresh: 1, tolerance: 0.02 };

/// Stays where it starts.
pub(super) const NO_STEP: Effort = Effort { iterations: 0, slow_columns: 0, refresh: 1, tolerance: 0.02 };

/// The three models of a report: shapes, and the parameters fitted on the windows.
#[derive(Clone, Debug)]
pub(crate) struct Models {
    /// The model as the case states it.
    pub(crate) nominal: Shape,
    /// Fitted nuisances of [`Self::nominal`].
    pub(crate) calibrated: Vec<f64>,
    /// The model with the effects that are named, if any.
    pub(crate) extended_shape: Shape,
    /// Fitted nuisances and effects of [`Self::extended_shape`].
    pub(crate) extended: Vec<f64>,
}

impl Models {
    /// Fits nuisances from where `base`, a fit of the nuisances on innovations, ended; the extended model is the calibrated one.
    pub(crate) fn calibrated(case: &Case, base: &Fitted) -> Self {
        let nominal = Shape::nominal(case);
        let calibrated = fit_free(case, &nominal, &[base.fit.theta.clone(), nominal.start()]);
        Self { extended_shape: nominal.clone(), extended: calibrated.clone(), nominal, calibrated }
    }

    /// These models fitted again to other samples of the same runs, from where they stand.
    pub(crate) fn on_samples_of(&self, case: &Case) -> Self {
        let calibrated = fit_free(case, &self.nominal, std::slice::from_ref(&self.calibrated));
        Self { calibrated, ..self.clone() }.extended_by(case, None)
    }

    /// These models with the effects of `named` in the extended one, or with none.
    pub(crate) fn extended_by(&self, case: &Case, named: Option<&Fitted>) -> Self {
        let (nominal, calibrated) = (self.nominal.clone(), self.calibrated.clone());
        let (extended_shape, extended) = match named {
            Some(best) => {
                let shape = best.shape.on_recordings();
                let extended = self.extended_from(case, &shape, &best.fit.theta);
                (shape, extended)
            }
            None => (nominal.clone(), calibrated.clone()),
        };
        Self { nominal, calibrated, extended_shape, extended }
    }

    /// Parameters of the extended model, from where its fit on innovations ended. That may be a valley in which the model, which holds the calibrated
    /// one, does worse than that: then also from the calibrated nuisances.
    fn extended_from(&self, case: &Case, shape: &Shape, innovations: &[f64]) -> Vec<f64> {
        let extended = fit_free(case, shape, &[innovations.to_vec()]);
        let gap = |shape: &Shape, theta: &[f64]| robust_gap(case, shape, theta);
        if case.is_coupled() || gap(shape, &extended) <= gap(&self.nominal, &self.calibrated) {
            return extended;
        }
        let own = innovations.get(shape.nuisance_count()..).unwrap_or_default();
        let from_calibrated: Vec<f64> = self.calibrated.iter().chain(own).copied().collect();
        fit_free(case, shape, &[extended, from_calibrated])
    }

    /// Nominal, calibrated and extended model.
    pub(crate) fn build(&self) -> [Built; 3] {
        [
            self.nominal.build(&self.nominal.start()),
            self.nominal.build(&self.calibrated),
            self.extended_shape.build(&self.extended),
        ]
    }

    /// By how much the gap grows, relative, where one effect is taken out of the extended model and all else stays: the larger of
    /// fitted and predicted runs.
    pub(crate) fn grows_without(&self, case: &Case, effect: usize) -> f64 {
        let (shape, theta) = self.extended_shape.without(&self.extended, effect);
        let models = [self.extended_shape.build(&self.extended), shape.build(&theta)];
        let growth = |runs: &[Run]| growth(case, runs, models.each_ref());
        match case.holdout.is_empty() {
            true => growth(&case.fit),
            false => growth(&case.holdout).max(growth(&case.fit)),
        }
    }

    /// The same of fitted runs alone, with all else fitted again, so that what can stand in for the effect does.
    pub(crate) fn fitted_grows_without(&self, case: &Case, effect: usize) -> f64 {
        let (shape, theta) = self.extended_shape.without(&self.extended, effect);
        let theta = fit(case, &shape, &[theta]);
        growth(case, &case.fit, [&self.extended_shape.build(&self.extended), &shape.build(&theta)])
    }

    /// The vehicle file of the extended model: fitted nuisances, each pad's own level, and the effects found.
    pub(crate) fn vehicle(&self) -> VehicleParameters {
        let shape = &self.extended_shape;
        let (mut vehicle, factors) = shape.vehicle(&self.extended);
        let pads = factors.iter().zip(vehicle.pad_friction()).map(|(f, pad)| f * pad);
        let pads: Vec<f64> = pads.take(vehicle.wheelsets()).collect();
        vehicle.brake.friction_coefficient = pads.iter().sum::<f64>() / pads.len() as f64;
        vehicle.brake.friction_by_wheelset = Some(pads);
        for (e, effect) in shape.effects.iter().enumerate() {
            let values = effect.values(&self.extended[shape.range_of(e)]);
            let parameters =
                effect.spec.parameters.iter().zip(values).map(|(p, v)| (p.name.to_owned(), v)).collect();
            vehicle.effects.push(EffectEntry { id: effect.spec.id.to_owned(), parameters });
        }
        vehicle
    }
}

/// By how much the gap of some runs is larger, relative, by the second of two models.
fn growth(case: &Case, runs: &[Run], models: [&Built; 2]) -> f64 {
    let sigma = sigmas(&case.vehicle.sensors);
    let gap = |built: &Built| {
        let tallies = runs.iter().flat_map(|run| open_loop::tallies(built, run, &sigma));
        Tally::total(&tallies.collect::<Vec<Tally>>()).gap()
    };
    let [with, without] = models.map(gap);
    without / with.max(f64::MIN_POSITIVE) - 1.0
}

/// [`fit`] of a wagon that runs alone, clear of the edge of sliding. Open loop, the couplers of a coupled wagon hide everything else: there the fit on
/// innovations, the first of `starts`, stands.
fn fit_free(case: &Case, shape: &Shape, starts: &[Vec<f64>]) -> Vec<f64> {
    match starts {
        [innovations, ..] if case.is_coupled() => innovations.clone(),
        _ => margin::keep_clear(case, shape, &fit(case, shape, starts)),
    }
}

/// Fits a shape on the windows from each of `starts` and returns the best parameters in the robust sense.
pub fn fit(case: &Case, shape: &Shape, starts: &[Vec<f64>]) -> Vec<f64> {
    let candidates = starts.iter().flat_map(|start| [start.clone(), fit_from(case, shape, start)]);
    candidates
        .map(|theta| (robust_gap(case, shape, &theta), theta))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, theta)| theta)
        .unwrap_or_else(|| shape.start())
}

fn fit_from(case: &Case, shape: &Shape, start: &[f64]) -> Vec<f64> {
    let mut problem = Windows::new(case, shape);
    let mut theta = start.to_vec();
    // Tolerances act nearly in proportion: their columns serve for a few steps.
    let effort = Effort { slow_columns: shape.nuisance_count(), refresh: 2, ..EFFORT };
    for _ in 0..ROUNDS {
        problem.reweight(&theta);
        let before = theta.clone();
        let fit = solver::fit(&problem, shape.parameters(), &theta, effort, None);
        theta = fit.theta;
        let moved = theta.iter().zip(&before).zip(shape.parameters());
        if moved.map(|((a, b), p)| ((a - b) / p.scale).abs()).fold(0.0, f64::max) < 0.02 {
            break;
        }
    }
    debug_assert!(problem.huber().is_infinite());
    theta
}

/// The problem of a shape on the windows, weighted where a short fit from `start` ends, and that end.
pub(super) fn reweighted<'a>(case: &'a Case, shape: &'a Shape, start: &[f64]) -> (Windows<'a>, Vec<f64>) {
    let mut problem = Windows::new(case, shape);
    problem.reweight(start);
    let theta = solver::fit(&problem, shape.parameters(), start, EFFORT, None).theta;
    problem.reweight(&theta);
    (problem, theta)
}

/// Standard errors of some parameters of a shape on the windows, by the curvature at `theta`; a parameter that moves nothing
/// there is known to its scale.
pub(super) fn sigmas_of(case: &Case, shape: &Shape, theta: &[f64], range: Range<usize>) -> Vec<f64> {
    let mut problem = Windows::new(case, shape);
    problem.reweight(theta);
    let mut fit = solver::fit(&problem, shape.parameters(), theta, NO_STEP, None);
    solver::linearise(&problem, shape.parameters(), &mut fit);
    let (_, curvature) = solver::assemble(shape.parameters(), &fit.theta, &fit.blocks);
    let scales: Vec<f64> = shape.parameters().iter().map(|p| p.scale).collect();
    let scaled = curvature
        .map_with_location(|i, j, value| value * scales[i] * scales[j] + if i == j { 1.0 } else { 0.0 });
    let inverse = scaled.try_inverse();
    range
        .map(|i| inverse.as_ref().map_or(1.0, |inverse| inverse[(i, i)].max(0.0).sqrt()) * scales[i])
        .collect()
}

/// Gap on the runs to fit on, see [`robust`].
fn robust_gap(case: &Case, shape: &Shape, theta: &[f64]) -> f64 {
    robust(&tallies(case, shape, theta))
}

/// Gap over windows of which those beyond three times the median count by their square root only: a wheelset that holds on
/// the track and slides in the model decides nothing.
pub(crate) fn robust(windows: &[Tally]) -> f64 {
    let mut gaps: Vec<(f64, usize)> = windows.iter().map(|t| (t.gap(), t.count)).collect();
    gaps.sort_by(|a, b| a.0.total_cmp(&b.0));
    let median = gaps.get(gaps.len() / 2).map_or(1.0, |g| g.0);
    let limit = 3.0 * median.max(2.0);
    // Beyond the limit windows still count, but by their square root.
    let square = |gap: f64| if gap <= limit { gap * gap } else { limit * limit * (gap / limit).sqrt() };
    let samples: usize = gaps.iter().map(|g| g.1).sum();
    (gaps.iter().map(|g| square(g.0) * g.1 as f64).sum::<f64>() / samples.max(1) as f64).sqrt()
}

/// The tally of each window of the runs to fit on.
pub(crate) fn tallies(case: &Case, shape: &Shape, theta: &[f64]) -> Vec<Tally> {
    let sigma = sigmas(&case.vehicle.sensors);
    let built = shape.build(theta);
    case.fit.iter().flat_map(|run| open_loop::tallies(&built, run, &sigma)).collect()
}
