//! Whether a further effect only takes up what the form of those before it leaves.

use crate::decide::criteria::Criteria;
use crate::decide::mending::Relation;
use crate::decide::round::Standpoint;
use crate::fit::frozen::{self, FrozenFit};
use crate::predict::disturbances::DisturbanceModel;

/// Whether `next`, whose last effect shows at no place of those before it, would gain next to nothing beside one of the `others`
/// that mends them and gains more: both then take up the same rest, which is one of form.
pub(crate) fn takes_up_form(
    at: &Standpoint,
    next: &FrozenFit,
    others: &[FrozenFit],
    disturbances: &DisturbanceModel,
    criteria: &Criteria,
) -> bool {
    if at.relation(next, criteria) != Some(Relation::Apart) {
        return false;
    }
    let gain = |frozen: &FrozenFit| at.current.evidence_cost() - frozen.evidence_cost();
    // Recordings that were put right for one of them are not those of the other.
    let mends = |other: &&FrozenFit| {
        std::ptr::eq(other.case, next.case)
            && at.relation(other, criteria) == Some(Relation::Mends)
            && gain(other) > gain(next)
    };
    let mender = others.iter().filter(mends).max_by(|a, b| gain(a).total_cmp(&gain(b)));
    let (Some(mender), Some(last)) = (mender, next.fitted.shape.effects.last()) else { return false };
    let shape = mender.fitted.shape.with(last);
    let own = next.fitted.fit.theta.get(next.fitted.shape.range_of_last()).unwrap_or_default();
    let start: Vec<f64> = mender.fitted.fit.theta.iter().chain(own).copied().collect();
    let both = frozen::freeze(next.case, &shape, disturbances, &start, mender.tolerance);
    mender.evidence_cost() - both.evidence_cost() < criteria.acceptance.beside_mending_share * gain(next)
}
