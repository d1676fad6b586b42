//! Time of one filter step, measured on real samples of a rig.

use crate::traction::run::{Case, SENSOR_SIGMA, simulate};
use railgrip_filter::models::traction_rig::{
    TractionBelief, TractionEkf, TractionFilter, TractionModel, TractionNoise, TractionUkf,
};
use railgrip_vehicle::traction_rig::Surface;
use std::time::Instant;

/// Time of a filter's step.
#[derive(Clone, Debug)]
pub struct StepTime {
    /// Which filter.
    pub name: &'static str,
    /// Mean over all steps of the fastest of several rounds, ns.
    pub step_ns: f64,
    /// Steps of a round.
    pub steps: usize,
}

/// Times the filters of the traction rig on `samples` samples (at least 100).
pub fn traction_filters(samples: usize) -> Vec<StepTime> {
    let case = Case { surface: Surface::Base, number: 4 };
    let run = simulate(case, 1, samples.max(100) as f64 * 1e-3, SENSOR_SIGMA);
    let (model, noise) = (TractionModel::new(case.rig()), TractionNoise::default());
    vec![
        time("13-state square-root UKF step", TractionUkf::new(model.clone(), noise), &run),
        time("13-state EKF step, numerical Jacobian", TractionEkf::new(model, noise), &run),
    ]
}

fn time<B: TractionBelief>(
    name: &'static str,
    filter: TractionFilter<B>,
    run: &[crate::traction::run::Instant],
) -> StepTime {
    let mut best = f64::INFINITY;
    for _ in 0..3 {
        let mut filter = filter.clone();
        let start = Instant::now();
        for instant in run {
            std::hint::black_box(filter.step(&instant.sample));
        }
        best = best.min(start.elapsed().as_nanos() as f64 / run.len() as f64);
    }
    StepTime { name, step_ns: best, steps: run.len() }
}
