//! What a fit loses by leaving: a block of what it was fitted to, or the bound on which a parameter sits.

use crate::fit::bounded_step::step_with;
use crate::fit::solver::{Block, Fit, Problem, assemble, cost_of};
use crate::model::parameters::Parameter;
use nalgebra::DVector;

/// What it costs at least to move one parameter by `by` from the solution of a fit, the others fitted again: by the curvature there.
/// Nothing where the fit was not linearised.
pub fn cost_of_leaving(parameters: &[Parameter], fit: &Fit, index: usize, by: f64) -> Option<f64> {
    if fit.blocks.is_empty() {
        return None;
    }
    let (gradient, curvature) = assemble(parameters, &fit.theta, &fit.blocks);
    let mut unit = DVector::zeros(gradient.len());
    unit[index] = 1.0;
    let spread = curvature.cholesky()?.solve(&unit)[index];
    Some((gradient[index] * by).max(0.0) + 0.5 * by * by / spread)
}

/// Shares to which a step is shortened, each half of the one before.
const SHORTER: [f64; 5] = [0.5, 0.25, 0.125, 0.0625, 0.03125];
/// What a block loses by a step that need not be looked at. Effort.
const FELT_LOSS: f64 = 2.0;
/// What the other blocks may lose by it, relative to that: nuisances fit all blocks, so they lose a little even by what they teach.
const LOST_ELSEWHERE: f64 = 0.1;

