//! `railgrip simulate`: a scenario as recordings, with the truth beside them.
//!
//! `DIR/wagonNN.RAIL.csv` is the recording of one wagon, `DIR/truth/wagonNN.RAIL.csv` what no sensor saw, row for row, and
//! `DIR/vehicle.toml` the vehicle. RAIL is the rail class on which the wagon spent most of its time. The folder can be replayed
//! as it is. The published tests of the rigs are scenarios too: see [`crate::simulate_rig`].

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use railgrip_recording::RailClass;
use railgrip_settings::RigProgramme;
use railgrip_simulation::{Scenario, ScenarioError, WagonRun};
use railgrip_vehicle::VehicleParameters;

use crate::output::{only_own, say};
use crate::{CliError, simulate_rig};

/// The vehicle of `config/vehicle.toml`, for scenarios that name none or are built in.
const DEFAULT_VEHICLE: &str = include_str!("../../../config/vehicle.toml");

/// Turn a scenario into recordings, with the truth beside them.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Scenario file, or the name of a built-in one: demo, one_wagon_low, schwarz_keck_sanding, schwarz_keck_wsp; of a rig:
    /// schwarz-wsp, schwarz-sanding, zhao-SURFACE-CASE (base, water or oil; 0 to 4), shrestha-water, shrestha-RAIL-CONTROLLER
    /// (dry or wet; none, conventional or proposed)
    #[arg(long, value_name = "FILE", default_value = "demo")]
    scenario: String,
    /// Folder for the recordings; created if it is missing
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Vehicle file of every wagon; by default the one that the scenario names
    #[arg(long, value_name = "FILE")]
    vehicle: Option<PathBuf>,
    /// Seed of everything random: the same seed gives the same bits
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Form of the recordings
    #[arg(long, value_enum, default_value_t = Form::Csv)]
    format: Form,
}

/// Columns of a recording and its truth, and those of them that each wheelset has, about.
const COLUMNS: usize = 16;
const COLUMNS_A_WHEELSET: usize = 10;
/// Most memory that rows may take, MiB.
const MOST_MIB: f64 = 8192.0;

/// Form of the recordings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Form {
    /// Text
    Csv,
    /// Apache Parquet
    Parquet,
}

impl Form {
    const ALL: [Self; 2] = [Self::Csv, Self::Parquet];

    const fn ending(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Parquet => "parquet",
        }
    }
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    if let Some(programme) = RigProgramme::from_name(&args.scenario) {
        if args.vehicle.is_some() {
            return Err(CliError::bad_input("--vehicle: the test of a rig brings its own rig"));
        }
        return simulate_rig::run(programme, args.seed, &args.out, args.format.ending());
    }
    let scenario = Scenario::load(&args.scenario, Path::new("")).map_err(|error| match error {
        ScenarioError::Unknown { .. } => {
            CliError::bad_input(format!("{error}, or of a rig: {}", RigProgramme::NAMES))
        }
        error => of_scenario(error),
    })?;
    if let Some(beyond) = scenario.wagon.iter().find(|wagon| wagon.number > scenario.train.wagons) {
        return Err(CliError::bad_input(format!(
            "{}: [[wagon]] number {} is beyond the {} wagons of the train",
            args.scenario, beyond.number, scenario.train.wagons
        )));
    }
    let (vehicle, text) = vehicle(args, &scenario)?;
    only_own(&args.out, ("vehicle.toml", &text), is_own)?;
    fits(&scenario, &vehicle)?;
    let vehicles = vec![vehicle; scenario.train.wagons];
    let (runs, took) = simulate(&scenario, &vehicles, args.seed)?;
    write(args, &runs, &text)?;
    summary(args, &scenario, &runs, took);
    Ok(())
}

