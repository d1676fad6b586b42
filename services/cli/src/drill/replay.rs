//! `railgrip drill replay`: the watch over a train from files, as fast as they can be read.

use std::{
    fs,
    path::{Path, PathBuf},
};

use railgrip_causes::{Alert, Reading, TrainWatch};
use railgrip_recording::{Recording, Row, Strictness};
use serde::Deserialize;
use serde_json::{Value, json};

use super::believed::believed;
use crate::CliError;
use crate::sealed::files::write;

/// Arguments of `railgrip drill replay`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folder of a train: train.toml, and a folder a wagon with vehicle.toml and run.csv or run.parquet
    #[arg(value_name = "TRAIN")]
    train: PathBuf,
    /// File for the alerts
    #[arg(long, value_name = "FILE")]
    json: PathBuf,
}

/// `train.toml`; lines and couplers are not needed here.
#[derive(Debug, Deserialize)]
struct TrainFile {
    wagon: Vec<WagonTable>,
}

#[derive(Debug, Deserialize)]
struct WagonTable {
    number: String,
    folder: String,
}

/// Replays a train and writes its alerts.
pub(super) fn run(args: &Args) -> Result<(), CliError> {
    let file = args.train.join("train.toml");
    let bad = |why: String| CliError::bad_input(format!("{}: {why}", file.display()));
    let text = fs::read_to_string(&file).map_err(|error| bad(error.to_string()))?;
    let train: TrainFile = toml::from_str(&text).map_err(|error| bad(error.to_string()))?;
    if train.wagon.is_empty() {
        return Err(bad("no [[wagon]], at least one is needed".to_owned()));
    }
    let (mut files, mut runs) = (Vec::new(), Vec::new());
    for wagon in &train.wagon {
        let folder = args.train.join(&wagon.folder);
        let vehicle =
            railgrip_settings::vehicle::load(&folder.join("vehicle.toml")).map_err(CliError::bad_input)?;
        let run = recording(&folder)?;
        if run.wheelsets != vehicle.wheelsets() {
            return Err(CliError::bad_input(format!(
                "{}: {} wheelsets in the recording, {} in the vehicle file",
                folder.display(),
                run.wheelsets,
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
        readings.clear();
        readings.extend(
            runs.iter().map(
                |run| {
                    if index < run.len() { reading(&run.row(index)) } else { Reading::default() }
                },
            ),
        );
        watch.take(runs[clock].t_s[index], &readings);
    }
    let numbers: Vec<&str> = train.wagon.iter().map(|wagon| wagon.number.as_str()).collect();
    let alerts: Vec<Value> = watch.alerts().iter().map(|alert| told(alert, &numbers)).collect();
    let text = serde_json::to_string_pretty(&alerts).map_err(CliError::failed)?;
    write(&args.json, &format!("{text}\n"))?;
    crate::output::say(&format!("{} alerts in {}", alerts.len(), args.json.display()));
    Ok(())
}

fn recording(folder: &Path) -> Result<Recording, CliError> {
    let parquet = folder.join("run.parquet");
    let path = if parquet.exists() { parquet } else { folder.join("run.csv") };
    Recording::read(&path, Strictness::Tolerant).map_err(CliError::bad_input)
}

fn reading(row: &Row) -> Reading {
    Reading {
        v_m_s: row.v_m_s,
        wheel_speed_rad_s: row.wheel_speed_rad_s,
        pressing_force_n: row.pressing_force_n,
        drive_torque_nm: row.drive_torque_nm,
        grade_rad: row.grade_rad,
        load_kg: row.load_kg,
        brake_demand: row.brake_demand,
    }
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
