//! Fits on recordings that were put right for what makes them late.
//!
//! What an effect of time explains is judged by the evidence of a filter that sees each reading at the time at which it was
//! true. The effect itself is then no part of the model; its parameters are searched by how likely the moved recordings are.

use crate::data::align::Alignments;
use crate::data::case::{Case, Run};
use crate::fit::frozen::{self, FrozenFit};
use crate::fit::solver;
use crate::fit::windows;
use crate::model::parameters::{FittedEffect, Shape};
use crate::predict::disturbances::{DisturbanceModel, OUTLIER_SIGMA};
use railgrip_vehicle::effects::{Effect, Lateness};
use rayon::prelude::*;

/// First step of the search, in samples of lateness.
const FIRST_STEP: f64 = 8.0;
/// Most rounds of the search.
const ROUNDS: usize = 12;

/// A model whose last effect makes readings late, on the recordings put right for it and for those before it, fitted there from
/// the tolerance `from` down. `None` if the effect is not one of time, or moves nothing by as much as a sample.
pub fn freeze<'a>(
    original: &'a Case,
    alignments: &'a Alignments,
    shape: &Shape,
    disturbances: &DisturbanceModel,
    theta: &[f64],
    from: usize,
) -> Option<FrozenFit<'a>> {
    let last = shape.effects.len().checked_sub(1)?;
    let own = shape.range_of(last);
    let steps = steps(original, &shape.effects[last], &theta[own.clone()])?;
    let sigmas = windows::sigmas_of(original, &shape.on_recordings(), theta, own);
    let at = |theta: &[f64], tolerance: usize| {
        let aligned = with_aligned(shape, last, theta, &sigmas);
        let case = align(original, alignments, &aligned, theta)?;
        Some(frozen::freeze(case, &aligned, disturbances, theta, tolerance))
    };
    let search = Search { original, last, steps, sigmas: &sigmas };
    let mut best = at(theta, from)?;
    // A stricter filter tells more exactly when a reading was true.
    let mut first = FIRST_STEP;
    for _ in 0..=from {
        let Some(moved) = search.along(&best, first) else { break };
        let again = at(&moved, best.tolerance)?;
        let stricter = again.tolerance < best.tolerance;
        let better = again.evidence_cost() < best.evidence_cost();
        if better {
            best = again;
        }
        if !(better && stricter) {
            break;
        }
        first = 2.0;
    }
    Some(best)
}

/// Whether the last effect of a shape makes some reading late by a sample or more.
pub(crate) fn is_late(case: &Case, shape: &Shape, theta: &[f64]) -> bool {
    let last = shape.effects.len().checked_sub(1);
    last.is_some_and(|last| steps(case, &shape.effects[last], &theta[shape.range_of(last)]).is_some())
}

/// The recordings put right for all effects of `shape` that are [aligned](FittedEffect::is_aligned), as they are if there are
/// none; `None` if no more can be kept.
pub(crate) fn align<'a>(
    original: &'a Case,
    alignments: &'a Alignments,
    shape: &Shape,
    theta: &[f64],
) -> Option<&'a Case> {
    match lateness(shape, theta) {
        Some(late) => alignments.keep(original.aligned(&late)),
        None => Some(original),
    }
}

/// What all aligned effects of a shape do to the readings together; `None` without one.
fn lateness(shape: &Shape, theta: &[f64]) -> Option<impl Fn(f64) -> Lateness> {
    let aligned: Vec<Box<dyn Effect>> = (0..shape.effects.len())
        .filter(|e| shape.effects[*e].is_aligned())
        .map(|e| shape.effects[e].build(&theta[shape.range_of(e)]))
        .collect();
    (!aligned.is_empty()).then_some(move |time_s: f64| {
        aligned.iter().map(|effect| effect.lateness(time_s)).fold(Lateness::default(), |sum, own| sum + own)
    })
}

/// `shape` with one of its effects aligned at `theta`.
fn with_aligned(shape: &Shape, effect: usize, theta: &[f64], sigmas: &[f64]) -> Shape {
    let mut effects = shape.effects.clone();
    effects[effect] = effects[effect].aligned(&theta[shape.range_of(effect)], sigmas);
    shape.with_all(&effects)
}