/// Half cost of each block where the parameters `tested` are what a Newton step without that block gives them, and all others fit
/// all blocks: what is tested has to be learnt elsewhere, and nothing else is asked to. A step from which the other blocks lose is
/// not what they teach, and is shortened: so are steps of a fit where the cost is bent, as by a frequency.
pub fn leave_one_out(
    problem: &(impl Problem + ?Sized),
    parameters: &[Parameter],
    fit: &Fit,
    tested: std::ops::Range<usize>,
) -> Vec<f64> {
    let is_tested = |i: usize| tested.contains(&i) && parameters[i].run.is_none();
    if !(0..parameters.len()).any(is_tested) {
        return fit.blocks.iter().map(|block| block.cost).collect();
    }
    let (gradient, curvature) = assemble(parameters, &fit.theta, &fit.blocks);
    let moved = |index: usize, block: &Block| {
        let mut rest = &curvature - &block.curvature;
        for (i, p) in parameters.iter().enumerate() {
            rest[(i, i)] += 1e-9 * curvature[(i, i)] + 1e-9 / p.scale.powi(2);
        }
        let pull = &gradient - &block.gradient;
        let own = parameters.iter().map(|p| (p.run == Some(index)).then_some(0.0)).collect();
        let without = step_with(parameters, &fit.theta, (&pull, &rest), 0.0, own)?;
        let held = (0..parameters.len()).map(|i| is_tested(i).then(|| without[i])).collect();
        step_with(parameters, &fit.theta, (&gradient, &curvature), 0.0, held)
    };
    let predicted = |(index, block): (usize, &Block)| {
        let Some(change) = moved(index, block) else { return block.cost };
        let after = |share: f64| -> Vec<f64> {
            fit.theta.iter().zip(change.iter()).map(|(t, c)| t + share * c).collect()
        };
        let cost =
            |theta: &[f64], block: usize| cost_of(&problem.block_residuals(theta, block), problem.huber());
        let lost_by_others = |theta: &[f64]| -> f64 {
            let others = fit.blocks.iter().enumerate().filter(|(other, _)| *other != index);
            others.map(|(other, block)| cost(theta, other) - block.cost).sum()
        };
        let mut predicted = cost(&after(1.0), index);
        for share in SHORTER {
            if predicted - block.cost < FELT_LOSS {
                break;
            }
            let lost = lost_by_others(&after(2.0 * share));
            if lost < LOST_ELSEWHERE * (predicted - block.cost) {
                break;
            }
            predicted = cost(&after(share), index);
        }
        predicted
    };
    fit.blocks.iter().enumerate().map(predicted).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::solver::{Effort, fit, linearise};

    /// Two runs that show a slope; the second alone shows a level beside it, and `split` adds a second slope that acts alike.
    struct Runs {
        measured: [f64; 8],
        split: bool,
    }

    impl Runs {
        fn of_run(&self, theta: &[f64], run: usize) -> Vec<f64> {
            let slope = if self.split { theta[1] + theta[2] } else { theta[1] };
            let level = if run == 1 { theta[0] } else { 0.0 };
            let at = |k: usize| slope * k as f64 + level - self.measured[4 * run + k];
            (0..4).map(at).collect()
        }
    }

    impl Problem for Runs {
        fn residuals(&self, theta: &[f64]) -> Vec<f64> {
            [self.of_run(theta, 0), self.of_run(theta, 1)].concat()
        }

        fn block_ends(&self) -> &[usize] {
            &[4, 8]
        }

        fn block_residuals(&self, theta: &[f64], block: usize) -> Vec<f64> {
            self.of_run(theta, block)
        }

        fn huber(&self) -> f64 {
            1e3
        }
    }

    fn parameter(k: usize) -> Parameter {
        Parameter {
            name: k.to_string(),
            start: 0.0,
            lower: -10.0,
            upper: 10.0,
            scale: 1.0,
            prior_mean: 0.0,
            prior_sigma: 100.0,
            run: None,
            shows_in: None,
        }
    }

    fn fitted(runs: &Runs, number: usize) -> (Vec<Parameter>, Fit) {
        let parameters: Vec<Parameter> = (0..number).map(parameter).collect();
        let effort = Effort { iterations: 20, slow_columns: 0, refresh: 1, tolerance: 1e-12 };
        let mut fit = fit(runs, &parameters, &vec![0.0; number], effort, None);
        linearise(runs, &parameters, &mut fit);
        (parameters, fit)
    }

    #[test]
    fn a_level_that_one_run_shows_is_not_asked_of_the_others() {
        // Slope 2, level 5, and a little noise.
        let runs = Runs { measured: [0.1, 1.9, 4.0, 6.1, 5.0, 7.1, 9.0, 10.9], split: false };
        let (parameters, fit) = fitted(&runs, 2);
        let costs: Vec<f64> = fit.blocks.iter().map(|block| block.cost).collect();
        let slope = leave_one_out(&runs, &parameters, &fit, 1..2);
        for run in [0, 1] {
            assert!(slope[run] >= costs[run] - 1e-9 && slope[run] < costs[run] + 0.1, "{slope:?} {costs:?}");
        }
        let both = leave_one_out(&runs, &parameters, &fit, 0..2);
        assert!(both[1] > 40.0, "without its run nothing is known of the level: {both:?}");
        assert_eq!(leave_one_out(&runs, &parameters, &fit, 0..0), costs);
    }

    #[test]
    fn a_slope_that_one_run_contradicts_predicts_it_badly() {
        let runs = Runs { measured: [0.0, 2.0, 4.0, 6.0, 5.0, 4.0, 3.0, 2.0], split: false };
        let (parameters, fit) = fitted(&runs, 2);
        let left_out: f64 = leave_one_out(&runs, &parameters, &fit, 1..2).iter().sum();
        let without = cost_of(&runs.residuals(&[3.5, 0.0]), 1e3);
        assert!(fit.cost < without && left_out > without, "{} {left_out} {without}", fit.cost);
    }

    /// The first run is bent, so that its Newton step goes beyond where it came from; the second wants to stay.
    struct Bent;

    impl Problem for Bent {
        fn residuals(&self, theta: &[f64]) -> Vec<f64> {
            vec![10.0 * (5.0 * theta[0]).atan(), 5.0 * (theta[0] - 0.5)]
        }

        fn block_ends(&self) -> &[usize] {
            &[1, 2]
        }

        fn block_residuals(&self, theta: &[f64], block: usize) -> Vec<f64> {
            vec![self.residuals(theta)[block]]
        }

        fn huber(&self) -> f64 {
            1e3
        }
    }

    #[test]
    fn a_step_by_which_the_others_lose_is_not_what_they_teach() {
        let parameters = vec![parameter(0)];
        let mut fit =
            Fit { theta: vec![0.5], cost: 0.0, prior_cost: 0.0, blocks: Vec::new(), converged: true };
        linearise(&Bent, &parameters, &mut fit);
        let x: f64 = 2.5;
        let whole = -(x.atan() * (1.0 + x * x)) / 5.0;
        assert!(
            cost_of(&Bent.block_residuals(&[0.5 + whole], 0), 1e3) > fit.blocks[0].cost,
            "it goes too far"
        );
        let left_out = leave_one_out(&Bent, &parameters, &fit, 0..1);
        let half = cost_of(&Bent.block_residuals(&[0.5 + 0.5 * whole], 1), 1e3);
        assert!((left_out[1] / half - 1.0).abs() < 0.1, "{left_out:?}, {half} at half of it");
    }

    #[test]
    fn to_leave_a_bound_costs_nothing_where_another_parameter_acts_alike() {
        let measured = [0.0, 2.0, 4.0, 6.0, 5.0, 7.0, 9.0, 11.0];
        let (alone, of_alone) = fitted(&Runs { measured, split: false }, 2);
        let cost = cost_of_leaving(&alone, &of_alone, 1, 1.0).expect("a linearised fit");
        assert!(cost > 9.0, "the second run's level takes up a part: {cost}");
        let (split, of_split) = fitted(&Runs { measured, split: true }, 3);
        let cost = cost_of_leaving(&split, &of_split, 1, 1.0).expect("a linearised fit");
        assert!(cost < 0.01, "{cost}");
        assert_eq!(cost_of_leaving(&split, &Fit { blocks: Vec::new(), ..of_split }, 1, 1.0), None);
    }
}
