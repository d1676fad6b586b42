//! Robust Levenberg–Marquardt for problems whose residuals come in runs.
//!
//! The solver sees residuals in blocks (runs), keeps each block's normal equations, and so gets leave-one-run-out
//! predictions from one fit: without a block's equations the optimum moves by one Newton step. Levels that only one run shows, such
//! as the adhesion of a low rail, are no prediction's business: they are fitted to all runs.

use crate::fit::bounded_step::step_within;
use crate::model::parameters::Parameter;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::borrow::Cow;

/// A problem: residuals in blocks as functions of the parameters.
pub trait Problem: Sync {
    /// Residuals, block after block; the blocks' lengths never change.
    fn residuals(&self, theta: &[f64]) -> Vec<f64>;
    /// End of each block in the vector of residuals.
    fn block_ends(&self) -> &[usize];
    /// Residuals of one block alone.
    fn block_residuals(&self, theta: &[f64], block: usize) -> Vec<f64>;
    /// Residuals beyond this many sigma count linearly (Huber).
    fn huber(&self) -> f64;
    /// Derivatives of the residuals, column by column, with respect to the parameters of `range`; `base` are the residuals.
    fn columns(
        &self,
        parameters: &[Parameter],
        theta: &[f64],
        base: &[f64],
        range: std::ops::Range<usize>,
    ) -> Vec<Vec<f64>> {
        let (all, of) =
            (|theta: &[f64]| self.residuals(theta), |theta: &[f64], b| self.block_residuals(theta, b));
        differences(parameters, theta, (base, self.block_ends()), range, all, of)
    }
}

/// Normal equations of one block: half the cost, its gradient and curvature.
#[derive(Clone, Debug)]
pub struct Block {
    /// Half the robust cost.
    pub cost: f64,
    /// Gradient.
    pub gradient: DVector<f64>,
    /// Gauss–Newton curvature.
    pub curvature: DMatrix<f64>,
}

/// A fit.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Parameters.
    pub theta: Vec<f64>,
    /// Half the robust cost of the data (minus a log-likelihood up to a constant).
    pub cost: f64,
    /// Half the cost of the priors.
    pub prior_cost: f64,
    /// Whether the last step changed nothing that matters.
    pub converged: bool,
    /// Normal equations of each block at the solution; empty until [`linearise`].
    pub blocks: Vec<Block>,
}

impl Fit {
    /// Cost with priors.
    pub fn total(&self) -> f64 {
        self.cost + self.prior_cost
    }
}

fn rho(residual: f64, huber: f64) -> f64 {
    let size = residual.abs();
    if size <= huber { 0.5 * residual * residual } else { huber * (size - 0.5 * huber) }
}

fn weight(residual: f64, huber: f64) -> f64 {
    let size = residual.abs();
    if size <= huber { 1.0 } else { huber / size }
}

/// Half the robust cost of residuals.
pub fn cost_of(residuals: &[f64], huber: f64) -> f64 {
    residuals.iter().map(|r| rho(*r, huber)).sum()
}

fn prior_cost(parameters: &[Parameter], theta: &[f64]) -> f64 {
    let term = |(p, t): (&Parameter, &f64)| 0.5 * ((t - p.prior_mean) / p.prior_sigma).powi(2);
    parameters.iter().zip(theta).map(term).sum()
}

