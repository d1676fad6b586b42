//! What a test run says of what a diagnosis left open.

use super::designed::WORTH_SAYING;
use super::models::{self, Model};
use crate::answer::schema::{PosteriorSet, Report, Verdict};
use crate::data::case::Case;
use crate::decide::criteria::Criteria;
use crate::decide::posterior::Calibration;
use crate::decide::selection::Selection;
use crate::decide::sets::fewest;
use crate::decide::test_run::{TestRun, Tested, not_listed};
use crate::predict::disturbances::DisturbanceModel;
use crate::predict::natural;
use crate::predict::open_loop::{self, Tally, sigmas};
use railgrip_vehicle::effects;
use serde::Serialize;

/// The answer after a test.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Settled {
    /// What is likeliest now.
    pub verdict: Verdict,
    /// Effects that are likelier than not, the surest first; one that is likelier than none at all in any case.
    pub effects: Vec<SettledEffect>,
    /// Sets of effects and their probabilities after the test, the likeliest first.
    pub posterior: Vec<PosteriorSet>,
    /// Indices of the sets that hold the truth in nine of ten cases.
    pub verdict_set: Vec<usize>,
    /// The same sets before it.
    pub before: Vec<PosteriorSet>,
    /// Gap of the whole test by model, sensor sigmas, in the order of `test.models`.
    pub gaps: Vec<f64>,
    /// The gap that a right model would leave.
    pub natural: f64,
    /// What the models did, window by window.
    pub test: TestRun,
    /// The same in words.
    pub words: String,
}

/// An effect that is named after a test.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SettledEffect {
    /// Id in the catalogue.
    pub id: String,
    /// Term of the equations where it acts.
    pub term: String,
    /// Probability that it, or what the report calls equivalent, is at work.
    pub confidence: f64,
    /// Ids that the data cannot tell from it.
    pub equivalent: Vec<String>,
}

/// Lets the models of a diagnosis of `case` predict the fitted runs of `test`, which it has not seen.
pub(crate) fn settle(
    (case, test): (&Case, &Case),
    selection: &Selection,
    report: &Report,
    seed: u64,
    criteria: &Criteria,
) -> Settled {
    let sigma = sigmas(&case.vehicle.sensors);
    let models = models::of(case, selection, report, criteria);
    let predicted = |model: &Model| -> Vec<Tally> {
        test.fit.iter().flat_map(|run| open_loop::tallies(&model.built, run, &sigma)).collect()
    };
    let tallies: Vec<Vec<Tally>> = models.iter().map(predicted).collect();
    let like_heard = Case { noise: case.noise, ..test.clone() };
    let right =
        natural::tallies(&like_heard, &test.fit, &models[0].built, &DisturbanceModel::default(), seed);
    let gaps = tallies.iter().map(|tallies| Tally::total(tallies).gap()).collect();
    let windows = |tallies: &[Tally]| tallies.iter().map(Tally::gap).collect();
    let of_windows =
        right.chunks(natural::REPLICATES as usize).map(|replicates| Tally::total(replicates).gap());
    let run = TestRun {
        natural: of_windows.collect(),
        models: models
            .iter()
            .zip(&tallies)
            .map(|(model, tallies)| Tested { effects: model.effects.clone(), windows: windows(tallies) })
            .collect(),
    };
    let calibration = Calibration::shipped();
    let mut posterior = run.reweigh(&report.posterior, &calibration.tests);
    posterior.sort_by(|a, b| b.p.total_cmp(&a.p));
    let (verdict, effects) = answer(&posterior, report);
    let mut settled = Settled {
        verdict,
        effects,
        verdict_set: fewest(&posterior, calibration.set_level),
        posterior,
        before: report.posterior.clone(),
        gaps,
        natural: Tally::total(&right).gap(),
        test: run,
        words: String::new(),
    };
    settled.words = words(&settled);
    if test.fit.iter().any(|run| case.fit.iter().all(|known| known.rail != run.rail)) {
        settled.words += " Part of the test was made on rail of which there is no recording: its adhesion is the vehicle file's.";
    }
    if case.is_coupled() {
        settled.words +=
            " The wagon is coupled: most of these gaps are forces of its couplers, and the test says little.";
    }
    settled
}

/// Names what is likelier than not, and the surest effect if it is likelier than none and than something unknown alone.
fn answer(posterior: &[PosteriorSet], report: &Report) -> (Verdict, Vec<SettledEffect>) {
    let mass = |is: &dyn Fn(&PosteriorSet) -> bool| -> f64 {
        posterior.iter().filter(|set| is(set)).map(|set| set.p).sum()
    };
    let none = mass(&|set| set.effects.is_empty() && !set.unknown);
    let unknown_alone = mass(&|set| set.effects.is_empty() && set.unknown);
    let mut all: Vec<(f64, SettledEffect)> = Vec::new();
    for id in posterior.iter().flat_map(|set| &set.effects) {
        if all.iter().any(|(_, known)| known.id == *id) {
            continue;
        }
        let equivalent = equivalents(id, report);
        let is_it =
            |set: &PosteriorSet| set.effects.iter().any(|other| other == id || equivalent.contains(other));
        let confidence = mass(&is_it);
        let own = mass(&|set| set.effects.contains(id));
        let term = effects::find(id).map(|(spec, _)| spec.term.name().to_owned()).unwrap_or_default();
        all.push((own, SettledEffect { id: id.clone(), term, confidence, equivalent }));
    }
    // Of those that the data cannot tell apart the likeliest stands for all.
    all.sort_by(|(own_a, a), (own_b, b)| b.confidence.total_cmp(&a.confidence).then(own_b.total_cmp(own_a)));
    let mut named: Vec<SettledEffect> = Vec::new();
    for (_, effect) in all {
        let is_sure = effect.confidence > 0.5;
        let is_surest = named.is_empty() && effect.confidence >= none.max(unknown_alone);
        if (is_sure || is_surest) && named.iter().all(|known| !known.equivalent.contains(&effect.id)) {
            named.push(effect);
        }
    }
    let unknown = mass(&|set| set.unknown);
    let verdict = match named.is_empty() {
        true if unknown > none => Verdict::Unknown,
        true => Verdict::None,
        false if unknown > 0.5 => Verdict::EffectsAndUnknown,
        false => Verdict::Effects,
    };
    (verdict, named)
}

