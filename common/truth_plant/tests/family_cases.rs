//! Cases of the family: reproducible, of every kind, in the form of the contract.

use std::collections::{BTreeMap, BTreeSet};

use railgrip_truth_plant::family::{
    EFFECTS, FamilyCase, FamilyRecipe, FormSet, Forms, OrderedEffect, family_deck, recording,
};

fn recipe(seed: u64, set: FormSet, effects: &[(&str, f64)]) -> FamilyRecipe {
    let ordered = |(id, strength): &(&str, f64)| OrderedEffect {
        id: (*id).to_owned(),
        form: None,
        strength: *strength,
    };
    FamilyRecipe { name: format!("case{seed}"), seed, set, effects: effects.iter().map(ordered).collect() }
}

/// The first seed whose vehicle has so many wheelsets.
fn with_wheelsets(wheelsets: usize) -> FamilyCase {
    (0..40)
        .map(|seed| FamilyCase::make(&recipe(seed, FormSet::B, &[])).expect("no effect, no mistake"))
        .find(|case| case.sheet.wheelsets == wheelsets)
        .expect("a vehicle of both kinds within forty")
}

#[test]
fn every_effect_has_a_form_in_every_set() {
    let mut ids = BTreeSet::new();
    for effect in &EFFECTS {
        assert!(ids.insert(effect.id), "{} comes twice", effect.id);
        assert!(effect.forms.len() >= 4);
        for set in FormSet::EVERY {
            assert!(
                effect.forms_of(set).next().is_some(),
                "{} has no form in set {}",
                effect.id,
                set.letter()
            );
        }
        let names: BTreeSet<&str> = effect.forms.iter().map(|form| form.name).collect();
        assert_eq!(names.len(), effect.forms.len(), "{}: two forms of one name", effect.id);
    }
}

#[test]
fn the_same_recipe_gives_the_same_bytes() {
    for seed in 0..4 {
        let order =
            recipe(seed, FormSet::EVERY[seed as usize], &[("brake_fade", 1.0), ("wheel_radius", 0.4)]);
        let (first, second) = (FamilyCase::make(&order).unwrap(), FamilyCase::make(&order).unwrap());
        assert_eq!(first.label, second.label);
        assert_eq!(first.sheet.to_toml(), second.sheet.to_toml());
        for (run, again) in first.runs.iter().zip(&second.runs) {
            assert_eq!(recording(&first.sheet, run), recording(&second.sheet, again));
        }
        let other = FamilyCase::make(&FamilyRecipe { seed: seed + 100, ..order }).unwrap();
        assert_ne!(recording(&first.sheet, &first.runs[0]), recording(&other.sheet, &other.runs[0]));
    }
}

#[test]
fn a_deck_holds_all_kinds_in_the_sets_that_were_asked_for() {
    let deck = family_deck(400, 5, Forms::Only(FormSet::B));
    assert!(deck.iter().all(|recipe| recipe.set == FormSet::B));
    let count = |effects: usize| deck.iter().filter(|recipe| recipe.effects.len() == effects).count();
    assert_eq!((count(0), count(2), count(3)), (60, 52, 20));
    let mut times: BTreeMap<&str, usize> = BTreeMap::new();
    for effect in deck.iter().filter(|recipe| recipe.effects.len() == 1).map(|recipe| &recipe.effects[0]) {
        *times.entry(&effect.id).or_default() += 1;
    }
    assert_eq!(times.len(), EFFECTS.len(), "every effect alone");
    let strengths: Vec<f64> =
        deck.iter().flat_map(|recipe| &recipe.effects).map(|effect| effect.strength).collect();
    let below = |bound: f64| strengths.iter().filter(|s| **s < bound).count() as f64 / strengths.len() as f64;
    println!("below 0.1: {:.2}, below 0.35: {:.2}, below 1: {:.2}", below(0.1), below(0.35), below(1.0));
    assert!((below(0.35) - 0.5).abs() < 0.08, "half of all sizes below the geometric mean");
    let sets: BTreeSet<FormSet> =
        family_deck(60, 5, Forms::All).into_iter().map(|recipe| recipe.set).collect();
    assert_eq!(sets, BTreeSet::from(FormSet::ALL), "forms d come only where they are asked for");
    let judging = family_deck(60, 5, Forms::Only(FormSet::D));
    assert!(judging.iter().all(|recipe| recipe.set == FormSet::D));
    let names: BTreeSet<u64> = deck.iter().map(|recipe| recipe.seed).collect();
    assert_eq!(names.len(), deck.len(), "every case has a seed of its own");
}

