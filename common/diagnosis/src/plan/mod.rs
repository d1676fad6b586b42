//! The next run: which test, within limits of speed, rail and length, would best tell apart what the recordings leave open.
//!
//! Each model that may be true (the calibrated one, and those with effects as the recordings fit them) drives the wagon through each test
//! of a library, and every other model predicts that run window by window. What the gaps would make of the sets of effects that
//! are possible now is worked out as it is for a run that was made (`settled`); the test after which they are expected to have the least
//! entropy is the answer (expected information; Lindley 1956).

mod designed;
mod models;
mod runs;
mod separation;
mod settled;

pub use designed::Plan;
pub use runs::{Limits, Phase, PlannedRun};
pub(crate) use settled::settle;
pub use settled::{Settled, SettledEffect};

use crate::answer::schema::{PosteriorSet, Report};
use crate::data::case::Case;
use crate::decide::criteria::Criteria;
use crate::decide::posterior::Calibration;
use crate::decide::selection::Selection;
use models::Model;
use rayon::prelude::*;
use separation::Doubt;

/// Probability that is left to a model that the report does not list: a certain finding gets a mild test.
const LEAST_DOUBT: f64 = 0.02;

/// Designs the run that best separates what a selection left open; `None` where there is nothing to separate.
pub(crate) fn plan(
    case: &Case,
    selection: &Selection,
    report: &Report,
    limits: &Limits,
    criteria: &Criteria,
) -> Option<Plan> {
    let models = models::of(case, selection, report, criteria);
    if models.len() < 2 {
        return None;
    }
    let mut sets = report.posterior.clone();
    for model in models.iter().filter(|model| model.effects.len() == 1) {
        if !sets.iter().any(|set| !set.unknown && set.effects == model.effects) {
            sets.push(PosteriorSet { effects: model.effects.clone(), unknown: false, p: LEAST_DOUBT });
        }
    }
    let own = |model: &Model| sets.iter().find(|set| !set.unknown && set.effects == model.effects);
    let (calibration, natural) =
        (Calibration::shipped(), report.gap.natural.map_or(1.0, |natural| natural.fit));
    let doubt = Doubt {
        p: models.iter().map(|model| own(model).map_or(0.0, |set| set.p)).collect(),
        models: &models,
        sets: &sets,
        natural,
        weights: &calibration.tests,
    };
    let tests = runs::library(case, limits);
    let left: Vec<f64> = tests.par_iter().map(|test| doubt.expected_entropy(case, test)).collect();
    let (best, entropy_after) = left.iter().copied().enumerate().min_by(|a, b| a.1.total_cmp(&b.1))?;
    let mut separates: Vec<(Vec<String>, f64)> =
        models.iter().map(|model| model.effects.clone()).zip(doubt.p).filter(|(_, p)| *p > 0.0).collect();
    separates.sort_by(|a, b| b.1.total_cmp(&a.1));
    let (separates, p) = separates.into_iter().unzip();
    let run = tests[best].clone();
    let mut plan = Plan {
        separates,
        p,
        entropy_before: separation::entropy(&sets),
        entropy_after,
        entropy_after_random: left.iter().sum::<f64>() / left.len() as f64,
        run,
        words: String::new(),
        seconds: 0.0,
    };
    plan.words = designed::words(&plan);
    Some(plan)
}
