//! The labelled recordings beside the project are read, whole and strictly.
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use railgrip_recording::{Quantity, Recording, Strictness, Truth, runs_in};
use railgrip_requirements::LABELLED_CASES;
use std::path::PathBuf;

railgrip_requirements::tests! {
    the_labelled_recordings_pass_the_strict_checks: [LABELLED_CASES],
}

fn the_labelled_recordings_pass_the_strict_checks() {
    let open = LABELLED_CASES.path();
    let mut count = 0;
    for case in ["case00", "case05"] {
        let folders: [PathBuf; 2] = [open.join(case).join("fit"), open.join(case).join("holdout")];
        for run in folders.iter().flat_map(|folder| runs_in(folder).expect("runs")) {
            let read =
                Recording::read(&run.path, Strictness::Strict).unwrap_or_else(|error| panic!("{error}"));
            read.require_rate(&run.path, 100.0).expect("rate");
            assert!(run.rail.is_some() && read.column(Quantity::Position, 0).is_some());
            count += 1;
        }
        for file in std::fs::read_dir(open.join(case).join("truth")).expect("truth") {
            assert!(!Truth::read(&file.expect("entry").path()).expect("truth").is_empty());
        }
    }
    println!("{count} recordings read");
    assert_eq!(count, 20);
}