#[test]
fn a_label_says_what_the_plant_was() {
    let case = FamilyCase::make(&recipe(4, FormSet::C, &[("falling_friction", 1.2)])).unwrap();
    let plant = case.label.plant.as_ref().unwrap();
    assert_eq!((plant.set.as_str(), case.label.effects[0].set.as_str()), ("c", "c"));
    assert!(["tail_rises_again", "bell"].contains(&case.label.effects[0].form.as_str()));
    assert!(["quartic_and_hyperbola", "root_and_hyperbola"].contains(&plant.creep_law.as_str()));
    assert_eq!(plant.fit_runs + plant.holdout_runs, case.runs.len());
    assert!((3..=13).contains(&case.runs.len()));
    let size = FamilyCase::size(&recipe(4, FormSet::C, &[("falling_friction", 1.2)])).unwrap();
    let told = (size.wheelsets, size.rate_hz, size.fit_runs);
    assert_eq!(told, (plant.wheelsets, plant.rate_hz, plant.fit_runs), "told without making the case");
}

/// A strong effect hides a weak one beside it: each is told by what the case would show without it.
#[test]
fn a_label_says_how_far_each_of_several_shows() {
    let case =
        FamilyCase::make(&recipe(4, FormSet::A, &[("wheel_radius", 2.0), ("mass_error", 0.05)])).unwrap();
    let label = &case.label;
    let [radius, mass] = [0, 1].map(|k| label.salience_of(&label.effects[k]));
    println!(
        "both {:.2}, the radius beside the mass {radius:.2}, the mass beside the radius {mass:.2}",
        label.salience()
    );
    assert!(radius > 1.5 && mass < 1.02);
    let alone = FamilyCase::make(&recipe(4, FormSet::A, &[("wheel_radius", 2.0)])).unwrap().label;
    assert!(alone.effects[0].gap_without.is_none());
    assert_eq!(alone.salience_of(&alone.effects[0]), alone.salience());
    let without = label.effects[1].gap_without.unwrap();
    assert!(
        (without.fit / alone.gap_calibrated.fit - 1.0).abs() < 0.01,
        "without the mass the radius is alone"
    );
}

#[test]
fn recordings_are_in_the_form_of_the_contract() {
    for wheelsets in [2, 4] {
        let case = with_wheelsets(wheelsets);
        let folder = tempfile::tempdir().unwrap();
        case.write(folder.path(), None).unwrap();
        let vehicle = std::fs::read_to_string(folder.path().join("vehicle.toml")).unwrap();
        assert_eq!(vehicle.contains("wheelset_positions_m"), wheelsets == 4);
        assert_eq!(vehicle.contains("[bogie]\nwheelbase_m"), wheelsets == 4);
        assert!(vehicle.contains("mass_sigma") && vehicle.contains("sample_rate_hz"));
        for run in &case.runs {
            let text = recording(&case.sheet, run);
            let mut lines = text.lines();
            let header: Vec<&str> = lines.next().unwrap().split(',').collect();
            let wheels: &[&str] = if wheelsets == 2 { &["f", "r"] } else { &["1", "2", "3", "4"] };
            assert_eq!(header[..2], ["t_s", "v_m_s"]);
            for (place, wheel) in wheels.iter().enumerate() {
                assert_eq!(header[2 + place], format!("omega_{wheel}_rad_s"));
                assert_eq!(header[2 + wheelsets + place], format!("f_perp_{wheel}_n"));
            }
            assert_eq!(header.contains(&"position_m"), case.sheet.has_position);
            assert_eq!(header.iter().any(|name| name.starts_with("m_w_")), case.sheet.is_motored());
            let mut before_s = f64::NEG_INFINITY;
            for line in lines {
                let cells: Vec<&str> = line.split(',').collect();
                assert_eq!(cells.len(), header.len());
                let time_s: f64 = cells[0].parse().unwrap();
                assert!(time_s > before_s);
                before_s = time_s;
            }
        }
    }
}

#[test]
fn a_plant_without_effect_is_as_good_as_its_sensors_tell() {
    let floors: Vec<f64> = (0..24)
        .map(|seed| {
            let case = FamilyCase::make(&recipe(seed, FormSet::EVERY[seed as usize % 4], &[])).unwrap();
            assert_eq!(case.label.gap_calibrated, case.label.gap_without_the_effect);
            assert!((case.label.salience() - 1.0).abs() < 1e-12);
            case.label.gap_without_the_effect.fit
        })
        .collect();
    println!("floors {floors:.2?}");
    assert!(floors.iter().all(|floor| (0.9..8.0).contains(floor)));
}

#[test]
fn a_wrong_recipe_is_refused_by_name() {
    let error = FamilyCase::make(&recipe(1, FormSet::A, &[("brake_fad", 1.0)])).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("brake_fad"));
    let mut order = recipe(1, FormSet::A, &[("brake_fade", 1.0)]);
    order.effects[0].form = Some("sudden".into());
    let error = FamilyCase::make(&order).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("sudden") && error.contains("saturating"), "{error}");
}
