//! `railgrip drill`: are the alarms right? Trains with faults that whoever judges them does not know.
//!
//! `make` runs trains of the truth plant, which shares no formula with the models under test, and seals their labels:
//! the SHA-256 over a random salt and the labels is published at once. `open` checks that neither labels nor trains
//! were changed since, and lays the labels open.
//!
//! Without a subcommand, trains run under the watch of `railgrip_causes` in memory, and its alerts are scored; `replay` does the
//! same with a train from files and writes the alerts.
//!
//! **Folders.** `OUT/trains/NAME`: what a judge is given. `OUT/sealed`: labels, salt and truth, for the owner alone until
//! the last train is judged. `OUT/sealed.sha256`: the published hash.

mod drive;
mod labels;
mod make;
mod open;
mod order;
mod plot;
mod reading;
mod replay;
mod report;
mod run;
mod score;

use clap::{Args as ClapArgs, Subcommand};

use crate::CliError;

/// Trains with faults, and whether the alarms about them are right.
#[derive(Debug, ClapArgs)]
#[command(args_conflicts_with_subcommands = true)]
pub(crate) struct Args {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    drill: run::Args,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Make trains, one fault or none in each, and seal what is wrong with them
    Make(make::Args),
    /// Check the seal and lay the labels open
    Open(open::Args),
    /// Watch a train from files and write its alerts
    Replay(replay::Args),
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    match &args.command {
        Some(Command::Make(args)) => make::run(args),
        Some(Command::Open(args)) => open::run(args),
        Some(Command::Replay(args)) => replay::run(args),
        None => run::run(&args.drill),
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use clap::Parser;

    use super::labels::Labels;
    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: Args,
    }

    fn drill(words: &str, out: &Path) -> Result<(), CliError> {
        let out = out.display().to_string();
        let words = ["drill"].into_iter().chain(words.split(' ')).chain(["--out", &out]);
        run(&Line::parse_from(words).args)
    }

    const FOUR: &str = "make --trains 4 --hours 0.02 --rate 20 --seed 9 --coupled --threads 1";

    #[test]
    fn trains_are_sealed_readable_and_opened_again() {
        let folder = tempfile::tempdir().expect("a folder");
        let out = folder.path();
        drill(FOUR, out).expect("made");
        assert!(!out.join("labels.json").exists() && out.join("sealed.sha256").exists());
        let mut wagons = 0;
        for train in std::fs::read_dir(out.join("trains")).expect("trains") {
            for wagon in std::fs::read_dir(train.expect("a train").path()).expect("wagons") {
                let place = wagon.expect("a file").path();
                if place.is_dir() {
                    let vehicle =
                        railgrip_settings::vehicle::load(&place.join("vehicle.toml")).expect("a vehicle");
                    assert!(
                        vehicle.train.is_some_and(|train| !train.free) && vehicle.body.mass_sigma.is_some()
                    );
                    assert_eq!(vehicle.bogie.is_some(), vehicle.wheelsets() == 4);
                    wagons += 1;
                }
            }
        }
        assert!(wagons >= 16, "{wagons} wagons in four coupled trains");
        drill("open", out).expect("the seal holds");
        let labels = std::fs::read_to_string(out.join("labels.json")).expect("labels");
        let labels: Labels = serde_json::from_str(&labels).expect("labels of this form");
        assert_eq!((labels.trains.len(), labels.seed), (4, 9));
        assert!(labels.trains.iter().any(|made| made.label.fault.is_some()));
        assert_eq!(drill(FOUR, out).expect_err("a used folder").code(), 2);
    }

    #[test]
    fn a_changed_train_or_label_breaks_the_seal() {
        let folder = tempfile::tempdir().expect("a folder");
        let out = folder.path();
        drill("make --trains 1 --hours 0.01 --rate 20 --seed 3 --free --threads 1", out).expect("made");
        let run = out.join("trains/train0000/w01/run.csv");
        let text = std::fs::read_to_string(&run).expect("a run");
        std::fs::write(&run, text.replacen('0', "1", 1)).expect("changed");
        assert!(drill("open", out).expect_err("a changed train").to_string().contains("train0000"));
        std::fs::write(&run, text).expect("mended");
        let labels = out.join("sealed/labels.json");
        let text = std::fs::read_to_string(&labels).expect("labels");
        std::fs::write(&labels, text.replacen("\"seed\": 3", "\"seed\": 4", 1)).expect("changed");
        assert!(drill("open", out).expect_err("changed labels").to_string().contains("the seal is broken"));
        assert!(!out.join("labels.json").exists());
    }
}
