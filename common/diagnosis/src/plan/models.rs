//! Models between which a test is to decide.

use crate::answer::schema::{PosteriorSet, Report};
use crate::data::case::Case;
use crate::decide::criteria::Criteria;
use crate::decide::selection::Selection;
use crate::fit::candidate::Fitted;
use crate::fit::windows::Models;
use crate::model::parameters::Built;

/// Most effects whose models are tested one by one, and the least probability of one; effort.
const MOST_SINGLE: usize = 6;
const LEAST_SINGLE: f64 = 0.03;

/// A model as the recordings teach it.
pub(super) struct Model {
    /// Ids of its effects; empty for the calibrated model.
    pub(super) effects: Vec<String>,
    /// The model.
    pub(super) built: Built,
    /// The same tolerances without the effects.
    pub(super) bare: Built,
}

/// The calibrated model, that with all effects that were found, those with the likeliest effects one by one, and that of the nearest rival
/// however far it is, fitted on windows as the models of the report are.
pub(super) fn of(case: &Case, selection: &Selection, report: &Report, criteria: &Criteria) -> Vec<Model> {
    let thinned = case.thinned(criteria.report.rate_hz);
    let case = thinned.as_ref().unwrap_or(case);
    let calibrated = Models::calibrated(case, &selection.base.fitted);
    let model = |(effects, fitted): (Vec<String>, Option<&Fitted>)| {
        let Models { mut extended_shape, mut extended, .. } = calibrated.extended_by(case, fitted);
        let built = extended_shape.build(&extended);
        while !extended_shape.effects.is_empty() {
            (extended_shape, extended) = extended_shape.without(&extended, 0);
        }
        Model { effects, built, bare: extended_shape.build(&extended) }
    };
    to_fit(selection, report).into_iter().map(model).collect()
}

fn to_fit<'s>(selection: &'s Selection, report: &Report) -> Vec<(Vec<String>, Option<&'s Fitted>)> {
    let mut models: Vec<(Vec<String>, Option<&Fitted>)> = vec![(Vec::new(), None)];
    let found: Vec<String> = report.effects.iter().map(|effect| effect.id.clone()).collect();
    if !found.is_empty() {
        models.push((found, Some(&selection.best.fitted)));
    }
    let Some(round) = selection.rounds.first() else { return models };
    let singles = likely(&report.posterior).into_iter().map(|(id, _)| id).take(MOST_SINGLE);
    let nearest =
        report.effects.first().and_then(|effect| effect.rivals.first()).map(|rival| rival.id.clone());
    for id in singles.chain(nearest) {
        let effects = vec![id];
        if let Some(gain) = round.of(&effects[0])
            && models.iter().all(|(known, _)| *known != effects)
        {
            models.push((effects, Some(&gain.fitted)));
        }
    }
    models
}

/// Effects with the probability of all sets that hold them, the likeliest first, without those that are hardly likely.
fn likely(sets: &[PosteriorSet]) -> Vec<(String, f64)> {
    let mut all: Vec<(String, f64)> = Vec::new();
    for set in sets {
        for id in &set.effects {
            match all.iter_mut().find(|(known, _)| known == id) {
                Some((_, p)) => *p += set.p,
                None => all.push((id.clone(), set.p)),
            }
        }
    }
    all.retain(|(_, p)| *p >= LEAST_SINGLE);
    all.sort_by(|a, b| b.1.total_cmp(&a.1));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_tested_is_what_is_likely_over_all_sets() {
        let set = |effects: &[&str], unknown: bool, p: f64| {
            let effects = effects.iter().map(|id| (*id).to_owned()).collect();
            PosteriorSet { effects, unknown, p }
        };
        let sets = [
            set(&["a"], false, 0.5),
            set(&["a", "b"], false, 0.2),
            set(&["b"], true, 0.1),
            set(&["c"], false, 0.02),
        ];
        let ids: Vec<String> = likely(&sets).into_iter().map(|(id, _)| id).collect();
        assert_eq!(ids, ["a", "b"]);
    }
}
