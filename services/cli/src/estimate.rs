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
use railgrip_recording::{BogieRecording, Mapping, MotorRecording, Recording, Row, Strictness};
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
mod tests {
    use super::*;
    use railgrip_recording::Table;

    fn columns_of(rows: &str, smooth: bool) -> Result<Table, CliError> {
        let folder = tempfile::tempdir().expect("folder");
        let [run, vehicle, out] = ["run.csv", "vehicle.toml", "out.csv"].map(|name| folder.path().join(name));
        std::fs::write(&vehicle, include_str!("../../../config/vehicle.toml")).expect("write");
        let header = "t_s,v_m_s,omega_f_rad_s,omega_r_rad_s,f_perp_f_n,f_perp_r_n";
        std::fs::write(&run, format!("{header}\n{rows}")).expect("write");
        let none = OfTrain { coupled: None };
        let args = Args { smooth, train: None, ..Args::of_train(run, vehicle, out.clone(), none) };
        super::run(&args)?;
        Ok(Table::read(&out).expect("a table"))
    }

    /// Rows without a value once ran on to a speed of -12 m/s.
    #[test]
    fn where_nothing_is_measured_for_long_nothing_is_estimated() {
        let row = |k: u32| {
            let t_s = f64::from(k) * 0.01;
            if (5.0..30.0).contains(&t_s) {
                format!("{t_s},,,,,\n")
            } else {
                format!("{t_s},20.0,43.5,43.5,8000,8000\n")
            }
        };
        let rows: String = (0..4000).map(row).collect();
        for smooth in [false, true] {
            let table = columns_of(&rows, smooth).expect("estimates");
            let column = |name: &str| table.column(name).expect("column");
            assert_eq!(table.rows(), 4000);
            for name in ["v_m_s", "mu_w", "mu_b_f", "nis"] {
                let filled = |k: usize| column(name)[k].is_finite();
                assert!((710..2999).all(|k| !filled(k)), "{name}: only what is known is told");
                assert!((100..500).all(filled) && (3010..4000).all(filled), "{name}");
            }
            let known = column("v_m_s").iter().filter(|v| v.is_finite());
            assert!(
                known.clone().all(|v| (5.0..30.0).contains(v)),
                "{:?}",
                known.fold(1e9_f64, |a, b| a.min(*b))
            );
        }
    }

    #[test]
    fn without_any_measured_speed_there_is_nothing_to_estimate() {
        let rows: String = (0..4000).map(|k| format!("{},,,,8000,8000\n", f64::from(k) * 0.01)).collect();
        let error = columns_of(&rows, false).expect_err("nothing is measured");
        println!("{error}");
        assert_eq!(error.code(), 2);
    }

    /// One wagon of the demo scenario, for so long, once through and again.
    fn simulated(duration_s: f64) -> (Recording, VehicleParameters) {
        let text = include_str!("../../../config/scenarios/demo.toml");
        let text = text
            .replace("duration_s = 240.0", &format!("duration_s = {duration_s:?}"))
            .replace("wagons = 8", "wagons = 1");
        let scenario = railgrip_simulation::Scenario::parse(Path::new("demo.toml"), &text).expect("scenario");
        let vehicle: VehicleParameters =
            toml::from_str(include_str!("../../../config/vehicle.toml")).expect("vehicle");
        let mut runs =
            railgrip_simulation::run(&scenario, std::slice::from_ref(&vehicle), 1, |_| ()).expect("a run");
        (runs.remove(0).recording, vehicle)
    }

    /// What is judged in pieces of long recordings once was never tried on one of the simulation.
    #[test]
    fn units_of_simulated_recordings_are_told_short_and_long() {
        for duration_s in [60.0, 240.0, 1800.0] {
            let (run, vehicle) = simulated(duration_s);
            assert_eq!(units::check(&run, &vehicle), Ok(()), "{duration_s} s");
            for factor in [1e3, 1e-3, 1e-5, -1.0] {
                let mut wrong = run.clone();
                wrong.pressing_force_n.iter_mut().flatten().for_each(|force| *force *= factor);
                let error = units::check(&wrong, &vehicle).expect_err("cannot be");
                println!("{duration_s} s, times {factor}: {error}");
                assert_eq!(error.column, "f_perp_f_n");
            }
        }
    }

