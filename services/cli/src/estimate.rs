//! `railgrip estimate`: the estimator on a recording, with the same step as in the live process.
//!
//! The vehicle file says what was recorded: a wagon, a roller rig (`kind = "roller"`: the columns of a wagon with one
//! wheelset), a traction rig (`kind = "traction"`: motor currents, voltages and speeds) or a bogie rig (`kind = "bogie"`:
//! torque, link force and pulses; `--detail` adds what the paper's (2) and (3) say without a filter). One row for each row of the
//! recording. Dirty data (gaps, repeats, cells without a value) are the estimator's business; a file of another form is
//! bad input.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use indicatif::ProgressBar;
use railgrip_diagnosis::data::units;
use railgrip_estimator::convert;
use railgrip_estimator::sight::Sight;
use railgrip_experiments::rigs::{bogie_sample, traction_sample};
use railgrip_filter::models::bogie_rig::slip_based::{PaperReader, PaperReading};
use railgrip_filter::{
    Estimator, EstimatorConfig, EstimatorInput, EstimatorOutput, FilterError, Plant, WagonSample,
    smooth_record,
};
use railgrip_messages::{Estimate, Sample};
use railgrip_recording::{BogieRecording, Mapping, MotorRecording, Quantity, Recording, Row, Strictness};
use railgrip_settings::{Overrides, TrainSettings};
use railgrip_vehicle::{Running, VehicleParameters};

use crate::CliError;
use crate::estimate_columns::{columns, columns_of_train};
use crate::estimate_sheet::Sheet;
use crate::output::{apart, say};

/// Estimate adhesion and friction of a recording, sample by sample.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Recording of one wagon or rig, CSV or Parquet
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// Vehicle file of the wagon, or the rig's file
    #[arg(long, value_name = "FILE")]
    vehicle: PathBuf,
    /// File for the estimates, CSV or Parquet
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Filter: default, paper, rig or imm; of a traction rig zhao or zhao_ekf; of a bogie rig shrestha [default: as the config says, else "default"]
    #[arg(long, value_name = "NAME")]
    filter: Option<String>,
    /// Config of a train whose [estimator] and [mapping] apply
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Say what the whole recording tells about each instant, not only what came before it (fixed-interval smoothing)
    #[arg(long)]
    smooth: bool,
    /// More columns: adhesion and load of each wheelset, mean pad friction, state; of a bogie rig slip and adhesion by the
    /// paper's (2) and (3)
    #[arg(long)]
    detail: bool,
    /// The train that it is a wagon of.
    #[arg(skip)]
    train: Option<OfTrain>,
}

/// Most rows that are smoothed: 20 minutes of a process that has 4 GB, at 1 kHz.
const MOST_SMOOTHED: usize = 1_200_000;

/// A wagon in a recorded train.
#[derive(Debug, Clone, Copy)]
pub(crate) struct OfTrain {
    /// Whether it is coupled to others; `None`: as its vehicle file says.
    pub(crate) coupled: Option<bool>,
}

impl Args {
    /// A run of a wagon of a train, with the usual filter.
    pub(crate) const fn of_train(run: PathBuf, vehicle: PathBuf, out: PathBuf, train: OfTrain) -> Self {
        Self {
            run,
            vehicle,
            out,
            filter: None,
            config: None,
            smooth: false,
            detail: false,
            train: Some(train),
        }
    }
}

