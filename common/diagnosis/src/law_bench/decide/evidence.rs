//! Gathers the evidence for a verdict: what the extended model leaves, and what smooth discrepancies would explain instead of
//! the selected effects.

use super::chance::{Chance, standardised};
use super::selection::{Search, Selection};
use super::verdict::Evidence;
use crate::law_bench::data::point::Covariate;
use crate::law_bench::fit::fitted::FittedModel;
use crate::law_bench::model::discrepancy::{Discrepancy, Tangent, discrepancies, residuals, union};
use nalgebra::DVector;

/// Added to the seed for what the extended and what the calibrated model leave, so that both have random numbers of their own.
const EXTENDED_ROUND: u64 = 1000;
const CALIBRATED_ROUND: u64 = 1001;

/// The evidence, and the discrepancies behind it.
pub struct Gathered {
    /// What the verdict rests on.
    pub evidence: Evidence,
    /// The best discrepancy on top of the extended model.
    pub beside_effects: Option<Discrepancy>,
    /// The best discrepancy on top of the calibrated model.
    pub instead_of_effects: Option<Discrepancy>,
    /// The best discrepancy of a single variable without a selected effect, on top of the calibrated model.
    pub simpler_cause: Option<Discrepancy>,
    /// Score of the best discrepancy on what the extended model leaves.
    pub structure_score: f64,
    /// The score that chance reaches with the level's probability.
    pub structure_threshold: f64,
}

/// Gathers the evidence on a selection.
pub fn gather(search: &Search<'_>, calibrated: &FittedModel, selection: &Selection) -> Gathered {
    let points = search.points.len() as f64;
    let after = Remainder::of(search, &selection.extended, EXTENDED_ROUND);
    let before = Remainder::of(search, calibrated, CALIBRATED_ROUND);
    let excess = (before.energy - points).max(1e-9);
    let left = (after.explained - after.freedom as f64).max(0.0);
    let named: Vec<Covariate> = selection.effects.iter().map(|effect| effect.spec.covariate).collect();
    let simpler = before.weighed.iter().find(|weighed| {
        let one = &weighed.discrepancy;
        !named.contains(&one.covariate) && one.covariate != Covariate::Sequence && one.second.is_none()
    });
    let removed = (calibrated.fit.cost - selection.extended.fit.cost) / search.noise.unit();
    let own = selection.extended.model.parameters().len() - calibrated.model.parameters().len();
    let gained = removed - own as f64 * points.ln();
    let evidence = Evidence {
        effects: selection.effects.len(),
        structure_p: after.p_value,
        structure_per_point: left / points,
        share_left: left / excess.max(left),
        excess,
        simpler_lead: simpler.map_or(f64::NEG_INFINITY, |weighed| weighed.gain - gained),
    };
    let first = |remainder: &Remainder| remainder.weighed.first().map(|weighed| weighed.discrepancy.clone());
    Gathered {
        evidence,
        beside_effects: first(&after),
        instead_of_effects: first(&before),
        simpler_cause: simpler.map(|weighed| weighed.discrepancy.clone()),
        structure_score: after.score,
        structure_threshold: after.threshold,
    }
}

/// A discrepancy and the squared error it would remove, less the price of its degrees of freedom.
struct Weighed {
    discrepancy: Discrepancy,
    gain: f64,
}

/// What a model leaves, seen by the smooth discrepancies; energies in units of one degree of freedom.
struct Remainder {
    /// Squared residuals.
    energy: f64,
    /// What all discrepancies together explain of them.
    explained: f64,
    freedom: usize,
    /// Each discrepancy, best first.
    weighed: Vec<Weighed>,
    /// Score of the best one, what chance reaches with the level's probability, and how likely chance reaches the score.
    score: f64,
    threshold: f64,
    p_value: f64,
}

impl Remainder {
    fn of(search: &Search<'_>, fitted: &FittedModel, round: u64) -> Self {
        let (points, noise) = (search.points, &search.noise);
        let tangent = Tangent::of(&fitted.model, points, &fitted.fit.values, noise.sigma);
        let all = discrepancies(search.kind, points, &tangent);
        let supposed = search.supposed(fitted, &tangent);
        let chance = Chance::of(&supposed, &[], &all, search.criteria, search.seed.wrapping_add(round));
        let residuals = residuals(&fitted.model, points, &fitted.fit.values, noise.sigma);
        let unit = noise.unit();
        let whole = union(&all, &tangent, |_| false);
        let explained = whole.tr_mul(&residuals).norm_squared() / unit;
        let (weighed, score) = weigh(all, &tangent, &residuals, unit);
        let level = search.criteria.structure_level;
        Self {
            energy: residuals.norm_squared() / unit,
            explained,
            freedom: whole.ncols(),
            weighed,
            score,
            threshold: chance.structure_threshold(level),
            p_value: chance.p_structure(score),
        }
    }
}

/// The discrepancies with what each would remove, best first, and the best score among them.
fn weigh(
    all: Vec<Discrepancy>,
    tangent: &Tangent,
    residuals: &DVector<f64>,
    unit: f64,
) -> (Vec<Weighed>, f64) {
    let price = (residuals.len() as f64).ln();
    let mut score = f64::NEG_INFINITY;
    let mut weighed: Vec<Weighed> = all
        .into_iter()
        .filter_map(|discrepancy| {
            let columns = discrepancy.beyond(tangent);
            let freedom = columns.ncols();
            if freedom == 0 {
                return None;
            }
            let energy = columns.tr_mul(residuals).norm_squared() / unit;
            score = score.max(standardised(energy, freedom));
            Some(Weighed { discrepancy, gain: energy - price * freedom as f64 })
        })
        .collect();
    weighed.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    (weighed, score)
}
