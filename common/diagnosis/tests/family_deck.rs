//! Thirty fixed cases of the family of plants, of all its forms, none chosen by what the diagnosis says of it: counts that
//! must not get worse. How good they are elsewhere is measured by `railgrip gap blind`, on cases that nobody has seen.
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use railgrip_diagnosis::answer::schema::{FoundEffect, Report, Verdict};
use railgrip_diagnosis::data::load;
use railgrip_diagnosis::wagon::{Options, diagnose};
use railgrip_truth_plant::FamilyRecipe;
use railgrip_truth_plant::family::{FamilyCase, Forms, family_deck};
use railgrip_truth_plant::label::LabelledEffect;
use railgrip_vehicle::effects;
use rayon::prelude::*;

/// Cases of the deck.
const CASES: usize = 30;
/// Of which so many hold two effects or three.
const SEVERAL: usize = 6;
/// Recipes among which they are sought.
const RECIPES: usize = 600;
const SEED: u64 = 2031;
/// Salience from which an effect can be seen.
const VISIBLE: f64 = 1.1;

/// What came out, counted: right of all.
#[derive(Debug, Default)]
struct Count {
    right: usize,
    of: usize,
}

impl Count {
    fn add(&mut self, right: bool) {
        self.of += 1;
        self.right += usize::from(right);
    }

    /// At most so many were wrong.
    fn misses_at_most(&self, most: usize) -> bool {
        self.of > 0 && self.of - self.right <= most
    }
}

/// Plants that keep the test short.
fn is_small(recipe: &FamilyRecipe) -> bool {
    let size = FamilyCase::size(recipe).expect("the plant knows its effects");
    size.wheelsets as f64 * size.rate_hz <= 100.0 && size.fit_runs <= 6
}

fn deck() -> Vec<FamilyCase> {
    let recipes = family_deck(RECIPES, SEED, Forms::All);
    let small = |several: bool, count: usize| {
        let wanted = move |recipe: &&FamilyRecipe| (recipe.effects.len() > 1) == several && is_small(recipe);
        recipes.iter().filter(wanted).take(count)
    };
    let small: Vec<&FamilyRecipe> = small(false, CASES - SEVERAL).chain(small(true, SEVERAL)).collect();
    let make = |recipe: &&FamilyRecipe| FamilyCase::make(recipe).expect("the plant knows its effects");
    small.par_iter().map(make).collect()
}

fn answer(case: &FamilyCase) -> Report {
    let folder = tempfile::tempdir().expect("a folder");
    let at = folder.path().join("case");
    case.write(&at, None).expect("the case is written");
    let vehicle = std::fs::read_to_string(at.join("vehicle.toml")).expect("vehicle.toml");
    let read = load::load(&at, toml::from_str(&vehicle).expect("a vehicle")).expect("a case");
    let options = Options { case: "deck".into(), seed: 1, ..Options::default() };
    diagnose(&read, &options, &|_| ()).report
}

/// Wind and resistance span the same model.
fn means(effect: &FoundEffect, id: &str) -> bool {
    let same = ["headwind", "running_resistance"];
    effect.id == id
        || effect.equivalent.iter().any(|other| other == id)
        || (same.contains(&effect.id.as_str()) && same.contains(&id))
}

#[test]
fn thirty_cases_are_answered_no_worse_than_before() {
    let deck = deck();
    assert_eq!(deck.len(), CASES, "small plants among {RECIPES}");
    let [mut quiet, mut one, mut several, mut showing, mut unknown] = [(); 5].map(|()| Count::default());
    let mut closures = Vec::new();
    let reports: Vec<Report> = deck.par_iter().map(answer).collect();
    for (case, report) in deck.iter().zip(&reports) {
        let label = &case.label;
        let named: Vec<&str> = label.effects.iter().map(|effect| effect.id.as_str()).collect();
        let known = named.iter().all(|id| effects::find(id).is_some());
        let says_unknown = matches!(report.verdict, Verdict::Unknown | Verdict::EffectsAndUnknown);
        let found = |id: &&str| report.effects.iter().any(|effect| means(effect, id));
        let visible = !named.is_empty() && label.salience() >= VISIBLE;
        let (gap, floor) = (&report.gap.holdout, label.gap_without_the_effect.holdout);
        let spare = report.effects.iter().any(|effect| !named.iter().any(|id| means(effect, id)));
        let right = match (visible, known, named.as_slice()) {
            (false, ..) => {
                let right = report.verdict == Verdict::None || (known && !spare && !says_unknown);
                quiet.add(right);
                right
            }
            (true, false, _) => {
                unknown.add(says_unknown);
                says_unknown
            }
            (true, true, [id]) => {
                let right = report.effects.first().is_some_and(|effect| means(effect, id));
                one.add(right);
                right
            }
            (true, true, ids) => {
                let right = ids.iter().filter(|id| found(id)).count() * 2 > ids.len();
                let shows = |effect: &&LabelledEffect| label.salience_of(effect) >= VISIBLE;
                for effect in label.effects.iter().filter(shows) {
                    showing.add(found(&effect.id.as_str()));
                }
                several.add(right);
                right
            }
        };
        if visible && !report.effects.is_empty() && gap.calibrated > 1.1 * floor {
            closures.push((gap.calibrated - gap.extended) / (gap.calibrated - floor));
        }
        println!(
            "{} {} salience {:.2} {named:?}: {} by {} {:?}, holdout {:.2} -> {:.2} over {floor:.2}, {:.1} s",
            if right { "ok   " } else { "WRONG" },
            label.case,
            label.salience(),
            report.verdict.name(),
            report.rule,
            report.effects.iter().map(|e| (e.id.as_str(), e.confidence)).collect::<Vec<_>>(),
            gap.calibrated,
            gap.extended,
            report.seconds,
        );
    }
    closures.sort_by(f64::total_cmp);
    let median = closures.get(closures.len() / 2).copied().unwrap_or(f64::NAN);
    let lower = closures.get(closures.len() / 10).copied().unwrap_or(f64::NAN);
    println!(
        "nothing to see {quiet:?}, one effect {one:?}, several {several:?}, their effects that show {showing:?}, unknown {unknown:?}"
    );
    println!("closure of {}: median {median:.2}, lower decile {lower:.2}", closures.len());
    // When the deck was drawn: one of 14, two of 8, two of 4 (unknown) and one of 5 (showing) wrong, closure 0.91 and 0.30. Counts may not
    // be worse, but for one of the showing.
    assert!(quiet.misses_at_most(1), "{quiet:?}");
    assert!(one.misses_at_most(2), "{one:?}");
    assert!(unknown.misses_at_most(2), "{unknown:?}");
    assert!(showing.misses_at_most(2), "{showing:?}");
    assert!(median >= 0.65 && lower >= 0.2, "{median:.2}, {lower:.2} of {}", closures.len());
}
