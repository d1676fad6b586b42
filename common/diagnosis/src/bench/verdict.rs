//! From scores to a verdict: named effects, something unknown, both, or nothing.

use super::chance::{Chance, Noise, standardised};
use super::flexible::{Group, Tangent, groups, residuals, union};
use super::points::{Covariate, Point};
use super::search::{Bench, FLEXIBLE_LEVEL, Found, LIBRARY_LEVEL, Trial};
use crate::answer::schema::Verdict;
use nalgebra::DVector;

/// What is left, in units of one degree of freedom a point, below which nobody needs to look: 0.14 sigma RMS.
const LEAST_MATERIAL: f64 = 0.02;

/// Share of the original excess that a right effect in a wrong form leaves at most.
const MOST_LEFT: f64 = 0.12;

/// Share above which what was found cannot be the cause.
const MOST_LEFT_AT_ALL: f64 = 0.5;

/// Share left at which a single variable outside the named effects is weighed against them.
const WEIGH_FROM: f64 = 0.04;

/// The verdict and what it rests on.
pub struct Judgement {
    /// The verdict.
    pub verdict: Verdict,
    /// Share of the excess that the extended model removes, of what a flexible discrepancy removes; 1 where there is none.
    pub recovered: f64,
    /// The flexible function that describes best what is missing.
    pub missing: Option<Group>,
    /// Score of the best flexible function on what the extended model leaves.
    pub rest_score: f64,
    /// The score that chance reaches with the level's probability.
    pub rest_threshold: f64,
}

/// Points of the curve of what is missing.
const CURVE_POINTS: usize = 41;

/// A flexible function and the squared error it would remove, less the price of its degrees of freedom.
struct Weighed {
    group: Group,
    gain: f64,
}

/// Judges what a search found.
pub fn judge(bench: &Bench<'_>, calibrated: &Trial, found: &Found) -> Judgement {
    let unit = bench.noise.unit();
    let points = bench.points;
    let rest = Rest::of(bench, &found.extended, 1000);
    let start = Rest::of(bench, calibrated, 1001);
    let excess = (start.energy() - points.len() as f64).max(1e-9);
    let left = (rest.explained - rest.freedom as f64).max(0.0);
    let share = left / excess.max(left);
    let structured = rest.p_value < FLEXIBLE_LEVEL && left / points.len() as f64 > LEAST_MATERIAL;
    let alarm = found.alone.iter().any(|scored| scored.p_value < LIBRARY_LEVEL) || structured;
    let (rest_score, rest_threshold) = (rest.score, rest.threshold);
    let judgement =
        |verdict, missing| Judgement { verdict, recovered: 1.0 - share, missing, rest_score, rest_threshold };
    if found.effects.is_empty() {
        let verdict = if structured && alarm { Verdict::Unknown } else { Verdict::None };
        let missing = rest.weighed.into_iter().next().map(|weighed| weighed.group);
        return judgement(verdict, missing.filter(|_| verdict == Verdict::Unknown));
    }
    let several = found.effects.len() > 1;
    if !several && (!structured || share < WEIGH_FROM) {
        return judgement(Verdict::Effects, None);
    }
    let named: Vec<Covariate> = found.effects.iter().map(|effect| effect.spec.covariate).collect();
    let removed = (calibrated.fit.cost - found.extended.fit.cost) / unit;
    let price = (points.len() as f64).ln();
    let own = found.extended.model.parameters().len() - calibrated.model.parameters().len();
    // One variable that explains more than all effects named is the simpler cause.
    let better = start.weighed.iter().find(|weighed| {
        !named.contains(&weighed.group.covariate)
            && weighed.group.covariate != Covariate::Sequence
            && weighed.group.second.is_none()
            && weighed.gain > removed - own as f64 * price + f64::max(10.0, 0.02 * excess)
    });
    if let Some(better) = better {
        return judgement(Verdict::Unknown, Some(better.group.clone()));
    }
    if !structured || share < WEIGH_FROM {
        return judgement(Verdict::Effects, None);
    }
    let best = |rest: Rest| rest.weighed.into_iter().next().map(|weighed| weighed.group);
    match share {
        share if share > MOST_LEFT_AT_ALL => judgement(Verdict::Unknown, best(start)),
        share if share > MOST_LEFT => judgement(Verdict::EffectsAndUnknown, best(rest)),
        _ => judgement(Verdict::Effects, None),
    }
}

/// What a model leaves, seen by the flexible functions.
struct Rest {
    residuals: DVector<f64>,
    unit: f64,
    /// Squared residuals that all functions together explain, in units of one degree of freedom.
    explained: f64,
    freedom: usize,
    /// Each function, best first.
    weighed: Vec<Weighed>,
    score: f64,
    threshold: f64,
    p_value: f64,
}

impl Rest {
    fn of(bench: &Bench<'_>, trial: &Trial, round: u64) -> Self {
        let (points, noise) = (bench.points, &bench.noise);
        let tangent = Tangent::of(&trial.model, points, &trial.fit.values, noise.sigma);
        let all = groups(bench.kind, points, &tangent);
        let chance = Chance::of(
            &trial.model,
            points,
            &trial.fit.values,
            noise,
            &[],
            &all,
            &tangent,
            &bench.nominal,
            bench.seed.wrapping_add(round),
        );
        let residuals = residuals(&trial.model, points, &trial.fit.values, noise.sigma);
        let unit = noise.unit();
        let whole = union(&all, &tangent, |_| false);
        let explained = whole.tr_mul(&residuals).norm_squared() / unit;
        let price = (points.len() as f64).ln();
        let mut score = f64::NEG_INFINITY;
        let mut weighed: Vec<Weighed> = all
            .into_iter()
            .filter_map(|group| {
                let columns = group.beyond(&tangent);
                let freedom = columns.ncols();
                if freedom == 0 {
                    return None;
                }
                let energy = columns.tr_mul(&residuals).norm_squared() / unit;
                score = score.max(standardised(energy, freedom));
                Some(Weighed { group, gain: energy - price * freedom as f64 })
            })
            .collect();
        weighed.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let (threshold, p_value) = (chance.flexible_threshold(FLEXIBLE_LEVEL), chance.p_flexible(score));
        Self { residuals, unit, explained, freedom: whole.ncols(), weighed, score, threshold, p_value }
    }

    fn energy(&self) -> f64 {
        self.residuals.norm_squared() / self.unit
    }
}

/// Curve of what is missing over the variable of `group`: x, value and standard error. The value is the missing share of the
/// level or the stiffness, or of the normal load.
pub fn missing_curve(group: &Group, trial: &Trial, points: &[Point], noise: &Noise) -> Vec<[f64; 3]> {
    let residuals = residuals(&trial.model, points, &trial.fit.values, noise.sigma);
    let scale = noise.unit().sqrt();
    let curve = group.curve(&residuals, points, CURVE_POINTS).unwrap_or_default();
    curve.into_iter().map(|[x, y, error]| [x, y, error * scale]).collect()
}
