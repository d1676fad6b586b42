//! Innovations around a fitted model, by their response to what comes on top of it.

use crate::fit::candidate::Fitted;
use crate::fit::objective::{Objective, Whitening};
use crate::fit::solver::Problem;
use crate::model::parameters::Shape;
use crate::predict::disturbances::OUTLIER_SIGMA;
use crate::predict::response::Path;

/// Innovations around a fitted model without simulating again, see [`response`](crate::predict::response): what was fitted
/// before counts by its derivatives, what comes on top by its response along the paths.
#[derive(Debug)]
pub struct Linearisation<'a> {
    whitening: &'a Whitening<'a>,
    base: &'a Fitted,
    paths: Vec<Path<'a>>,
}

impl<'a> Linearisation<'a> {
    /// Around `base`, which was fitted with `whitening` and linearised.
    pub fn new(whitening: &'a Whitening<'a>, base: &'a Fitted) -> Self {
        let built = base.shape.build(&base.fit.theta);
        Self { whitening, base, paths: whitening.paths(&built) }
    }

    /// Residuals of one run.
    fn run(&self, shape: &Shape, theta: &[f64], run: usize, out: &mut Vec<f64>) {
        let (held, own) = (&self.base.fit.theta, &theta[self.base.fit.theta.len()..]);
        let around: Vec<f64> = held.iter().chain(own).copied().collect();
        let from = out.len();
        self.paths[run].residuals(&shape.build(&around), out);
        let ends = self.whitening.ends();
        let start = if run == 0 { 0 } else { ends[run - 1] };
        for (column, moved) in self.base.columns.iter().zip(theta.iter().zip(held).map(|(t, h)| t - h)) {
            if moved != 0.0 {
                let part = &column[start..ends[run]];
                out[from..].iter_mut().zip(part).for_each(|(residual, slope)| *residual += slope * moved);
            }
        }
    }
}

impl Objective for Linearisation<'_> {
    fn of<'s>(&'s self, shape: &'s Shape) -> Box<dyn Problem + Sync + 's> {
        Box::new(Linearised { around: self, shape })
    }
}

struct Linearised<'a> {
    around: &'a Linearisation<'a>,
    shape: &'a Shape,
}

impl Problem for Linearised<'_> {
    fn residuals(&self, theta: &[f64]) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.block_ends().last().copied().unwrap_or(0));
        (0..self.around.paths.len()).for_each(|run| self.around.run(self.shape, theta, run, &mut out));
        out
    }

    fn block_residuals(&self, theta: &[f64], block: usize) -> Vec<f64> {
        let mut out = Vec::new();
        self.around.run(self.shape, theta, block, &mut out);
        out
    }

    fn block_ends(&self) -> &[usize] {
        self.around.whitening.ends()
    }

    fn huber(&self) -> f64 {
        OUTLIER_SIGMA
    }
}
