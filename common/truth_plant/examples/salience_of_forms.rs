//! How far every form of every effect shows: median salience over some vehicles, at three sizes.
//!
//! `cargo run --release -p railgrip-truth-plant --example salience_of_forms -- VEHICLES [ID or letter of a set]`
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

use railgrip_truth_plant::family::{EFFECTS, FamilyCase, FamilyRecipe, OrderedEffect};

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let vehicles: u64 = arguments.first().and_then(|count| count.parse().ok()).unwrap_or(3);
    let wanted =
        |id: &str, set: char| arguments.get(1).is_none_or(|only| *only == id || *only == set.to_string());
    for effect in &EFFECTS {
        for form in effect.forms.iter().filter(|form| wanted(effect.id, form.set.letter())) {
            let median = |strength: f64| {
                let salience = |seed: u64| {
                    let ordered = OrderedEffect {
                        id: effect.id.to_owned(),
                        form: Some(form.name.to_owned()),
                        strength,
                    };
                    let recipe = FamilyRecipe {
                        name: String::new(),
                        seed: 1000 + seed,
                        set: form.set,
                        effects: vec![ordered],
                    };
                    FamilyCase::make(&recipe).unwrap().label.salience()
                };
                let mut all: Vec<f64> = (0..vehicles).map(salience).collect();
                all.sort_by(f64::total_cmp);
                all[all.len() / 2]
            };
            println!(
                "{:40} {:28} {} {:7.2} {:7.2} {:7.2}",
                effect.id,
                form.name,
                form.set.letter(),
                median(0.1),
                median(1.0),
                median(2.5)
            );
        }
    }
}
