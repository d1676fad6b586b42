//! Runs trains and says what they were like; with a folder, writes them there.
//!
//! `cargo run --release -p railgrip-truth-plant --example write_trains -- SEED COUNT HOURS [FAULT|any|none] [DIR]`
#![allow(clippy::print_stdout, clippy::unwrap_used, missing_docs)]

use std::{path::PathBuf, time::Instant};

use railgrip_truth_plant::train::{FaultWish, Journey, TrainOrder, TrainSpec, files, label::Witness};

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, seed, count, hours, rest @ ..] = arguments.as_slice() else {
        println!("usage: write_trains SEED COUNT HOURS [FAULT|any|none] [DIR]");
        return;
    };
    let (seed, count): (u64, u64) = (seed.parse().unwrap(), count.parse().unwrap());
    let fault = match rest.first().map(String::as_str) {
        None | Some("any") => FaultWish::Any,
        Some("none") => FaultWish::None,
        Some(id) => FaultWish::Of(id),
    };
    let order = TrainOrder { hours: hours.parse().unwrap(), fault, ..TrainOrder::default() };
    for seed in seed..seed + count {
        let spec = TrainSpec::draw_to(seed, &order).unwrap();
        let (wagons, duration_s) = (spec.wagons.len(), spec.duration_s);
        let name = format!("train{seed:03}");
        let start = Instant::now();
        let label = match rest.get(1).map(PathBuf::from) {
            Some(out) => files::write_train(
                &name,
                &out.join("trains").join(&name),
                &out.join("truth").join(&name),
                spec,
            )
            .unwrap(),
            None => {
                let mut journey = Journey::new(spec);
                let mut witness = Witness::default();
                while journey.advance() {
                    witness.observe(&journey);
                }
                witness.label(&name, &journey)
            }
        };
        let ratio = duration_s / start.elapsed().as_secs_f64();
        println!(
            "{name} {:14} {wagons:2} wagons {:6.1} km {:3} brakings ({} with slide) {ratio:5.0} x real time  {:?}",
            label.family, label.way_km, label.brakings, label.brakings_with_slide, label.fault
        );
    }
}
