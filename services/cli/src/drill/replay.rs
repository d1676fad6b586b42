//! `railgrip drill replay`: the watch over a train from files, as fast as they can be read.

use std::path::{Path, PathBuf};

use railgrip_causes::{Alert, Reading, TrainWatch};
use railgrip_judge::believed;
use railgrip_recording::{Recording, Strictness};
use railgrip_settings::{RecordedTrain, RecordedWagon};
use serde_json::{Value, json};

use super::reading::reading;
use crate::estimate::OfTrain;
use crate::output::apart;
use crate::sealed::files::{cannot_write, write};
use crate::{CliError, estimate};

/// Arguments of `railgrip drill replay`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folder of a train: train.toml, and a folder a wagon with vehicle.toml and run.csv or run.parquet
    #[arg(value_name = "TRAIN")]
    train: PathBuf,
    /// File for the alerts
    #[arg(long, value_name = "FILE")]
    json: PathBuf,
    /// Folder for the estimates of adhesion and pad friction, one CSV a wagon, as `railgrip estimate` writes it, with adhesion wheelset by wheelset
    #[arg(long, value_name = "DIR")]
    estimates: Option<PathBuf>,
}

/// Replays a train and writes its alerts.
pub(super) fn run(args: &Args) -> Result<(), CliError> {
    let train = RecordedTrain::read(&args.train)?;
    let description = args.train.join("train.toml");
    let of_wagons = train.wagons.iter().flat_map(|wagon| [wagon.run.as_path(), wagon.vehicle.as_path()]);
    let read: Vec<&Path> = of_wagons.chain([description.as_path()]).collect();
    if let Some(folder) = args.json.parent() {
        std::fs::create_dir_all(folder).map_err(|error| cannot_write(folder, &error))?;
    }
    apart(&[("--json", Some(args.json.as_path()))], &read)?;
    let (mut files, mut runs) = (Vec::new(), Vec::new());
    for wagon in &train.wagons {
        let vehicle = railgrip_settings::vehicle::load(&wagon.vehicle).map_err(CliError::bad_input)?;
        let run = Recording::read(&wagon.run, Strictness::Tolerant).map_err(CliError::bad_input)?;
        if run.wheelsets != vehicle.wheelsets() {
            return Err(CliError::bad_input(format!(
                "{} has {} wheelsets, {} has {}",
                wagon.run.display(),
                run.wheelsets,
                wagon.vehicle.display(),
                vehicle.wheelsets()
            )));
        }
        estimate::check_units(&wagon.run, &run, &vehicle)?;
        files.push(believed(&vehicle));
        runs.push(run);
    }
    let places: Vec<&Path> = train.wagons.iter().map(|wagon| wagon.run.as_path()).collect();
    let times: Vec<&[f64]> = runs.iter().map(|run| run.t_s.as_slice()).collect();
    same_clock(&places, &times)?;
    let mut watch = TrainWatch::new(files);
    let mut readings: Vec<Reading> = Vec::with_capacity(runs.len());
    for (index, t_s) in times[0].iter().enumerate() {
        readings.clear();
        readings.extend(runs.iter().map(|run| reading!(run.row(index))));
        watch.take(*t_s, &readings);
    }
    let numbers: Vec<&str> = train.wagons.iter().map(|wagon| wagon.number.as_str()).collect();
    let alerts: Vec<Value> = watch.alerts().iter().map(|alert| told(alert, &numbers)).collect();
    let text = serde_json::to_string_pretty(&alerts).map_err(CliError::failed)?;
    write(&args.json, &format!("{text}\n"))?;
    crate::output::say(&format!("{} alerts in {}", alerts.len(), args.json.display()));
    let Some(folder) = &args.estimates else { return Ok(()) };
    std::fs::create_dir_all(folder).map_err(|error| cannot_write(folder, &error))?;
    train.wagons.iter().try_for_each(|wagon: &RecordedWagon| {
        let out = folder.join(format!("{}.csv", wagon.name));
        let of_train = OfTrain { coupled: (train.wagons.len() > 1).then_some(wagon.coupled) };
        estimate::run(&estimate::Args::of_train(wagon.run.clone(), wagon.vehicle.clone(), out, of_train))
    })
}

/// Refuses runs of which one has another length or another clock than the first: what is compared along the train must be of the same
/// instant. A wagon that fell silent has empty cells.
fn same_clock(places: &[&Path], times: &[&[f64]]) -> Result<(), CliError> {
    let (first, clock) = (places[0].display(), times[0]);
    for (place, t_s) in places.iter().zip(times) {
        let place = place.display();
        let row = |index: usize, problem: String| {
            // The header is line 1.
            Err(CliError::bad_input(format!("{place}, line {}, column t_s: {problem}", index + 2)))
        };
        if let Some(index) = (1..t_s.len()).find(|index| t_s[*index] <= t_s[index - 1]) {
            return row(index, format!("{} after {} s; time must grow", t_s[index], t_s[index - 1]));
        }
        if t_s.len() != clock.len() {
            return Err(CliError::bad_input(format!(
                "{place} has {} rows, {first} has {}; all wagons of a train have the same clock and length",
                t_s.len(),
                clock.len()
            )));
        }
        let step_s = clock.get(1).map_or(0.0, |second| second - clock[0]);
        let other = |index: &usize| (t_s[*index] - clock[*index]).abs() > 0.5 * step_s + 1e-6;
        if let Some(index) = (0..t_s.len()).find(other) {
            let problem = format!("{} s where {first} has {} s", t_s[index], clock[index]);
            return row(index, format!("{problem}; all wagons of a train have the same clock"));
        }
    }
    Ok(())
}

/// An alert as `alerts.json` has it: wagons by number, wheelsets from 1.
fn told(alert: &Alert, numbers: &[&str]) -> Value {
    let wagons: Vec<&str> = alert.wagons.iter().map(|wagon| numbers[*wagon]).collect();
    let instead: Vec<Value> = alert
        .instead
        .iter()
        .map(|runner| json!({ "cause": runner.cause.word(), "probability": runner.probability }))
        .collect();
    json!({
        "raised_t_s": alert.raised_t_s,
        "cleared_t_s": alert.cleared_t_s,
        "grade": alert.grade.word(),
        "cause": alert.cause.word(),
        "wagon": wagons.first(),
        "wagons": wagons,
        "wheelsets": alert.wheelsets.iter().map(|k| k + 1).collect::<Vec<_>>(),
        "probability": alert.probability,
        "instead": instead,
        "brakings_seen": alert.brakings_seen,
        "reason": alert.reason,
        "advice": alert.cause.advice(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_one_train_have_one_clock() {
        let places = [Path::new("w01/run.csv"), Path::new("w02/run.csv")];
        let clock = [0.0, 0.05, 0.1, 0.15];
        let said = |other: &[f64]| same_clock(&places, &[&clock, other]).map_err(|error| error.to_string());
        assert_eq!(said(&[0.001, 0.05, 0.101, 0.15]), Ok(()), "a clock is rounded");
        for (other, named) in [
            (&[0.0, 0.05, 0.1][..], ["w02/run.csv has 3 rows", "w01/run.csv has 4"]),
            (&[0.0, 0.05, 0.04, 0.15], ["w02/run.csv, line 4", "0.04 after 0.05 s"]),
            (&[1.0, 1.05, 1.1, 1.15], ["w02/run.csv, line 2", "where w01/run.csv has 0 s"]),
        ] {
            let error = said(other).expect_err("another clock");
            assert!(named.iter().all(|part| error.contains(part)), "{error}");
        }
    }
}