/// Refuses a train whose rows, which are held until they are written, would fill the memory.
fn fits(scenario: &Scenario, vehicle: &VehicleParameters) -> Result<(), CliError> {
    let columns = COLUMNS + COLUMNS_A_WHEELSET * vehicle.wheelsets();
    let rows = scenario.duration_s * vehicle.sensors.sample_rate_hz * scenario.train.wagons as f64;
    let mib = rows * (8 * columns) as f64 / f64::from(1 << 20);
    if mib <= MOST_MIB {
        return Ok(());
    }
    Err(CliError::bad_input(format!(
        "{} wagons for {} s at {} Hz fill {mib:.0} MiB of memory; at most {MOST_MIB} MiB are simulated at once: shorten the scenario",
        scenario.train.wagons, scenario.duration_s, vehicle.sensors.sample_rate_hz
    )))
}

fn of_scenario(error: ScenarioError) -> CliError {
    CliError::bad_input(error)
}

/// The vehicle with the text of its file.
fn vehicle(args: &Args, scenario: &Scenario) -> Result<(VehicleParameters, String), CliError> {
    let named = scenario.train.vehicle.as_ref().filter(|_| Path::new(&args.scenario).is_file());
    let beside = Path::new(&args.scenario).parent().unwrap_or(Path::new(""));
    let file = args.vehicle.clone().or_else(|| named.map(|named| beside.join(named)));
    let (file, text) = match file {
        None => (PathBuf::from("built-in vehicle"), DEFAULT_VEHICLE.to_owned()),
        Some(file) => match railgrip_recording::read_text(&file) {
            Ok(text) => (file, text),
            Err(error) => return Err(CliError::bad_input(format!("{}: {error}", file.display()))),
        },
    };
    let vehicle = railgrip_settings::vehicle::parse(&file, &text).map_err(CliError::bad_input)?;
    Ok((vehicle, text))
}

fn simulate(
    scenario: &Scenario,
    vehicles: &[VehicleParameters],
    seed: u64,
) -> Result<(Vec<WagonRun>, Duration), CliError> {
    let shown = std::io::stderr().is_terminal();
    let bar = if shown { indicatif::ProgressBar::new(100) } else { indicatif::ProgressBar::hidden() };
    let started = Instant::now();
    let runs =
        railgrip_simulation::run(scenario, vehicles, seed, |share| bar.set_position((100.0 * share) as u64))
            .map_err(of_scenario)?;
    bar.finish_and_clear();
    Ok((runs, started.elapsed()))
}

fn write(args: &Args, runs: &[WagonRun], vehicle: &str) -> Result<(), CliError> {
    let truth = args.out.join("truth");
    let failed =
        |path: &Path, error: std::io::Error| CliError::failed(format!("{}: {error}", path.display()));
    std::fs::create_dir_all(&truth).map_err(|error| failed(&truth, error))?;
    for folder in [&args.out, &truth] {
        remove_earlier(folder).map_err(|error| failed(folder, error))?;
    }
    for run in runs {
        let name = format!("{}.{}", run.recording.name, args.format.ending());
        run.recording.write(&args.out.join(&name)).map_err(CliError::failed)?;
        run.truth.write(&truth.join(&name)).map_err(CliError::failed)?;
    }
    let file = args.out.join("vehicle.toml");
    std::fs::write(&file, vehicle).map_err(|error| failed(&file, error))
}

/// Removes the wagons of an earlier simulation, which may have had other names, so that the folder holds one train.
fn remove_earlier(folder: &Path) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_file() && path.file_name().is_some_and(|name| is_own(&name.to_string_lossy())) {
            std::fs::remove_file(path)?;
        }
    }
    Ok(())
}

/// Whether a file is named as this command names a wagon: `wagonNN.RAIL.csv`.
fn is_own(name: &str) -> bool {
    let mut parts = name.split('.');
    let wagon = parts.next().and_then(|wagon| wagon.strip_prefix("wagon"));
    let number =
        wagon.is_some_and(|number| number.len() >= 2 && number.bytes().all(|byte| byte.is_ascii_digit()));
    let rail = parts.next().is_some_and(|rail| RailClass::parse(rail).is_some());
    let ending = parts.next().is_some_and(|ending| Form::ALL.iter().any(|form| form.ending() == ending));
    number && rail && ending && parts.next().is_none()
}