/// Refuses a file for the estimates that no table can be, or that is one of those that are read.
fn sound_out(args: &Args) -> Result<(), CliError> {
    let out = &args.out;
    let refuse = |why: &str| Err(CliError::bad_input(format!("--out {}: {why}", out.display())));
    if !matches!(out.extension().and_then(|ending| ending.to_str()), Some("csv" | "parquet")) {
        return refuse("estimates are written as .csv or .parquet");
    }
    let read = [Some(&args.run), Some(&args.vehicle), args.config.as_ref()];
    let read: Vec<&Path> = read.into_iter().flatten().map(PathBuf::as_path).collect();
    apart(&[("--out", Some(out))], &read)
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    sound_out(args)?;
    let (mut config, mapping) = match &args.config {
        Some(file) => {
            let settings = TrainSettings::load(Some(file), &Overrides::default())?;
            (settings.estimator, settings.mapping)
        }
        None => (EstimatorConfig::default(), Mapping::default()),
    };
    if let Some(filter) = &args.filter {
        config.filter.clone_from(filter);
    }
    let mut plant = railgrip_settings::plant::load(&args.vehicle).map_err(CliError::bad_input)?;
    let coupled = args.train.and_then(|train| train.coupled);
    if let (Plant::Wagon(vehicle), Some(coupled)) = (&mut plant, coupled) {
        vehicle.train = Some(Running { free: !coupled });
    }
    let mut estimator = railgrip_filter::estimator(&config, &plant).map_err(CliError::bad_input)?;
    let recorded = Recorded::read(args, &plant, &mapping)?;
    if recorded.rows() > 0 && !recorded.inputs().any(|input| measured(&input)) {
        let why =
            "no row has a measured speed, neither of the vehicle nor of a wheelset: nothing can be estimated";
        return Err(CliError::bad_input(format!("{}: {why}", args.run.display())));
    }
    let columns = match (&plant, args.train) {
        (Plant::Wagon(_), Some(_)) => columns_of_train(plant.wheelsets()),
        _ => columns(plant.kind(), plant.wheelsets(), args.detail),
    };
    let mut sheet = Sheet::new(columns, recorded.rows());
    let empty = match args.smooth {
        true => smoothed(args, &mut estimator, &recorded, &mut sheet)?,
        false => forward(&mut *estimator, &recorded, &mut sheet),
    };
    let counted = sheet.counted().clone();
    if counted.told == 0 {
        let why = format!("no row can be estimated; the estimator says {}", counted.most_said());
        return Err(CliError::bad_input(format!("{}: {why}", args.run.display())));
    }
    let further = if args.detail { by_the_paper(&recorded, &plant) } else { Vec::new() };
    sheet.table(further)?.write(&args.out).map_err(CliError::failed)?;
    let way = if args.smooth { ", smoothed" } else { "" };
    let filter = &estimator.snapshot().filter;
    let mut text = format!("{}: {} estimates by filter \"{filter}\"{way}", args.out.display(), counted.told);
    if empty > 0 {
        text.push_str(&format!(
            "; {empty} rows left empty, because no speed was measured for long (nothing_measured)"
        ));
    }
    if let Some(lacking) = recorded.lacking() {
        text.push_str(&format!("; cells without a value: {lacking}"));
    }
    let without = counted.silent.saturating_sub(empty);
    // The first rows of a filter are no news.
    if without * 20 > recorded.rows() {
        text.push_str(&format!("; {without} rows without one, most of them {}", counted.most_said()));
    }
    // Of recordings in their units it is none, whatever effects are at work.
    if counted.diverged * 50 > recorded.rows() {
        text.push_str(&format!(
            "; in {} rows the model does not explain the data (diverged): are the forces in N, and is the vehicle file its own?",
            counted.diverged
        ));
    }
    say(&text);
    Ok(())
}

/// Whether a sample has a speed of the vehicle or of a wheelset; what a rig lacks, its own filter tells by a state.
fn measured(input: &EstimatorInput) -> bool {
    match input {
        EstimatorInput::Wagon(sample) => {
            sample.v_m_s.is_finite() || sample.wheel_speed_rad_s.iter().any(|speed| speed.is_finite())
        }
        EstimatorInput::Traction(_) | EstimatorInput::Bogie(_) => true,
    }
}

fn time_s(input: &EstimatorInput) -> f64 {
    match input {
        EstimatorInput::Wagon(sample) => sample.time_s,
        EstimatorInput::Traction(sample) => sample.time_s,
        EstimatorInput::Bogie(sample) => sample.time_s,
    }
}