/// Derivatives of `residuals`, whose value at `theta` is `base` with blocks that end at `ends`, with respect to the parameters
/// `which`, by differences. `of_block` are the residuals of one block alone, for parameters that concern no other.
pub fn differences(
    parameters: &[Parameter],
    theta: &[f64],
    (base, ends): (&[f64], &[usize]),
    which: std::ops::Range<usize>,
    residuals: impl Fn(&[f64]) -> Vec<f64> + Sync,
    of_block: impl Fn(&[f64], usize) -> Vec<f64> + Sync,
) -> Vec<Vec<f64>> {
    which
        .into_par_iter()
        .map(|j| {
            let p = &parameters[j];
            let mut by = DIFFERENCE * p.scale;
            if theta[j] + by > p.upper {
                by = -by;
            }
            let mut moved = theta.to_vec();
            moved[j] += by;
            let slope = |(there, here): (&mut f64, &f64)| *there = (*there - here) / by;
            let alone = p.run.filter(|run| *run < ends.len()).map(|run| vec![run]);
            let Some(blocks) = alone.or_else(|| p.shows_in.clone()) else {
                let mut column = residuals(&moved);
                column.iter_mut().zip(base).for_each(slope);
                return column;
            };
            let mut column = vec![0.0; base.len()];
            for block in blocks {
                let own = if block == 0 { 0 } else { ends[block - 1] }..ends[block];
                let mut part = of_block(&moved, block);
                part.iter_mut().zip(&base[own.clone()]).for_each(slope);
                column[own].copy_from_slice(&part);
            }
            column
        })
        .collect()
}

/// Finite-difference step relative to a parameter's scale.
const DIFFERENCE: f64 = 0.02;

fn block(residuals: &[f64], columns: &[&[f64]], huber: f64) -> Block {
    let n = columns.len();
    let mut gradient = DVector::zeros(n);
    let mut curvature = DMatrix::zeros(n, n);
    let weighted: Vec<f64> = residuals.iter().map(|r| weight(*r, huber)).collect();
    let mut scaled = vec![0.0; residuals.len()];
    for i in 0..n {
        for (s, (c, w)) in scaled.iter_mut().zip(columns[i].iter().zip(&weighted)) {
            *s = c * w;
        }
        gradient[i] = dot(&scaled, residuals);
        for j in 0..=i {
            let value = dot(&scaled, columns[j]);
            curvature[(i, j)] = value;
            curvature[(j, i)] = value;
        }
    }
    Block { cost: cost_of(residuals, huber), gradient, curvature }
}

/// A dot product in eight fixed lanes: fast, and the same on every machine and thread count.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 8];
    let (a8, b8) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a8.remainder().iter().zip(b8.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in a8.zip(b8) {
        for lane in 0..8 {
            lanes[lane] += x[lane] * y[lane];
        }
    }
    lanes.iter().sum::<f64>() + rest
}

/// Normal equations of each block.
pub fn blocks_of<C: AsRef<[f64]>>(
    residuals: &[f64],
    columns: &[C],
    ends: &[usize],
    huber: f64,
) -> Vec<Block> {
    let mut from = 0;
    ends.iter()
        .map(|&to| {
            let views: Vec<&[f64]> = columns.iter().map(|c| &c.as_ref()[from..to]).collect();
            let block = block(&residuals[from..to], &views, huber);
            from = to;
            block
        })
        .collect()
}

/// Sum of the blocks and the priors: gradient and curvature of the whole cost.
pub fn assemble(parameters: &[Parameter], theta: &[f64], blocks: &[Block]) -> (DVector<f64>, DMatrix<f64>) {
    let n = theta.len();
    let (mut gradient, mut curvature) = (DVector::zeros(n), DMatrix::zeros(n, n));
    for block in blocks {
        gradient += &block.gradient;
        curvature += &block.curvature;
    }
    for (i, p) in parameters.iter().enumerate() {
        let information = p.prior_sigma.powi(-2);
        gradient[i] += information * (theta[i] - p.prior_mean);
        curvature[(i, i)] += information;
    }
    (gradient, curvature)
}

/// What the solver may spend.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Iterations.
    pub iterations: usize,
    /// Columns of parameters below this index are computed at the start and then every `refresh` iterations only.
    pub slow_columns: usize,
    /// See `slow_columns`.
    pub refresh: usize,
    /// Decrease of the cost below which the fit has converged.
    pub tolerance: f64,
}

