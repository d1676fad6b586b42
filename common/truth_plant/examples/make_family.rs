//! Makes cases of the family and says what they are like and how fast they are made; writes them where a folder is given.
//!
//! `cargo run --release -p railgrip-truth-plant --example make_family -- CASES SEED a|b|c|d|all [DIR]`
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

use std::{path::PathBuf, time::Instant};

use railgrip_truth_plant::family::{FamilyCase, FormSet, Forms, family_deck};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [cases, seed, forms, folder @ ..] = arguments.as_slice() else {
        println!("usage: make_family CASES SEED a|b|c|d|all [DIR]");
        return;
    };
    let forms = match forms.as_str() {
        "a" => Forms::Only(FormSet::A),
        "b" => Forms::Only(FormSet::B),
        "c" => Forms::Only(FormSet::C),
        "d" => Forms::Only(FormSet::D),
        _ => Forms::All,
    };
    let (mut seconds, mut recorded_s) = (0.0, 0.0);
    let deck = family_deck(cases.parse().unwrap(), seed.parse().unwrap(), forms);
    for recipe in &deck {
        let start = Instant::now();
        let case = FamilyCase::make(recipe).unwrap();
        if let Some(folder) = folder.first() {
            case.write(&PathBuf::from(folder).join(&recipe.name), None).unwrap();
        }
        let took_s = start.elapsed().as_secs_f64();
        seconds += took_s;
        let (label, plant) = (&case.label, case.label.plant.as_ref().unwrap());
        recorded_s += plant.seconds;
        let effects = label.effects.iter().map(|e| format!("{} {} {:.2}", e.id, e.form, e.strength));
        println!(
            "{} {:17} {} {:22} {:18} {:5.1} t {:3} Hz {:2}+{} runs {:4.0} s {:22} fit {:7.2} / {:5.2} hold {:7.2} / {:5.2} x{:6.2} {:.2} s  {}",
            recipe.name,
            label.vehicle,
            plant.wheelsets,
            plant.creep_law,
            plant.integrator,
            plant.mass_kg / 1e3,
            plant.rate_hz,
            plant.fit_runs,
            plant.holdout_runs,
            plant.seconds,
            format!("{} {:.2}", plant.noise.join("+"), plant.noise_level),
            label.gap_calibrated.fit,
            label.gap_without_the_effect.fit,
            label.gap_calibrated.holdout,
            label.gap_without_the_effect.holdout,
            label.salience(),
            took_s,
            effects.collect::<Vec<_>>().join(", "),
        );
    }
    let count = deck.len() as f64;
    println!("{:.3} s a case, {:.0} s recorded", seconds / count, recorded_s / count);
}
