//! `railgrip drill replay`: the watch over a train from files, as fast as they can be read.

use std::path::PathBuf;

use railgrip_causes::{Alert, Reading, TrainWatch};
use railgrip_judge::believed;
use railgrip_recording::{Recording, Strictness};
use railgrip_settings::{RecordedTrain, RecordedWagon};
use serde_json::{Value, json};

use super::reading::reading;
use crate::estimate::OfTrain;
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
        files.push(believed(&vehicle));
        runs.push(run);
    }
    let mut watch = TrainWatch::new(files);
    let length = runs.iter().map(Recording::len).max().unwrap_or(0);
    let clock = runs.iter().position(|run| run.len() == length).unwrap_or(0);
    let mut readings = Vec::with_capacity(runs.len());
    for index in 0..length {
        let at = |run: &Recording| {
            if index < run.len() { reading!(run.row(index)) } else { Reading::default() }
        };
        readings.clear();
        readings.extend(runs.iter().map(at));
        watch.take(runs[clock].t_s[index], &readings);
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