/// Ids that a report calls equivalent to one.
fn equivalents(id: &str, report: &Report) -> Vec<String> {
    let groups = report
        .effects
        .iter()
        .map(|effect| [std::slice::from_ref(&effect.id), effect.equivalent.as_slice()].concat());
    let others = groups.filter(|group| group.iter().any(|one| one == id)).flatten();
    let mut others: Vec<String> = others.filter(|other| other != id).collect();
    others.sort();
    others.dedup();
    others
}

/// The answer in words: what each model left, and what became of the sets.
fn words(settled: &Settled) -> String {
    let named = |effects: &[String]| match effects {
        [] => "tolerances alone".to_owned(),
        some => some.join(" and ").replace('_', " "),
    };
    let set = |set: &PosteriorSet| match (set.effects.as_slice(), set.unknown) {
        ([], true) => "something unknown".to_owned(),
        (effects, true) => format!("{} and something unknown", named(effects)),
        (effects, false) => named(effects),
    };
    let mut models: Vec<(&Tested, f64)> =
        settled.test.models.iter().zip(settled.gaps.iter().copied()).collect();
    models.sort_by(|a, b| a.1.total_cmp(&b.1));
    let left = models.iter().map(|(model, gap)| format!("{} {gap:.2}", named(&model.effects)));
    let moved = settled.posterior.iter().take(4).map(|after| {
        let same =
            |before: &&PosteriorSet| before.effects == after.effects && before.unknown == after.unknown;
        let before = settled.before.iter().find(same).map_or(0.0, |before| before.p);
        format!("{} {before:.2} to {:.2}", set(after), after.p)
    });
    let [before, after] = [&settled.before, &settled.posterior].map(|sets| not_listed(sets));
    let others =
        (before.max(after) >= WORTH_SAYING).then(|| format!("what is not listed {before:.2} to {after:.2}"));
    format!(
        "Gap of the test in sensor sigmas, predicted with what the recordings before it taught: {}; a right model would leave about {:.2}. \
         Probabilities: {}.",
        left.collect::<Vec<String>>().join(", "),
        settled.natural,
        moved.chain(others).collect::<Vec<String>>().join(", "),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::decide::posterior::tests::{named, report};

    fn set(effects: &[&str], unknown: bool, p: f64) -> PosteriorSet {
        PosteriorSet { effects: effects.iter().map(|id| (*id).to_owned()).collect(), unknown, p }
    }

    #[test]
    fn what_is_likelier_than_not_is_named_and_equivalents_once() {
        let mut found = named("brake_fade", 1.0, &[]);
        found.equivalent = vec!["cast_iron".to_owned()];
        let report = report(Verdict::Effects, vec![found]);
        let of = |sets: &[PosteriorSet]| {
            let (verdict, effects) = answer(sets, &report);
            (verdict, effects.iter().map(|effect| effect.id.clone()).collect::<Vec<String>>())
        };
        let sets = [
            set(&["cast_iron"], false, 0.4),
            set(&["brake_fade", "grade"], false, 0.3),
            set(&[], true, 0.2),
            set(&[], false, 0.1),
        ];
        assert_eq!(of(&sets), (Verdict::Effects, vec!["cast_iron".to_owned()]));
        // The surest one, though less likely than not; beside something unknown; not where that alone is likelier.
        let one = |p: f64, beside: bool| {
            [set(&["grade"], beside, p), set(&[], true, 0.9 - p), set(&[], false, 0.1)]
        };
        assert_eq!(of(&one(0.46, false)), (Verdict::Effects, vec!["grade".to_owned()]));
        assert_eq!(of(&one(0.6, true)), (Verdict::EffectsAndUnknown, vec!["grade".to_owned()]));
        assert_eq!(of(&one(0.4, false)), (Verdict::Unknown, Vec::new()));
        assert_eq!(of(&[set(&[], false, 0.6), set(&["grade"], false, 0.4)]), (Verdict::None, Vec::new()));
        assert_eq!(of(&[]), (Verdict::None, Vec::new()));
    }

    #[test]
    fn words_tell_gaps_and_what_became_of_the_sets() {
        let model = |effects: &[&str]| Tested {
            effects: effects.iter().map(|id| (*id).to_owned()).collect(),
            windows: Vec::new(),
        };
        let settled = Settled {
            verdict: Verdict::Effects,
            effects: Vec::new(),
            posterior: vec![set(&["head_wind"], false, 0.9), set(&[], true, 0.08)],
            verdict_set: vec![0],
            before: vec![set(&["head_wind"], false, 0.4), set(&[], true, 0.5)],
            gaps: vec![4.0, 1.5],
            natural: 1.1,
            test: TestRun { models: vec![model(&[]), model(&["head_wind"])], natural: Vec::new() },
            words: String::new(),
        };
        let words = words(&settled);
        println!("{words}");
        assert!(
            words.contains("head wind 1.50, tolerances alone 4.00; a right model would leave about 1.10")
        );
        let moved =
            "head wind 0.40 to 0.90, something unknown 0.50 to 0.08, what is not listed 0.10 to 0.02.";
        assert!(words.ends_with(moved), "{words}");
    }
}