    #[test]
    fn an_estimate_of_impossible_forces_is_refused_with_their_column() {
        for force in ["-8000", "8e9"] {
            let rows: String =
                (0..500).map(|k| format!("{},20.0,43.5,43.5,{force},8000\n", f64::from(k) * 0.01)).collect();
            let error = columns_of(&rows, false).expect_err(force);
            assert!(error.code() == 2 && error.to_string().contains("f_perp_f_n"), "{error}");
        }
    }

    #[test]
    fn what_is_read_is_not_overwritten() {
        let folder = tempfile::tempdir().expect("folder");
        let [run, vehicle, link] =
            ["run.csv", "vehicle.toml", "link.csv"].map(|name| folder.path().join(name));
        std::fs::write(&run, "t_s").expect("write");
        std::os::unix::fs::symlink(&run, &link).expect("link");
        for (out, why) in
            [(run.clone(), "is read here"), (link, "is read here"), ("/dev/stdout".into(), ".csv")]
        {
            let none = OfTrain { coupled: None };
            let args = Args { train: None, ..Args::of_train(run.clone(), vehicle.clone(), out, none) };
            let error = super::run(&args).expect_err(why);
            assert!(error.code() == 2 && error.to_string().contains(why), "{error}");
        }
        assert_eq!(std::fs::read_to_string(&run).expect("as it was"), "t_s");
    }

    /// The same numbers for the same seed.
    fn dice(state: &mut u64, most: usize) -> usize {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((*state >> 33) % most as u64) as usize
    }

    /// Five hundred recordings with holes of all lengths: no panic, and no figure, least of all zero, where nothing is known.
    #[test]
    fn of_five_hundred_recordings_with_holes_nothing_is_invented() {
        const ROWS: usize = 400;
        let (mut refused, mut told, mut empty) = (0, 0, 0);
        for seed in 0..500_u64 {
            let mut state = seed;
            let row = |k: usize| {
                let v = 20.0 - 0.02 * k as f64;
                [0.05 * k as f64, v, v / 0.46, v / 0.46, 9e3, 8e3].map(|value| value.to_string()).to_vec()
            };
            let mut rows: Vec<Vec<String>> = (0..ROWS).map(row).collect();
            for _ in 0..1 + dice(&mut state, 8) {
                let (from, length) = (dice(&mut state, ROWS), dice(&mut state, ROWS));
                let words = ["", "", "", "NaN", "1e300", "-1e9", "x"];
                let word = words[dice(&mut state, words.len())];
                let (first, count) = (1 + dice(&mut state, 5), 1 + dice(&mut state, 5));
                for cells in rows.iter_mut().skip(from).take(length) {
                    cells.iter_mut().skip(first).take(count).for_each(|cell| word.clone_into(cell));
                }
            }
            let text: String = rows.iter().map(|cells| cells.join(",") + "\n").collect();
            let table = match columns_of(&text, false) {
                Ok(table) => table,
                Err(error) => {
                    assert_eq!(error.code(), 2, "{seed}: {error}");
                    refused += 1;
                    continue;
                }
            };
            let known =
                |cells: &[String]| cells[1..4].iter().any(|cell| cell.parse().is_ok_and(f64::is_finite));
            let mut last = 0;
            for (k, cells) in rows.iter().enumerate() {
                if known(cells) {
                    last = k;
                }
                let blind = 0.05 * (k - last) as f64 > 2.0 + 1e-9;
                for name in ["v_m_s", "mu_w", "mu_w_sigma", "mu_b_f", "mu_b_r_sigma", "slip_f", "nis"] {
                    let value = table.column(name).expect(name)[k];
                    assert!(!blind || value.is_nan(), "{seed}: {name} is {value} in row {k}");
                    assert!(!value.is_infinite(), "{seed}: {name} in row {k}");
                    if name.ends_with("sigma") {
                        assert!(value.is_nan() || value > 0.0, "{seed}: {name} is {value} in row {k}");
                    }
                    if value.is_nan() { empty += 1 } else { told += 1 }
                }
            }
        }
        println!("{refused} refused, {told} figures told, {empty} left empty");
        assert!(refused > 50 && told > 100_000 && empty > 10_000, "{refused} {told} {empty}");
    }
}
