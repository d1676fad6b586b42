//! The fits that the report is about: on the contract's own windows, from where the innovations led.

use crate::case::Case;
use crate::metric::{self, Tally, sigmas};
use crate::objective::Windows;
use crate::parameters::Shape;
use crate::solver::{self, Effort, Problem};

/// Rounds of reweighting the windows that fall on the wrong side between holding and sliding.
const ROUNDS: usize = 3;
const EFFORT: Effort = Effort { iterations: 6, slow_columns: 0, refresh: 1, tolerance: 0.02 };

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
    for _ in 0..ROUNDS {
        problem.reweight(&theta);
        let before = theta.clone();
        let fit = solver::fit(&problem, shape.parameters(), &theta, EFFORT, None);
        theta = fit.theta;
        let moved = theta.iter().zip(&before).zip(shape.parameters());
        if moved.map(|((a, b), p)| ((a - b) / p.scale).abs()).fold(0.0, f64::max) < 0.02 {
            break;
        }
    }
    debug_assert!(problem.huber().is_infinite());
    theta
}

/// Gap on the runs to fit on, with every window beyond three times the median counted as that.
fn robust_gap(case: &Case, shape: &Shape, theta: &[f64]) -> f64 {
    let mut gaps: Vec<(f64, usize)> =
        window_tallies(case, shape, theta).iter().map(|t| (t.gap(), t.count)).collect();
    gaps.sort_by(|a, b| a.0.total_cmp(&b.0));
    let median = gaps.get(gaps.len() / 2).map_or(1.0, |g| g.0);
    let limit = 3.0 * median.max(2.0);
    // Beyond the limit windows still count, but by their square root.
    let square = |gap: f64| if gap <= limit { gap * gap } else { limit * limit * (gap / limit).sqrt() };
    let samples: usize = gaps.iter().map(|g| g.1).sum();
    (gaps.iter().map(|g| square(g.0) * g.1 as f64).sum::<f64>() / samples.max(1) as f64).sqrt()
}

fn window_tallies(case: &Case, shape: &Shape, theta: &[f64]) -> Vec<Tally> {
    let sigma = sigmas(&case.vehicle.sensors);
    let built = shape.build(theta);
    case.fit.iter().flat_map(|run| metric::tallies(&built, run, &sigma)).collect()
}