/// The change of each parameter that moves some reading by one sample. `None` if the effect is not one of time, or its
/// readings are less than a sample late.
fn steps(case: &Case, effect: &FittedEffect, values: &[f64]) -> Option<Vec<f64>> {
    let dt_s = case.fit.iter().map(|run| run.dt_s).fold(f64::INFINITY, f64::min);
    let latest = |built: &dyn Effect, run: &Run| {
        let ends = [run.samples.first(), run.samples.last()].into_iter().flatten();
        let late = ends.map(|sample| built.lateness(sample.input.time_s));
        late.map(|late| late.v_s.abs().max(late.wheel_speed_s.abs())).fold(0.0, f64::max)
    };
    let of = |values: &[f64]| {
        let built = effect.build(values);
        case.fit.iter().map(|run| latest(&*built, run)).fold(0.0, f64::max)
    };
    if of(values) < dt_s {
        return None;
    }
    let step = |i: usize| {
        let alone = |value: f64| {
            let mut values: Vec<f64> =
                effect.parameters.iter().map(|p| 0.0_f64.clamp(p.lower, p.upper)).collect();
            values[i] = value;
            of(&values)
        };
        let scale = effect.parameters[i].scale;
        dt_s * scale / alone(scale).max(f64::MIN_POSITIVE)
    };
    Some((0..values.len()).map(step).collect())
}

/// A pattern search (Hooke and Jeeves) for the parameters of an aligned effect by the likelihood of the moved recordings, with a
/// frozen filter.
struct Search<'s> {
    original: &'s Case,
    last: usize,
    steps: Vec<f64>,
    sigmas: &'s [f64],
}

impl Search<'_> {
    /// Parameters that make the moved recordings more likely than those of `frozen`; `None` if none were found.
    fn along(&self, frozen: &FrozenFit, first: f64) -> Option<Vec<f64>> {
        let start = &frozen.fitted.fit.theta;
        let own = frozen.fitted.shape.range_of(self.last);
        let cost = |theta: &[f64]| {
            let shape = with_aligned(&frozen.fitted.shape, self.last, theta, self.sigmas);
            let late = lateness(&shape, theta)?;
            let moved = self.original.aligned(&late);
            Some(solver::cost_of(&frozen.whitening.residuals_of(&moved, &shape.build(theta)), OUTLIER_SIGMA))
        };
        let (mut best, mut least) = (start.clone(), cost(start)?);
        let mut step = first;
        for _ in 0..ROUNDS {
            let tries: Vec<Vec<f64>> = self
                .directions()
                .into_iter()
                .map(|direction| {
                    let mut theta = best.clone();
                    for (i, along) in own.clone().zip(direction) {
                        let p = &frozen.fitted.shape.parameters()[i];
                        theta[i] = (theta[i] + step * along).clamp(p.lower, p.upper);
                    }
                    theta
                })
                .collect();
            let costs: Vec<Option<f64>> = tries.par_iter().map(|theta| cost(theta)).collect();
            let tried = tries.into_iter().zip(costs).filter_map(|(theta, cost)| Some((theta, cost?)));
            match tried.min_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, cost)| *cost < least) {
                Some((theta, cost)) => (best, least) = (theta, cost),
                None if step > 1.0 => step *= 0.5,
                None => break,
            }
        }
        (best != *start).then_some(best)
    }

    /// Each parameter alone, and one against half of another: an offset against a drift.
    fn directions(&self) -> Vec<Vec<f64>> {
        let n = self.steps.len();
        let mut directions = Vec::new();
        for sign in [1.0, -1.0] {
            for i in 0..n {
                let mut alone = vec![0.0; n];
                alone[i] = sign * self.steps[i];
                for j in (0..n).filter(|j| *j != i) {
                    let mut against = alone.clone();
                    against[j] = -0.5 * sign * self.steps[j];
                    directions.push(against);
                }
                directions.push(alone);
            }
        }
        directions
    }
}
