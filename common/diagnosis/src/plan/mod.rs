//! The next run: which test, within limits of speed, rail and length, would best tell apart what the recordings leave open.
//!
//! Each hypothesis (an effect with its fitted parameters, or none) drives the wagon through each test of a library. What every
//! other hypothesis would say of that run follows from its own frozen filter: half the squared length of the whitened
//! innovations that its parameters cannot take up, given how well the recordings know them already (expected information
//! between models; Lindley 1956; Box & Hill 1967). The test after which the posterior over the hypotheses is expected to have the
//! least entropy is the answer.

mod designed;
mod hypotheses;
mod runs;
mod separation;

pub use designed::Plan;
pub use runs::{Limits, Phase, PlannedRun};

use crate::answer::schema::Report;
use crate::data::case::Case;
use crate::decide::criteria::Criteria;
use crate::decide::selection::Selection;
use rayon::prelude::*;

/// Designs the run that best separates what a selection left open; `None` where there is nothing to separate.
pub(crate) fn plan(
    case: &Case,
    selection: &Selection,
    report: &Report,
    limits: &Limits,
    criteria: &Criteria,
) -> Option<Plan> {
    let hypotheses = hypotheses::of(selection, report);
    if hypotheses.len() < 2 {
        return None;
    }
    let tests = runs::library(case, limits);
    let tolerance = selection.best.tolerance;
    let left = |test: &PlannedRun| {
        let apart = separation::of(case, &hypotheses, test, tolerance, criteria.report.widening);
        separation::expected_entropy(&hypotheses, &apart)
    };
    let left: Vec<f64> = tests.par_iter().map(left).collect();
    let (best, entropy_after) = left.iter().copied().enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let p: Vec<f64> = hypotheses.iter().map(|hypothesis| hypothesis.p).collect();
    let run = tests[best].clone();
    let mut plan = Plan {
        separates: hypotheses.iter().map(|hypothesis| hypothesis.effects.clone()).collect(),
        entropy_before: separation::entropy(&p),
        entropy_after,
        entropy_after_random: left.iter().sum::<f64>() / left.len() as f64,
        p,
        run,
        words: String::new(),
        seconds: 0.0,
    };
    plan.words = designed::words(&plan);
    Some(plan)
}
