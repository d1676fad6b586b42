//! Sets of effects that may be at work: what stands in for a name, what is left without one, and the fewest that are likely enough.

use crate::answer::schema::{FoundEffect, PosteriorSet, Report};
use crate::decide::holds::Holds;
use serde::{Deserialize, Serialize};

/// Candidates that share what is left where no effect is named.
const CANDIDATES: usize = 3;

/// What is at work where a name is wrong; shares that add up to one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WhenWrong {
    /// One of the rivals that the report lists.
    pub rival: f64,
    /// Nothing in its place.
    pub nothing: f64,
    /// Something that is not listed.
    pub other: f64,
}

/// What may be at work in the place of one name, and how probable each is; what is not listed is left out.
pub(super) fn options(effect: &FoundEffect, right: f64, wrong: &WhenWrong) -> Vec<(Option<String>, f64)> {
    let near = |id: &str| effect.rivals.iter().find(|rival| rival.id == id).map_or(0.5, |rival| rival.share);
    // Ids that the data cannot tell from it share its probability by how near they came.
    let whole = 1.0 + effect.equivalent.iter().map(|id| near(id).clamp(0.0, 1.0)).sum::<f64>();
    let mut options = vec![(Some(effect.id.clone()), right / whole)];
    for id in &effect.equivalent {
        options.push((Some(id.clone()), right * near(id).clamp(0.0, 1.0) / whole));
    }
    let rivals = || effect.rivals.iter().filter(|rival| !effect.equivalent.contains(&rival.id));
    let weight = |share: f64| share.max(0.0).powi(2);
    let total: f64 = rivals().map(|rival| weight(rival.share)).sum();
    for rival in rivals().filter(|_| total > 0.0) {
        options.push((Some(rival.id.clone()), (1.0 - right) * wrong.rival * weight(rival.share) / total));
    }
    options.push((None, (1.0 - right) * wrong.nothing));
    options
}

/// Where nothing is named, candidates share what known effects have, each half of the one before it.
pub(super) fn without_names(report: &Report, holds: Holds) -> Vec<PosteriorSet> {
    let mut all = vec![
        PosteriorSet { effects: Vec::new(), unknown: false, p: holds.none },
        PosteriorSet { effects: Vec::new(), unknown: true, p: holds.unknown },
    ];
    let mut p = holds.known;
    for candidate in report.candidates.iter().take(CANDIDATES) {
        p *= 0.5;
        all.push(PosteriorSet { effects: vec![candidate.id.clone()], unknown: false, p });
    }
    all
}

/// Adds a set, to the same one where it is there already.
pub(super) fn add(all: &mut Vec<PosteriorSet>, set: PosteriorSet) {
    match all.iter_mut().find(|other| other.unknown == set.unknown && other.effects == set.effects) {
        Some(other) => other.p += set.p,
        None => all.push(set),
    }
}

/// Indices of the fewest sets whose probabilities add up to `level`; all of them if they do not.
pub(crate) fn fewest(sets: &[PosteriorSet], level: f64) -> Vec<usize> {
    let mut sum = 0.0;
    let mut taken = Vec::new();
    for (index, set) in sets.iter().enumerate() {
        if sum >= level {
            break;
        }
        sum += set.p;
        taken.push(index);
    }
    taken
}
