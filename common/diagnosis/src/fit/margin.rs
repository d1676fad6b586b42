//! A fit that keeps clear of the edge of sliding.
//!
//! Where adhesion falls with slip, a little less of it than a wheelset asks for lets the wheelset lock, and predictions of a run that was
//! not fitted go astray by a hundred sigmas; a little more costs next to nothing. The best fit to some runs may lie at that edge. What is
//! minimised here is therefore what is to be expected where the adhesion of another run on that rail is a little different.

use crate::data::case::Case;
use crate::model::parameters::Shape;
use crate::predict::open_loop::{Tally, sigmas, tallies};
use rayon::prelude::*;

/// Step by which adhesion is tried, relative.
const STEP: f64 = 0.005;
/// By so many steps adhesion may be different in another run, down and up. Set by hand: one per cent.
const SPREAD: usize = 2;
/// So many steps adhesion may be put higher than it fits best. Set by hand.
const HIGHEST: usize = 4;
/// Share of the squared error to be expected that must be saved by that. Set by hand: what is not at an edge stays where it fits best.
const LEAST_SAVED: f64 = 0.2;

/// `theta` with the adhesion of each class of rail so much higher that the squared error of the runs to fit on, over all that it may be
/// in another run, is least.
pub(super) fn keep_clear(case: &Case, shape: &Shape, theta: &[f64]) -> Vec<f64> {
    let mut clear = theta.to_vec();
    for (place, parameter) in shape.parameters().iter().enumerate().take(shape.nuisance_count()) {
        let Some(runs) = parameter.shows_in.as_ref().filter(|runs| !runs.is_empty()) else { continue };
        let at = |steps: f64| {
            let mut theta = theta.to_vec();
            theta[place] = ((1.0 + theta[place]) * (1.0 + steps * STEP) - 1.0).min(parameter.upper);
            theta
        };
        let costs: Vec<f64> = (0..=2 * SPREAD + HIGHEST)
            .into_par_iter()
            .map(|k| squared_error(case, shape, runs, &at(k as f64 - SPREAD as f64)))
            .collect();
        clear[place] = at(clearance(&costs) as f64)[place];
    }
    clear
}

/// How many steps higher the mean of neighbouring costs is least; the cost of the fit is that at [`SPREAD`].
fn clearance(costs: &[f64]) -> usize {
    let expected: Vec<f64> = costs.windows(2 * SPREAD + 1).map(|near| near.iter().sum()).collect();
    let least = expected.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1));
    least.filter(|(_, cost)| **cost < (1.0 - LEAST_SAVED) * expected[0]).map_or(0, |(steps, _)| steps)
}

/// Squared gap over the windows of these runs to fit on.
fn squared_error(case: &Case, shape: &Shape, runs: &[usize], theta: &[f64]) -> f64 {
    let (built, sigma) = (shape.build(theta), sigmas(&case.vehicle.sensors));
    let windows: Vec<Tally> = runs.iter().flat_map(|run| tallies(&built, &case.fit[*run], &sigma)).collect();
    Tally::total(&windows).gap().powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fit_beside_a_cliff_steps_back_and_one_in_a_valley_stays() {
        let valley = |steps: f64| 13.0 + 2.0 * steps.powi(2);
        let costs = |cliff: f64| -> Vec<f64> {
            (0..9)
                .map(|k| f64::from(k) - 2.0)
                .map(|steps| if steps < cliff { 300.0 } else { valley(steps) })
                .collect()
        };
        assert_eq!(clearance(&costs(-10.0)), 0);
        assert_eq!(clearance(&costs(-1.0)), 1, "a step away from the edge, and not as far as it goes");
        assert_eq!(clearance(&costs(0.0)), 2);
        assert_eq!(clearance(&[5.0; 9]), 0);
    }
}
