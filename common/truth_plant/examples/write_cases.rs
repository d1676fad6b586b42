//! Writes labelled cases for development: every named effect once, then none, nameless ones and pairs.
//!
//! `cargo run --release -p railgrip-truth-plant --example write_cases -- DIR SEED [ID,ID+ID,none,...]`
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

use std::{path::PathBuf, time::Instant};

use railgrip_truth_plant::{Case, Recipe, departures::CATALOGUE, files};

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, folder, seed, rest @ ..] = arguments.as_slice() else {
        println!("usage: write_cases DIR SEED [ID,ID+ID,none,...]");
        return;
    };
    let (folder, seed) = (PathBuf::from(folder), seed.parse::<u64>().unwrap());
    let wanted: Vec<Vec<String>> = match rest.first() {
        Some(list) => list.split(',').map(ids).collect(),
        None => development_deck(),
    };
    let mut labels = Vec::new();
    for (index, departures) in wanted.into_iter().enumerate() {
        let start = Instant::now();
        let name = format!("case{index:02}");
        let recipe = Recipe { name: name.clone(), seed: seed.wrapping_add(index as u64 * 7919), departures };
        let case = Case::make(&recipe).unwrap();
        files::write_case(&folder.join(&name), &case.sheet.to_toml(), &case.runs).unwrap();
        files::write_truth(&folder.join(&name), &case.runs).unwrap();
        let label = &case.label;
        println!(
            "{name} {:8} {:40} fit {:6.2} floor {:5.2}  holdout {:6.2} floor {:5.2}  {:.1} s  {:?}",
            label.vehicle,
            recipe.departures.join("+"),
            label.gap_calibrated.fit,
            label.gap_without_the_effect.fit,
            label.gap_calibrated.holdout,
            label.gap_without_the_effect.holdout,
            start.elapsed().as_secs_f64(),
            label.effects.iter().map(|effect| &effect.parameters).collect::<Vec<_>>(),
        );
        labels.push(serde_json::json!({
            "case": label.case,
            "vehicle": label.vehicle,
            "effects": recipe.departures,
            "terms": label.effects.iter().map(|effect| effect.term.clone()).collect::<Vec<_>>(),
            "named": label.effects.iter().all(|effect| effect.named),
            "gap_calibrated": label.gap_calibrated,
            "gap_without_the_effect": label.gap_without_the_effect,
            "parameters_of_the_plant": label.effects.iter().map(|effect| effect.parameters.clone()).collect::<Vec<_>>(),
            "nuisances": format!("{:?}", case.nuisances),
        }));
    }
    files::write(&folder.join("labels.json"), &serde_json::to_string_pretty(&labels).unwrap()).unwrap();
}

fn ids(text: &str) -> Vec<String> {
    text.split('+').filter(|id| *id != "none").map(str::to_owned).collect()
}

fn development_deck() -> Vec<Vec<String>> {
    let mut deck: Vec<Vec<String>> =
        CATALOGUE.iter().filter(|kind| kind.named).map(|kind| ids(kind.id)).collect();
    deck.extend(vec![Vec::new(); 5]);
    let nameless = CATALOGUE.iter().filter(|kind| !kind.named);
    deck.extend(nameless.map(|kind| ids(kind.id)));
    deck.extend(
        ["brake_fade+wheel_radius", "grade+brake_friction_pressure", "falling_friction+speed_latency"]
            .map(ids),
    );
    deck
}