/// A recording, of whose rows the inputs are made one by one: an input is much larger than its row.
enum Recorded {
    Wagon(Box<Recording>),
    Traction(MotorRecording),
    Bogie(BogieRecording),
}

impl Recorded {
    /// Reads the recording, whose form the plant decides.
    fn read(args: &Args, plant: &Plant, mapping: &Mapping) -> Result<Self, CliError> {
        if matches!(plant, Plant::Traction(_)) {
            let read = MotorRecording::read(&args.run, Strictness::Tolerant);
            return read.map(Self::Traction).map_err(CliError::bad_input);
        }
        if matches!(plant, Plant::Bogie(_)) {
            let read = BogieRecording::read(&args.run, Strictness::Tolerant);
            return read.map(Self::Bogie).map_err(CliError::bad_input);
        }
        let recording =
            Recording::read_mapped(&args.run, mapping, Strictness::Tolerant).map_err(CliError::bad_input)?;
        if recording.wheelsets != plant.wheelsets() {
            return Err(wheelsets_differ(&args.run, recording.wheelsets, &args.vehicle, plant.wheelsets()));
        }
        if let Plant::Wagon(vehicle) = plant {
            check_units(&args.run, &recording, vehicle)?;
        }
        Ok(Self::Wagon(Box::new(recording)))
    }

    fn rows(&self) -> usize {
        match self {
            Self::Wagon(recording) => recording.len(),
            Self::Traction(recording) => recording.rows.len(),
            Self::Bogie(recording) => recording.rows.len(),
        }
    }

    /// Cells without a value of a wagon's recording, counted by column; `None` where there are none.
    fn lacking(&self) -> Option<String> {
        let Self::Wagon(recording) = self else { return None };
        let mut counted = Vec::new();
        for quantity in Quantity::ALL {
            let columns = if quantity.per_wheelset() { recording.wheelsets } else { 1 };
            for wheelset in 0..columns {
                let cells = recording.column(quantity, wheelset).unwrap_or_default();
                let lacking = cells.iter().filter(|cell| !cell.is_finite()).count();
                if lacking > 0 {
                    counted.push(format!("{} {lacking}", quantity.column(wheelset, recording.wheelsets)));
                }
            }
        }
        (!counted.is_empty()).then(|| counted.join(", "))
    }

    fn inputs(&self) -> Box<dyn Iterator<Item = EstimatorInput> + '_> {
        match self {
            Self::Wagon(recording) => {
                Box::new(recording.rows().map(|row| EstimatorInput::Wagon(wagon_sample(&row))))
            }
            Self::Traction(recording) => {
                Box::new(recording.rows.iter().map(|row| EstimatorInput::Traction(traction_sample(row))))
            }
            Self::Bogie(recording) => {
                Box::new(recording.rows.iter().map(|row| EstimatorInput::Bogie(bogie_sample(row))))
            }
        }
    }
}

/// Refuses columns that cannot be in their units, as a diagnosis does.
pub(crate) fn check_units(
    run: &Path,
    recording: &Recording,
    vehicle: &VehicleParameters,
) -> Result<(), CliError> {
    units::check(recording, vehicle)
        .map_err(|error| CliError::bad_input(format!("{}, at {:.2} s, {error}", run.display(), error.t_s)))
}

fn wheelsets_differ(run: &Path, found: usize, vehicle: &Path, expected: usize) -> CliError {
    CliError::bad_input(format!(
        "{} has {found} wheelsets, {} has {expected}",
        run.display(),
        vehicle.display()
    ))
}

/// The bar that shows how far the work is.
fn progress(rows: usize) -> ProgressBar {
    match std::io::stderr().is_terminal() {
        true => ProgressBar::new(rows as u64),
        false => ProgressBar::hidden(),
    }
}

