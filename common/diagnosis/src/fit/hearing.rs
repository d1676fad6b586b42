//! How noisy the sensors are: level and colour that make the recordings most likely under the calibrated model.
//!
//! A vehicle file tells one standard deviation a sensor. Noise that is stronger, or whose errors last for tenths of a second,
//! makes innovations of a right model look like an effect. The filter knows what pads, wind and torque do to the speeds, so
//! its likelihood tells noise from motion, which the recordings alone do not.

use crate::data::case::{Case, OUTPUTS, Run};
use crate::data::noise::SensorNoise;
use crate::decide::criteria::Hearing;
use crate::fit::frozen::FrozenFit;
use crate::fit::objective::Whitening;
use crate::fit::solver;
use crate::predict::disturbances::{DisturbanceModel, OUTLIER_SIGMA};
use rayon::prelude::*;

/// Outputs that share a kind of sensor: the vehicle's speed, the wheelsets' speeds.
const KINDS: [std::ops::Range<usize>; 2] = [0..1, 1..OUTPUTS];
/// Levels that are tried, relative to what the vehicle file says.
const LEVELS: [f64; 6] = [0.85, 1.0, 1.12, 1.25, 1.4, 1.6];
/// Shares of the variance that is coloured.
const SHARES: [f64; 3] = [0.3, 0.6, 0.85];
/// Correlation times of the coloured part, s.
const TIMES_S: [f64; 3] = [0.07, 0.15, 0.3];

/// The noise of each output that makes the recordings most likely under `model`; `None` if that does not make them more likely
/// than `base` is with the noise of the case.
pub(crate) fn listen(
    model: &FrozenFit,
    base: &FrozenFit,
    criteria: &Hearing,
) -> Option<[SensorNoise; OUTPUTS]> {
    let case = some_of(base.case, criteria.samples);
    let with = |frozen: &FrozenFit, noise: &[SensorNoise; OUTPUTS]| {
        let built = frozen.fitted.shape.build(&frozen.fitted.fit.theta);
        let disturbances = DisturbanceModel::default().tolerant(frozen.tolerance);
        let heard = Case { noise: *noise, ..case.clone() };
        let whitening = Whitening::new(&heard, &built, &disturbances);
        let residuals = whitening.residuals_of(&heard, &built);
        solver::cost_of(&residuals, OUTLIER_SIGMA) + whitening.half_log_determinant()
    };
    let cost = |noise: &[SensorNoise; OUTPUTS]| with(model, noise);
    let first = with(base, &case.noise);
    let (mut best, mut least) = (case.noise, cost(&case.noise));
    // The kinds of sensors hardly know of each other: twice around is enough, once where that changed nothing.
    for _ in 0..2 {
        let before = best;
        for kind in KINDS {
            for options in [levels, colours] {
                let tries: Vec<[SensorNoise; OUTPUTS]> = options(&case, &best, &kind);
                let costs: Vec<f64> = tries.par_iter().map(cost).collect();
                let tried = tries.into_iter().zip(costs).filter(|(_, cost)| cost.is_finite());
                if let Some((noise, cost)) = tried.min_by(|a, b| a.1.total_cmp(&b.1))
                    && cost < least - criteria.least_gain
                {
                    (best, least) = (noise, cost);
                }
            }
        }
        if best == before {
            break;
        }
    }
    (first - least > criteria.least_gain).then_some(best)
}

/// The noise with one kind of sensors at each level.
fn levels(
    case: &Case,
    noise: &[SensorNoise; OUTPUTS],
    kind: &std::ops::Range<usize>,
) -> Vec<[SensorNoise; OUTPUTS]> {
    let file = SensorNoise::of_file(&case.vehicle.sensors);
    let at = |level: f64| {
        let mut noise = *noise;
        for j in kind.clone() {
            let factor = level * file[j].level() / noise[j].level();
            noise[j].white *= factor;
            noise[j].coloured *= factor;
        }
        noise
    };
    LEVELS.iter().map(|level| at(*level)).collect()
}

/// The noise with one kind of sensors in each colour, at its level.
fn colours(
    _: &Case,
    noise: &[SensorNoise; OUTPUTS],
    kind: &std::ops::Range<usize>,
) -> Vec<[SensorNoise; OUTPUTS]> {
    let of = |share: f64, time_s: f64| {
        let mut noise = *noise;
        for j in kind.clone() {
            let level = noise[j].level();
            noise[j] =
                SensorNoise { white: level * (1.0 - share).sqrt(), coloured: level * share.sqrt(), time_s };
        }
        noise
    };
    SHARES.iter().flat_map(|share| TIMES_S.map(|time_s| of(*share, time_s))).collect()
}

/// The case with as many of its runs to fit on as hold so many samples, at least one.
fn some_of(case: &Case, samples: usize) -> Case {
    let mut count = 0;
    let enough = |run: &&Run| {
        let taken = count == 0 || count + run.len() <= samples;
        count += if taken { run.len() } else { 0 };
        taken
    };
    let fit: Vec<Run> = case.fit.iter().filter(enough).cloned().collect();
    Case { fit, holdout: Vec::new(), noise: case.noise, notes: Vec::new(), vehicle: case.vehicle.clone() }
}
