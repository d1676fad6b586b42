//! The papers' rigs live: motor currents at 1 kHz, a braked wheelset on rollers and a braked bogie with its load cell and
//! torque transducer, through ingest, estimator and record.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::Duration;

use railgrip_tests::{TrainUnderTest, program, within};

const SECOND: Duration = Duration::from_secs(1);
/// Length of a round, s: the drive accelerates at 5 s, brakes are applied at 3.5 s and at 2 s.
const ROUND_S: f64 = 6.0;

fn railgrip(words: &[&str], paths: &[&Path]) -> Output {
    let output = Command::new(program!()).args(words).args(paths).output().expect("start the program");
    assert!(output.status.success(), "{words:?}: {}", String::from_utf8_lossy(&output.stderr));
    output
}

/// A rig's folder as `railgrip simulate` writes it, its recording cut to one round.
fn rig(folder: &Path, scenario: &str) -> PathBuf {
    let out = folder.join(scenario);
    railgrip(&["simulate", "--scenario", scenario, "--seed", "5", "--out"], &[&out]);
    let run = out.join(format!("{scenario}.csv"));
    let text = std::fs::read_to_string(&run).expect("recording");
    let in_round = |line: &&str| {
        line.split(',').next().and_then(|time| time.parse::<f64>().ok()).is_none_or(|time_s| time_s < ROUND_S)
    };
    let cut: Vec<&str> = text.lines().filter(in_round).collect();
    std::fs::write(&run, cut.join("\n") + "\n").expect("cut");
    run
}

#[test]
fn rigs_are_estimated_live_as_offline_bit_for_bit() {
    let folder = tempfile::tempdir().expect("folder");
    let names = ["zhao-water-4", "schwarz-sanding", "shrestha-wet-proposed"];
    let runs = names.map(|name| rig(folder.path(), name));
    let config = format!(
        "schema = 1\n[train]\nname = \"rigs\"\n[source]\nkind = \"replay\"\nruns = {:?}\nloop = true\n\
         [logging]\nformat = \"text\"\n",
        runs.each_ref().map(|run| run.display().to_string())
    );
    let mut train = TrainUnderTest::new(program!(), &config);
    train.start();
    train.wait_ready(30 * SECOND);
    let out = folder.path().join("out");
    // Two rounds and their pauses: one of them is seen from its first sample to its last.
    let said = train.run(&["record", "--for", "22", "--out", &out.display().to_string()]);
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    println!("{}", String::from_utf8_lossy(&said.stdout));
    for (name, run) in names.iter().zip(&runs) {
        let offline = folder.path().join(format!("{name}.offline.csv"));
        let rig_file = run.with_file_name("rig.toml");
        railgrip(&["estimate", "--out"], &[&offline, run, Path::new("--vehicle"), &rig_file]);
        let read = |path: &Path| {
            std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
        };
        let samples = read(run);
        assert_eq!(
            read(&out.join(format!("{name}-2.csv"))),
            samples,
            "{name}: what was recorded is what was played"
        );
        let (live, offline) = (read(&out.join(format!("estimates/{name}-2.csv"))), read(&offline));
        assert_eq!(live.lines().count(), samples.lines().count(), "{name}: one estimate a sample");
        let differs = live.lines().zip(offline.lines()).position(|(live, offline)| live != offline);
        assert_eq!(differs, None, "{name}: first line that differs");
        println!("{name}: {} estimates equal the offline ones to the last bit", live.lines().count() - 1);
    }
    assert!(train.stop().success());
}

#[test]
fn the_traction_rigs_config_runs_the_unscented_filter_at_a_kilohertz() {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config").canonicalize().expect("config");
    let text = std::fs::read_to_string(repository.join("zhao.toml")).expect("config/zhao.toml");
    let text = text.replace("rigs/zhao.toml", &repository.join("rigs/zhao.toml").display().to_string());
    let mut train = TrainUnderTest::new(program!(), &text);
    train.start();
    train.wait_ready(30 * SECOND);
    let wagon = || train.http().and_then(|http| http.json("/api/v1/wagons/1"));
    let known = within(20 * SECOND, || {
        let wagon = wagon()?;
        let value = wagon["adhesion_available"]["value"].as_f64()?;
        let seen = wagon["adhesion_available"]["reason"].as_str()?.contains("observable");
        (seen && (value - 0.28).abs() < 0.03).then_some(value)
    });
    println!("μ0 of the clean surface, live: {known:?}");
    assert!(known.is_some(), "{:#?}\n{}", wagon(), train.log());
    let folder = train.folder().join("out");
    let said = train.run(&["record", "--for", "3", "--out", &folder.display().to_string()]);
    let said = String::from_utf8_lossy(&said.stdout).into_owned();
    println!("{said}");
    let rows = std::fs::read_to_string(folder.join("ukf.csv")).expect("recorded").lines().count() - 1;
    assert!(rows >= 2500, "{rows} samples in 3 s: {said}");
    assert!(train.stop().success());
}

#[test]
fn the_bogie_rigs_config_tells_adhesion_and_hears_its_rail() {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config").canonicalize().expect("config");
    let text = std::fs::read_to_string(repository.join("shrestha.toml")).expect("config/shrestha.toml");
    let text =
        text.replace("rigs/shrestha.toml", &repository.join("rigs/shrestha.toml").display().to_string());
    let text = text.replace("speed = 1.0", "speed = 4.0");
    let mut train = TrainUnderTest::new(program!(), &text);
    train.start();
    train.wait_ready(30 * SECOND);
    let wagon = || train.http().and_then(|http| http.json("/api/v1/wagons/1"));
    // Brakes come 15 s after the start, and the dry rail then gives about 0.4.
    let known = within(30 * SECOND, || {
        let wagon = wagon()?;
        let utilised = wagon["adhesion_utilised"].as_f64().or(wagon["adhesion_utilised"]["value"].as_f64())?;
        let heard = wagon["acoustic"]["state"] == "heard";
        ((0.3..0.5).contains(&utilised) && heard).then(|| (utilised, wagon["acoustic"].clone()))
    });
    println!("adhesion utilised and acoustic, live: {known:?}");
    assert!(known.is_some(), "{:#?}\n{}", wagon(), train.log());
    let folder = train.folder().join("out");
    let said = train.run(&["record", "--for", "3", "--out", &folder.display().to_string()]);
    println!("{}", String::from_utf8_lossy(&said.stdout));
    let recorded = std::fs::read_to_string(folder.join("bogie.csv")).expect("recorded");
    assert!(recorded.starts_with("t_s,shaft_torque_nm,load_cell_n,brake_pressure_pa,load_n,roller_pulses"));
    assert!(recorded.lines().count() > 900, "{} rows", recorded.lines().count());
    assert!(train.stop().success());
}