/// Estimates row by row into the sheet; returns how many rows it left empty. As live: where no speed has been measured for long, an
/// estimate would be invented.
fn forward(estimator: &mut dyn Estimator, recorded: &Recorded, sheet: &mut Sheet) -> usize {
    let bar = progress(recorded.rows());
    let (mut sight, mut empty) = (Sight::default(), 0);
    for (row, input) in recorded.inputs().enumerate() {
        match sight.goes_on(time_s(&input), measured(&input)) {
            true => sheet.take(&convert::estimate(&Sample::default(), &estimator.step(&input))),
            false => {
                empty += 1;
                sheet.take(&nothing(time_s(&input)));
            }
        }
        if row % 4096 == 0 {
            bar.set_position(row as u64);
        }
    }
    bar.finish_and_clear();
    empty
}

/// The same by smoothing, which needs all of the recording at once.
fn smoothed(
    args: &Args,
    estimator: &mut Box<dyn Estimator>,
    recorded: &Recorded,
    sheet: &mut Sheet,
) -> Result<usize, CliError> {
    let rows = recorded.rows();
    if rows > MOST_SMOOTHED {
        let said = format!(
            "{}: {rows} rows; --smooth holds all of a recording in memory and takes at most {MOST_SMOOTHED}: cut the file",
            args.run.display()
        );
        return Err(CliError::bad_input(said));
    }
    let inputs: Vec<EstimatorInput> = recorded.inputs().collect();
    let mut sight = Sight::default();
    let seen: Vec<bool> = inputs.iter().map(|input| sight.goes_on(time_s(input), measured(input))).collect();
    let kept: Vec<EstimatorInput> =
        inputs.iter().zip(&seen).filter(|(_, seen)| **seen).map(|(input, _)| *input).collect();
    let outputs: Vec<EstimatorOutput> = smooth_record(estimator, &kept).map_err(|error| match error {
        FilterError::NotSmoothable(_) => CliError::bad_input(format!("--smooth: {error}")),
        error => CliError::failed(error),
    })?;
    let mut outputs = outputs.iter();
    for (input, seen) in inputs.iter().zip(&seen) {
        match if *seen { outputs.next() } else { None } {
            Some(output) => sheet.take(&convert::estimate(&Sample::default(), output)),
            None => sheet.take(&nothing(time_s(input))),
        }
    }
    Ok(inputs.len() - kept.len())
}

/// What is told of an instant of which nothing is known.
fn nothing(time_s: f64) -> Estimate {
    Estimate { time_s, ..Estimate::default() }
}

fn wagon_sample(row: &Row) -> WagonSample {
    let wsp_active = (0..row.wsp_active.len()).filter(|&i| row.wsp_active[i] > 0.5).map(|i| 1 << i).sum();
    WagonSample {
        time_s: row.t_s,
        v_m_s: row.v_m_s,
        wheel_speed_rad_s: row.wheel_speed_rad_s,
        pressing_force_n: row.pressing_force_n,
        drive_torque_nm: row.drive_torque_nm,
        grade_rad: row.grade_rad,
        sanding: row.sanding,
        position_m: row.position_m,
        load_kg: row.load_kg,
        wsp_active,
    }
}

/// Columns of the paper's own figures, positive in braking: λ (2), (3) from the load cell, (3) from the torque as printed
/// and with inertia and loss.
fn by_the_paper(recorded: &Recorded, plant: &Plant) -> Vec<(String, Vec<f64>)> {
    let Plant::Bogie(rig) = plant else { return Vec::new() };
    let mut reader = PaperReader::new(rig.parameters());
    let Recorded::Bogie(recording) = recorded else { return Vec::new() };
    let readings: Vec<PaperReading> =
        recording.rows.iter().map(|row| reader.read(&bogie_sample(row))).collect();
    let column = |name: &str, pick: fn(&PaperReading) -> f64| {
        (name.to_owned(), readings.iter().map(pick).collect::<Vec<_>>())
    };
    vec![
        column("lambda_f", |reading| reading.slip[0]),
        column("lambda_r", |reading| reading.slip[1]),
        column("mu_load_cell", |reading| reading.by_load_cell),
        column("mu_torque", |reading| reading.by_torque),
        column("mu_torque_inertia", |reading| reading.by_torque_with_inertia),
    ]
}

#[cfg(test)]
mod tests;
