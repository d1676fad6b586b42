//! The two objectives: whitened innovations, which select, and the contract's windows, which the report is about.

use crate::data::case::{Case, OUTPUTS, Run};
use crate::fit::solver::{self, Problem};
use crate::model::parameters::{Built, Parameter, Shape};
use crate::predict::disturbances::{DisturbanceModel, OUTLIER_SIGMA};
use crate::predict::one_step::Predictor;
use crate::predict::open_loop::{self, sigmas};
use crate::predict::response::Path;

/// Frozen predictors of all runs to fit on.
#[derive(Debug)]
pub struct Whitening<'a> {
    runs: &'a [Run],
    predictors: Vec<Predictor>,
    ends: Vec<usize>,
    tolerant: bool,
    /// What outputs that were not measured count for.
    missing: f64,
}

impl<'a> Whitening<'a> {
    /// Freezes the filter at `built`.
    pub fn new(case: &'a Case, built: &Built, disturbances: &DisturbanceModel) -> Self {
        let freeze = |run| Predictor::new(built, run, case, disturbances);
        let predictors = case.fit.iter().map(freeze).collect();
        let mut end = 0;
        let ends = case.fit.iter().map(|run| {
            end += run.room() * run.len();
            end
        });
        let tolerant = disturbances.tolerance.is_large();
        let samples =
            case.fit.iter().flat_map(|run| run.samples.iter().map(|sample| (run.outputs(), sample)));
        let missing = samples.flat_map(|(outputs, sample)| (0..outputs).filter(|j| !sample.measured[*j]));
        let missing = missing.map(|j| 0.5 + case.noise[j].white.ln()).sum();
        Self { runs: &case.fit, predictors, ends: ends.collect(), tolerant, missing }
    }

    /// Whether the filter corrects so much at each sample that it hardly looks beyond one step: small changes of the model
    /// are then followed along its path (see [`response`](crate::predict::response)), which a late sensor cannot unsettle.
    pub(crate) fn is_tolerant(&self) -> bool {
        self.tolerant
    }

    /// End of each run among the residuals.
    pub(super) fn ends(&self) -> &[usize] {
        &self.ends
    }

    /// The paths of the filters with `built`.
    pub(crate) fn paths(&self, built: &Built) -> Vec<Path<'_>> {
        self.runs
            .iter()
            .zip(&self.predictors)
            .map(|(run, predictor)| Path::new(built, run, predictor))
            .collect()
    }

    /// Whitened innovations of `built` on the runs of `case`, which differ from those of the filter in what was measured when.
    pub(super) fn residuals_of(&self, case: &Case, built: &Built) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.ends.last().copied().unwrap_or(0));
        for (run, predictor) in case.fit.iter().zip(&self.predictors) {
            predictor.residuals(built, run, &mut out);
        }
        out
    }

    /// Residuals in a stretch of so many seconds of all outputs.
    pub fn stretch(&self, seconds: f64) -> usize {
        let of = |run: &Run| run.room() * ((seconds / run.dt_s).round() as usize).max(1);
        self.runs.first().map_or(1, of)
    }

    /// Half the log-determinants of all innovation covariances. An output that was not measured counts as one that was
    /// predicted to its sensor's noise, so that recordings which lack some of them stay comparable.
    pub fn half_log_determinant(&self) -> f64 {
        self.missing + self.predictors.iter().map(|p| p.half_log_determinant).sum::<f64>()
    }
}

/// Innovations of a shape of model.
#[derive(Debug)]
pub struct Innovations<'a> {
    /// The frozen predictors.
    pub whitening: &'a Whitening<'a>,
    /// The shape.
    pub shape: &'a Shape,
}

/// Something that makes a problem of a shape of model.
pub trait Objective: Sync {
    /// The problem of fitting `shape`.
    fn of<'s>(&'s self, shape: &'s Shape) -> Box<dyn Problem + Sync + 's>;
}

impl Objective for Whitening<'_> {
    fn of<'s>(&'s self, shape: &'s Shape) -> Box<dyn Problem + Sync + 's> {
        Box::new(Innovations { whitening: self, shape })
    }
}