/// Fits from `start`; `slow` are columns of the first parameters known from elsewhere.
pub fn fit(
    problem: &(impl Problem + ?Sized),
    parameters: &[Parameter],
    start: &[f64],
    effort: Effort,
    slow: Option<&[Vec<f64>]>,
) -> Fit {
    fit_with(problem, parameters, start, effort, slow.map(Cow::Borrowed)).0
}

/// As [`fit`], with the columns of the first parameters as they were last computed.
pub(super) fn fit_keeping(
    problem: &(impl Problem + ?Sized),
    parameters: &[Parameter],
    start: &[f64],
    effort: Effort,
) -> (Fit, Vec<Vec<f64>>) {
    let (fit, slow) = fit_with(problem, parameters, start, effort, None);
    (fit, slow.map_or_else(Vec::new, Cow::into_owned))
}

fn fit_with<'c>(
    problem: &(impl Problem + ?Sized),
    parameters: &[Parameter],
    start: &[f64],
    effort: Effort,
    mut slow: Option<Cow<'c, [Vec<f64>]>>,
) -> (Fit, Option<Cow<'c, [Vec<f64>]>>) {
    let huber = problem.huber();
    let mut theta: Vec<f64> = start.iter().zip(parameters).map(|(t, p)| t.clamp(p.lower, p.upper)).collect();
    let mut residuals = problem.residuals(&theta);
    let mut cost = cost_of(&residuals, huber);
    let mut prior = prior_cost(parameters, &theta);
    let mut damping = 1e-3;
    let mut converged = false;
    // Iterations since the slow columns were computed.
    let mut age = 0;
    for _ in 0..effort.iterations {
        age += 1;
        if slow.is_none() || age > effort.refresh {
            slow = Some(problem.columns(parameters, &theta, &residuals, 0..effort.slow_columns).into());
            age = 0;
        }
        let known = slow.as_deref().unwrap_or_default();
        let own = problem.columns(parameters, &theta, &residuals, known.len()..theta.len());
        let all: Vec<&[f64]> = known.iter().chain(&own).map(Vec::as_slice).collect();
        let blocks = blocks_of(&residuals, &all, problem.block_ends(), huber);
        let (gradient, curvature) = assemble(parameters, &theta, &blocks);
        let before = cost + prior;
        let mut improved = false;
        for _ in 0..6 {
            let Some(change) = step_within(parameters, &theta, &gradient, &curvature, damping) else { break };
            let trial: Vec<f64> = theta.iter().zip(change.iter()).map(|(t, c)| t + c).collect();
            let trial_residuals = problem.residuals(&trial);
            let trial_cost = cost_of(&trial_residuals, huber);
            let trial_prior = prior_cost(parameters, &trial);
            if trial_cost + trial_prior < before {
                (theta, residuals, cost, prior) = (trial, trial_residuals, trial_cost, trial_prior);
                damping = (damping * 0.2).max(1e-9);
                improved = true;
                break;
            }
            damping = (damping * 10.0).max(1e-4);
        }
        // Far from white residuals the model is wrong anyway: a thousandth of the excess is then close enough.
        let excess = (cost - 0.5 * residuals.len() as f64).max(0.0);
        if !improved || before - (cost + prior) < effort.tolerance + 2e-3 * excess {
            // Old columns may be what stopped it: only fresh ones tell, where any are to be had.
            if effort.slow_columns == 0 || age == 0 || effort.refresh >= effort.iterations {
                converged = true;
                break;
            }
            age = effort.refresh;
        }
    }
    (Fit { theta, cost, prior_cost: prior, converged, blocks: Vec::new() }, slow)
}

/// Normal equations and columns of a fit at its solution.
pub fn linearise(
    problem: &(impl Problem + ?Sized),
    parameters: &[Parameter],
    fit: &mut Fit,
) -> (Vec<f64>, Vec<Vec<f64>>) {
    let residuals = problem.residuals(&fit.theta);
    let all = problem.columns(parameters, &fit.theta, &residuals, 0..fit.theta.len());
    fit.blocks = blocks_of(&residuals, &all, problem.block_ends(), problem.huber());
    (residuals, all)
}
