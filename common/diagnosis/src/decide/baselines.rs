//! Two ways in which the question is usually answered, to compare with.

use crate::data::case::Case;
use crate::fit::objective::{Innovations, Whitening};
use crate::fit::solver::{self, Problem, dot};
use crate::fit::windows;
use crate::model::candidates;
use crate::model::parameters::{Built, Shape};
use crate::predict::disturbances::DisturbanceModel;
use crate::predict::open_loop::{self, Tally, sigmas};

/// Ids by the plain gap on the fit runs that each candidate reaches at its default strength after calibration of the
/// nuisances alone, best first: what trying out effects by hand amounts to.
pub fn calibrated_rmse_ranking(case: &Case) -> Vec<&'static str> {
    let shape = Shape::nominal(case);
    let theta = windows::fit(case, &shape, &[shape.start()]);
    let sigma = sigmas(&case.vehicle.sensors);
    let gap = |built: &Built| {
        let tallies: Vec<Tally> =
            case.fit.iter().flat_map(|run| open_loop::tallies(built, run, &sigma)).collect();
        Tally::total(&tallies).gap()
    };
    rank(candidates::all(case, &[]).iter().map(|candidate| {
        let gaps = candidate.starts.iter().map(|effect| {
            let mut all = theta.clone();
            all.extend(effect.parameters.iter().map(|p| p.start));
            gap(&shape.with(effect).build(&all))
        });
        (candidate.spec.id, -gaps.fold(f64::INFINITY, f64::min))
    }))
}

/// Ids by the largest correlation of the calibrated model's open-loop residuals with the sensitivity to the effect at
/// its default strength, once, without refitting.
pub fn correlation_ranking(case: &Case) -> Vec<&'static str> {
    let shape = Shape::nominal(case);
    let built = shape.build(&shape.start());
    let whitening = Whitening::new(case, &built, &DisturbanceModel::default());
    let problem = Innovations { whitening: &whitening, shape: &shape };
    let effort = solver::Effort { iterations: 6, slow_columns: 0, refresh: 1, tolerance: 1.0 };
    let fit = solver::fit(&problem, shape.parameters(), &shape.start(), effort, None);
    let base = problem.residuals(&fit.theta);
    let norm = dot(&base, &base).sqrt();
    rank(candidates::all(case, &[]).iter().map(|candidate| {
        let correlations = candidate.starts.iter().map(|effect| {
            let with = shape.with(effect);
            let mut theta = fit.theta.clone();
            theta.extend(effect.parameters.iter().map(|p| p.start));
            let moved = Innovations { whitening: &whitening, shape: &with }.residuals(&theta);
            let change: Vec<f64> = moved.iter().zip(&base).map(|(m, b)| m - b).collect();
            let size = dot(&change, &change).sqrt();
            if size > 0.0 { (dot(&change, &base) / (size * norm)).abs() } else { 0.0 }
        });
        (candidate.spec.id, correlations.fold(0.0, f64::max))
    }))
}

fn rank(scores: impl Iterator<Item = (&'static str, f64)>) -> Vec<&'static str> {
    let mut scores: Vec<(&'static str, f64)> = scores.collect();
    scores.sort_by(|a, b| b.1.total_cmp(&a.1));
    scores.into_iter().map(|(id, _)| id).collect()
}