impl Problem for Innovations<'_> {
    fn columns(
        &self,
        parameters: &[Parameter],
        theta: &[f64],
        base: &[f64],
        range: std::ops::Range<usize>,
    ) -> Vec<Vec<f64>> {
        if !self.whitening.is_tolerant() {
            let all = |theta: &[f64]| self.residuals(theta);
            let of = |theta: &[f64], block: usize| self.block_residuals(theta, block);
            return solver::differences(parameters, theta, (base, self.block_ends()), range, all, of);
        }
        if range.is_empty() {
            return Vec::new();
        }
        let paths = self.whitening.paths(&self.shape.build(theta));
        let along = |theta: &[f64]| {
            let built = self.shape.build(theta);
            let mut out = Vec::with_capacity(base.len());
            paths.iter().for_each(|path| path.residuals(&built, &mut out));
            out
        };
        let of = |theta: &[f64], block: usize| {
            let mut out = Vec::new();
            paths[block].residuals(&self.shape.build(theta), &mut out);
            out
        };
        solver::differences(parameters, theta, (base, self.block_ends()), range, along, of)
    }

    fn residuals(&self, theta: &[f64]) -> Vec<f64> {
        let built = self.shape.build(theta);
        let mut out = Vec::with_capacity(self.whitening.ends.last().copied().unwrap_or(0));
        for (run, predictor) in self.whitening.runs.iter().zip(&self.whitening.predictors) {
            predictor.residuals(&built, run, &mut out);
        }
        out
    }

    fn block_residuals(&self, theta: &[f64], block: usize) -> Vec<f64> {
        let mut out = Vec::new();
        self.whitening.predictors[block].residuals(
            &self.shape.build(theta),
            &self.whitening.runs[block],
            &mut out,
        );
        out
    }

    fn block_ends(&self) -> &[usize] {
        &self.whitening.ends
    }

    fn huber(&self) -> f64 {
        OUTLIER_SIGMA
    }
}

/// Open-loop errors of a shape of model, as the contract's metric sees them, with each window weighted once.
#[derive(Debug)]
pub struct Windows<'a> {
    runs: &'a [Run],
    shape: &'a Shape,
    ends: Vec<usize>,
    sigma: [f64; OUTPUTS],
    /// Weight of each window.
    weights: Vec<Vec<f64>>,
}

impl<'a> Windows<'a> {
    /// Windows of the runs to fit on, all with weight one.
    pub fn new(case: &'a Case, shape: &'a Shape) -> Self {
        let mut end = 0;
        let mut ends = Vec::new();
        let mut weights = Vec::new();
        for run in &case.fit {
            let windows = open_loop::windows(run);
            end += windows.iter().map(|w| run.outputs() * w.len()).sum::<usize>();
            ends.push(end);
            weights.push(vec![1.0; windows.len()]);
        }
        Self { runs: &case.fit, shape, ends, sigma: sigmas(&case.vehicle.sensors), weights }
    }

    /// The same windows and weights for another shape.
    pub(super) fn with<'s>(&self, shape: &'s Shape) -> Windows<'s>
    where
        'a: 's,
    {
        Windows {
            shape,
            runs: self.runs,
            ends: self.ends.clone(),
            sigma: self.sigma,
            weights: self.weights.clone(),
        }
    }

    /// Gives windows that `theta` misses by far less weight, so that one which falls on the wrong side of the edge
    /// between holding and sliding does not decide the fit.
    pub fn reweight(&mut self, theta: &[f64]) {
        let built = self.shape.build(theta);
        let tallies: Vec<Vec<f64>> = self
            .runs
            .iter()
            .map(|run| {
                open_loop::tallies(&built, run, &self.sigma).iter().map(open_loop::Tally::gap).collect()
            })
            .collect();
        let mut all: Vec<f64> = tallies.iter().flatten().copied().collect();
        all.sort_by(f64::total_cmp);
        let median = all.get(all.len() / 2).copied().unwrap_or(1.0);
        let limit = TOLERATED * median.max(2.0);
        for (weights, gaps) in self.weights.iter_mut().zip(&tallies) {
            for (weight, gap) in weights.iter_mut().zip(gaps) {
                *weight = (limit / gap).min(1.0);
            }
        }
    }
}

impl Windows<'_> {
    /// Appends the weighted errors of one run.
    fn errors(&self, built: &Built, block: usize, out: &mut Vec<f64>) {
        let (run, weights) = (&self.runs[block], &self.weights[block]);
        for (window, weight) in open_loop::predict(built, run).iter().zip(weights) {
            let root = (weight * INDEPENDENT_SHARE).sqrt();
            for (k, predicted) in window.range.clone().zip(&window.outputs) {
                let innovation = run.samples[k].innovation(predicted);
                for j in 0..run.outputs() {
                    let error = -root * innovation[j] / self.sigma[j];
                    out.push(if error.is_finite() { error.clamp(-1e5, 1e5) } else { 1e5 });
                }
            }
        }
    }
}

/// Share of the samples of a window that count as independent: open-loop errors drift slowly, and a gap of two is clutter.
const INDEPENDENT_SHARE: f64 = 0.01;

/// Windows whose gap exceeds the median by this factor count linearly.
const TOLERATED: f64 = 2.0;

impl Problem for Windows<'_> {
    fn residuals(&self, theta: &[f64]) -> Vec<f64> {
        let built = self.shape.build(theta);
        let mut out = Vec::with_capacity(self.ends.last().copied().unwrap_or(0));
        (0..self.runs.len()).for_each(|block| self.errors(&built, block, &mut out));
        out
    }

    fn block_residuals(&self, theta: &[f64], block: usize) -> Vec<f64> {
        let mut out = Vec::new();
        self.errors(&self.shape.build(theta), block, &mut out);
        out
    }

    fn block_ends(&self) -> &[usize] {
        &self.ends
    }

    fn huber(&self) -> f64 {
        f64::INFINITY
    }
}