fn summary(args: &Args, scenario: &Scenario, runs: &[WagonRun], took: Duration) {
    say(&format!("{}: {} wagons, {} s, seed {}", scenario.name, runs.len(), scenario.duration_s, args.seed));
    say("recording           rows   speed m/s     adhesion utilised   pad friction");
    for run in runs {
        say(&wagon_line(run));
    }
    let simulated_s = scenario.duration_s * runs.len() as f64;
    let times = simulated_s / took.as_secs_f64().max(1e-9);
    say(&format!("simulated in {:.2} s: {times:.0} times real time for one wagon", took.as_secs_f64()));
    say(&format!("written to {}", args.out.display()));
}

fn wagon_line(run: &WagonRun) -> String {
    let range = |columns: &[&[f64]]| {
        let cells = columns.iter().flat_map(|column| column.iter()).filter(|cell| !cell.is_nan());
        cells.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), cell| (low.min(*cell), high.max(*cell)))
    };
    let (slow, fast) = range(&[&run.truth.v_m_s]);
    let (least, most) = range(&[&run.truth.mu_w]);
    let pads: Vec<&[f64]> = run.truth.mu_b.iter().map(Vec::as_slice).collect();
    let pad_text = match range(&pads) {
        (low, high) if low <= high => format!("{low:.3} to {high:.3}"),
        _ => "not braked".to_owned(),
    };
    let (name, rows) = (&run.recording.name, run.recording.len());
    format!("{name:<16} {rows:>7}   {slow:>4.1} to {fast:>4.1}   {least:>7.3} to {most:>6.3}   {pad_text}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_recording::{Recording, Strictness, Truth, runs_in};

    const SCENARIO: &str = "schema = 1\nname = \"short\"\nduration_s = 8.0\nstart_speed_m_s = 20.0\n\
        [train]\nwagons = 2\nvehicle = \"v.toml\"\n[[demand]]\nfrom_s = 0.0\nbrake = 0.7\n";

    fn args(folder: &Path, out: &str, seed: u64, format: Form) -> Args {
        let scenario = folder.join("short.toml").to_string_lossy().into_owned();
        Args { scenario, out: folder.join(out), vehicle: None, seed, format }
    }

    /// A folder with a scenario and the vehicle that it names.
    fn folder() -> tempfile::TempDir {
        let folder = tempfile::tempdir().expect("folder");
        std::fs::write(folder.path().join("short.toml"), SCENARIO).expect("scenario");
        let vehicle = DEFAULT_VEHICLE.replace("name = \"coach\"", "name = \"mine\"");
        std::fs::write(folder.path().join("v.toml"), vehicle).expect("vehicle");
        folder
    }

    #[test]
    fn a_folder_holds_runs_truth_and_vehicle_and_the_same_seed_the_same_bytes() {
        let folder = folder();
        for (out, seed) in [("a", 1), ("b", 1), ("c", 2)] {
            run(&args(folder.path(), out, seed, Form::Csv)).expect("simulated");
        }
        let text = |out: &str, file: &str| {
            std::fs::read_to_string(folder.path().join(out).join(file))
                .unwrap_or_else(|_| panic!("{out}/{file}"))
        };
        let runs = runs_in(&folder.path().join("a")).expect("runs");
        assert_eq!(
            runs.iter().map(|run| run.name.as_str()).collect::<Vec<_>>(),
            ["wagon01.dry", "wagon02.dry"]
        );
        for run in &runs {
            let recording = Recording::read(&run.path, Strictness::Strict).expect("strict");
            let file = format!("{}.csv", run.name);
            let truth = Truth::read(&folder.path().join("a/truth").join(&file)).expect("truth");
            assert_eq!((recording.len(), truth.len()), (801, 801));
            assert_eq!(recording.t_s, truth.t_s);
            assert!(text("a", &file) == text("b", &file) && text("a", &file) != text("c", &file));
        }
        assert!(text("a", "vehicle.toml").contains("\"mine\""), "the vehicle that the scenario names");
    }

    #[test]
    fn another_form_replaces_the_earlier_one() {
        let folder = folder();
        run(&args(folder.path(), "a", 1, Form::Csv)).expect("simulated");
        run(&args(folder.path(), "a", 1, Form::Parquet)).expect("simulated");
        let runs = runs_in(&folder.path().join("a")).expect("runs");
        assert!(
            runs.len() == 2 && runs.iter().all(|run| run.path.extension().is_some_and(|e| e == "parquet"))
        );
        Recording::read(&runs[1].path, Strictness::Strict).expect("strict");
    }

    #[test]
    fn bad_input_ends_with_code_2_and_writes_nothing() {
        let folder = folder();
        std::fs::write(folder.path().join("v.toml"), DEFAULT_VEHICLE.replace("mass_kg = 4", "mass_kg = -4"))
            .expect("v");
        let error = run(&args(folder.path(), "a", 1, Form::Csv)).expect_err("negative mass");
        assert!(error.code() == 2 && error.to_string().contains("body.mass_kg"), "{error}");
        let absent = Args { scenario: "nowhere.toml".to_owned(), ..args(folder.path(), "a", 1, Form::Csv) };
        assert_eq!(run(&absent).expect_err("absent").code(), 2);
        assert!(!folder.path().join("a").exists());
    }

    #[test]
    fn recordings_that_no_simulation_made_are_left_alone() {
        let folder = folder();
        for (file, text) in [("wagon99.dry.csv", "real"), ("vehicle.toml", "of somebody")] {
            let out = folder.path().join("real");
            std::fs::create_dir_all(&out).expect("folder");
            std::fs::write(out.join(file), text).expect("write");
            let error = run(&args(folder.path(), "real", 1, Form::Csv)).expect_err(file);
            assert!(error.code() == 2 && error.to_string().contains(file), "{error}");
            assert_eq!(std::fs::read_to_string(out.join(file)).expect("as it was"), text);
            std::fs::remove_dir_all(out).expect("removed");
        }
    }

    #[test]
    fn what_would_fill_the_memory_or_is_no_wagon_of_the_train_is_refused() {
        let folder = folder();
        for (from, to, word) in [
            ("duration_s = ", "duration_s = 99999", "MiB of memory"),
            ("[train]", "[[wagon]]\nnumber = 7\n[train]", "beyond the 2 wagons"),
        ] {
            assert!(SCENARIO.contains(from), "{SCENARIO}");
            std::fs::write(folder.path().join("short.toml"), SCENARIO.replace(from, to)).expect("scenario");
            let error = run(&args(folder.path(), "a", 1, Form::Csv)).expect_err(word);
            assert!(error.code() == 2 && error.to_string().contains(word), "{error}");
        }
    }

    #[test]
    fn every_vehicle_of_the_project_runs_the_demo() {
        let vehicles = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/vehicles");
        let mut scenario = Scenario::load("demo", Path::new("")).expect("built in");
        scenario.duration_s = 70.0;
        let mut count = 0;
        for entry in std::fs::read_dir(vehicles).expect("vehicles") {
            let file = entry.expect("entry").path();
            let vehicle = railgrip_settings::vehicle::load(&file).unwrap_or_else(|error| panic!("{error}"));
            let (runs, _) = simulate(&scenario, &[vehicle], 1).expect("simulated");
            let braked = runs[0].truth.mu_w.iter().copied().fold(0.0, f64::min);
            let slowest = runs[0].truth.v_m_s.iter().copied().fold(f64::INFINITY, f64::min);
            println!("{}: {}", file.display(), wagon_line(&runs[0]));
            assert!((-0.12..-0.06).contains(&braked) && slowest < 20.0, "{}", file.display());
            count += 1;
        }
        assert!(count >= 3);
    }

    #[test]
    fn only_its_own_files_are_replaced() {
        for name in ["wagon01.dry.csv", "wagon12.low.parquet", "wagon100.wet.csv"] {
            assert!(is_own(name), "{name}");
        }
        for name in
            ["wagon1.dry.csv", "wagon01.csv", "wagon01.dry.csv.bak", "stop.dry.csv", "wagon01.ice.csv"]
        {
            assert!(!is_own(name), "{name}");
        }
    }
}
