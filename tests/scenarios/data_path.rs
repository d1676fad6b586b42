//! From sensors to indicators through real processes: what arrives at the end agrees with what went in.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use railgrip_tests::{Process, Table, TrainUnderTest, program, within};
use rustix::process::Signal;
use serde_json::Value;

const SECOND: Duration = Duration::from_secs(1);

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().expect("the repository")
}

fn config(name: &str, wagons: u32, source: &str) -> String {
    let vehicle = repository().join("config/vehicle.toml");
    format!(
        "schema = 1\n[train]\nname = \"{name}\"\nwagons = {wagons}\nvehicle = \"{}\"\n[source]\n{source}\n\
         [logging]\nlevel = \"info\"\nformat = \"text\"\n",
        vehicle.display()
    )
}

fn scenario(name: &str) -> String {
    format!(
        "kind = \"simulate\"\nscenario = \"{}\"",
        repository().join("config/scenarios").join(name).display()
    )
}

/// Recordings of the demo train with the truth beside them, and a train that replays them once.
fn replay_of_the_demo(folder: &Path, speed: f64) -> TrainUnderTest {
    let runs = folder.join("runs");
    let output = std::process::Command::new(program!())
        .args(["simulate", "--scenario", "demo", "--seed", "11", "--out"])
        .arg(&runs)
        .output()
        .expect("simulate");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let source =
        format!("kind = \"replay\"\nruns = [\"{}\"]\nspeed = {speed:?}\nloop = false", runs.display());
    let text = config("replayed", 8, &source).replace("wagons = 8\n", "");
    TrainUnderTest::new(program!(), &text)
}

/// Processes that were started one by one, as systemd would; killed when dropped.
struct Started(Vec<(String, Child)>);

impl Started {
    fn start(&mut self, train: &TrainUnderTest, words: &[&str]) {
        let name = words.join("-").replace('/', "_");
        let log = std::fs::File::create(train.folder().join(format!("log-{name}"))).expect("log");
        let mut command = train.command(words);
        let child = command.stdout(Stdio::null()).stderr(log).spawn().expect("start");
        self.0.push((name, child));
    }

    fn says(&self, train: &TrainUnderTest, name: &str, words: &str) {
        let log = train.folder().join(format!("log-{name}"));
        let said = within(20 * SECOND, || {
            std::fs::read_to_string(&log).ok().filter(|text| text.contains(words)).map(|_| ())
        });
        assert!(said.is_some(), "{name} never said \"{words}\": {:?}", std::fs::read_to_string(&log));
    }

    /// Waits until a process ends.
    fn wait(&mut self, name: &str, patience: Duration) {
        let child =
            self.0.iter_mut().find(|(other, _)| other == name).map(|(_, child)| child).expect("started");
        let status = within(patience, || child.try_wait().ok().flatten());
        assert!(status.is_some_and(|status| status.success()), "{name}: {status:?}");
    }

    fn stop(&mut self, name: &str) {
        let child = self.0.iter().find(|(other, _)| other == name).map(|(_, child)| child).expect("started");
        Process { pid: child.id().cast_signed(), role: name.into() }.signal(Signal::TERM);
        self.wait(name, 10 * SECOND);
    }
}

impl Drop for Started {
    fn drop(&mut self) {
        for (_, child) in &mut self.0 {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// Replays the demo through holder, estimators and ingest, and records what comes out.
fn recorded_demo(train: &TrainUnderTest, out: &Path) {
    let mut started = Started(Vec::new());
    started.start(train, &["hold"]);
    started.says(train, "hold", "channels exist");
    for wagon in 1..=8 {
        started.start(train, &["estimator", "--wagon", &wagon.to_string()]);
    }
    for wagon in 1..=8 {
        started.says(train, &format!("estimator---wagon-{wagon}"), "estimator has started");
    }
    let out_words = out.display().to_string();
    let record = ["record", "--out", &out_words];
    let record_name = record.join("-").replace('/', "_");
    started.start(train, &record);
    started.says(train, &record_name, "recording");
    started.start(train, &["ingest"]);
    started.wait("ingest", 60 * SECOND);
    std::thread::sleep(SECOND);
    started.stop(&record_name);
}

/// Below this speed, m/s, a creepage means little, and adhesion at standstill is not what anybody asks for.
const MOVING_M_S: f64 = 1.0;
/// Pads that press less than this, N, say nothing about their friction.
const BRAKING_N: f64 = 5e3;

/// Errors of one wagon while it moves.
struct Errors {
    adhesion_rms: f64,
    adhesion_far: f64,
    friction_rms: f64,
}

/// Compares estimates with the truth, row by row: adhesion of the wagon, and from 3 s of a brake application on its pad
/// friction, weighted with the pressing forces.
fn errors(estimates: &Table, truth: &Table, run: &Table) -> Errors {
    let [time, speed] = ["t_s", "v_m_s"].map(|name| truth.column(name));
    let (mut adhesion, mut friction) = (Vec::new(), Vec::new());
    let mut released_s = 0.0;
    for row in 0..truth.rows() {
        assert!((estimates.column("t_s")[row] - time[row]).abs() < 1e-6, "row {row} is of another instant");
        let forces = ["f", "r"].map(|side| run.column(&format!("f_perp_{side}_n"))[row]);
        if forces.iter().sum::<f64>() < BRAKING_N {
            released_s = time[row];
        }
        if time[row] < 3.0 || speed[row] < MOVING_M_S {
            continue;
        }
        adhesion.push(estimates.column("mu_w")[row] - truth.column("mu_w")[row]);
        if time[row] - released_s > 3.0 {
            let mean = |table: &Table| {
                let [front, rear] = ["mu_b_f", "mu_b_r"].map(|name| table.column(name)[row]);
                (front * forces[0] + rear * forces[1]) / (forces[0] + forces[1])
            };
            friction.push(mean(estimates) - mean(truth));
        }
    }
    friction.retain(|error| error.is_finite());
    assert!(adhesion.len() > 10_000 && friction.len() > 1000, "{} {}", adhesion.len(), friction.len());
    let rms =
        |errors: &[f64]| (errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt();
    let far = adhesion.iter().filter(|error| error.abs() > 0.02).count();
    Errors {
        adhesion_rms: rms(&adhesion),
        adhesion_far: far as f64 / adhesion.len() as f64,
        friction_rms: rms(&friction),
    }
}

#[test]
fn eight_wagons_agree_with_truth_and_with_the_offline_estimator() {
    let folder = tempfile::tempdir().expect("folder");
    let train = replay_of_the_demo(folder.path(), 20.0);
    let out = folder.path().join("out");
    let started = Instant::now();
    recorded_demo(&train, &out);
    println!("replayed and recorded in {:.1} s", started.elapsed().as_secs_f64());
    for wagon in 1..=8 {
        let name = format!("wagon{wagon:02}.dry");
        let run = folder.path().join(format!("runs/{name}.csv"));
        let live = Table::read(&out.join(format!("estimates/{name}.csv")));
        assert_eq!(
            live.rows(),
            Table::read(&run).rows(),
            "wagon {wagon}: every sample must give one estimate"
        );
        let truth = Table::read(&folder.path().join(format!("runs/truth/{name}.csv")));
        let errors = errors(&live, &truth, &Table::read(&run));
        let Errors { adhesion_rms, adhesion_far, friction_rms } = errors;
        let far_percent = adhesion_far * 100.0;
        println!(
            "wagon {wagon}: RMSE adhesion {adhesion_rms:.5} ({far_percent:.3} % off by more than 0.02), pads {friction_rms:.4}"
        );
        assert!(adhesion_rms <= 0.004 && adhesion_far <= 0.001, "wagon {wagon}: adhesion");
        assert!(friction_rms <= 0.015, "wagon {wagon}: pad friction");
        if wagon % 4 == 1 {
            equals_offline(&train, &run, &live, folder.path());
        }
        equals_recording(&Table::read(&out.join(format!("{name}.csv"))), &Table::read(&run));
    }
}

/// The live estimates are those of `railgrip estimate`, to the last bit.
fn equals_offline(train: &TrainUnderTest, run: &Path, live: &Table, folder: &Path) {
    let out = folder.join("offline.csv");
    let output = std::process::Command::new(program!())
        .arg("estimate")
        .arg(run)
        .arg("--vehicle")
        .arg(folder.join("runs/vehicle.toml"))
        .arg("--config")
        .arg(train.folder().join("train.toml"))
        .arg("--out")
        .arg(&out)
        .output()
        .expect("estimate");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let offline = Table::read(&out);
    assert_eq!(live.names(), offline.names());
    for name in offline.names() {
        let differs = |(a, b): (&f64, &f64)| a != b && !(a.is_nan() && b.is_nan());
        let first = live.column(name).iter().zip(offline.column(name)).position(differs);
        assert_eq!(first, None, "{name} differs first in this row: {}", run.display());
    }
    println!("{}: {} estimates equal the offline ones to the last bit", run.display(), offline.rows());
}

/// What was recorded from the channels is what was replayed onto them.
fn equals_recording(recorded: &Table, original: &Table) {
    assert_eq!(recorded.rows(), original.rows());
    for name in original.names() {
        assert!(recorded.column(name) == original.column(name), "{name} changed on its way");
    }
}

/// The wagons as the service shows them.
fn wagons(train: &TrainUnderTest) -> Vec<Value> {
    let list = train.http().and_then(|http| http.json("/api/v1/wagons"));
    list.and_then(|list| list["wagons"].as_array().cloned()).unwrap_or_default()
}

#[test]
fn low_adhesion_of_one_wagon_is_found_on_that_wagon_alone() {
    let source = format!("{}\nspeed = 4.0", scenario("one_wagon_low.toml"));
    let text = config("one-low", 8, &source);
    let mut train = TrainUnderTest::new(program!(), &text);
    train.start();
    train.wait_ready(20 * SECOND);
    let mut low = BTreeSet::new();
    let started = Instant::now();
    // The braking that shows it lies between 5 s and 20 s of the scenario: 5 s of ours.
    while started.elapsed() < 12 * SECOND {
        for wagon in wagons(&train) {
            if wagon["condition"] == "low" || wagon["condition"] == "very_low" {
                low.insert(wagon["id"].as_u64().expect("id"));
            }
        }
        std::thread::sleep(Duration::from_millis(100));
    }
    println!("wagons that were called low: {low:?}");
    assert_eq!(low, BTreeSet::from([4]), "{:#?}", wagons(&train));
    assert!(train.stop().success());
}

#[test]
fn a_second_train_on_the_same_machine_is_not_seen() {
    let start = |wagons: u32| {
        let mut train = TrainUnderTest::new(program!(), &config("same-name", wagons, &scenario("demo.toml")));
        train.start();
        train
    };
    // The demo has eight wagons; the config may ask for fewer.
    let trains = [start(2), start(3)];
    for (train, count) in trains.iter().zip([2, 3]) {
        train.wait_ready(20 * SECOND);
        assert_eq!(wagons(train).len(), count);
    }
    for train in &trains {
        let own: BTreeSet<u64> =
            train.processes().iter().map(|process| u64::from(process.pid.unsigned_abs())).collect();
        let view = train.http().and_then(|http| http.json("/api/v1/train")).expect("train");
        let seen: BTreeSet<u64> = view["processes"]
            .as_array()
            .expect("processes")
            .iter()
            .filter_map(|process| process["pid"].as_u64())
            .collect();
        assert!(!seen.is_empty() && seen.is_subset(&own), "sees {seen:?}, has {own:?}");
    }
    // Killing one of everything in the first must not touch the second.
    let before = trains[1].processes();
    for process in trains[0].processes() {
        process.kill();
    }
    std::thread::sleep(SECOND);
    assert_eq!(trains[1].processes(), before);
    trains[1].wait_ready(SECOND);
}

#[test]
fn a_late_joiner_learns_the_last_value_and_its_age() {
    let mut train = TrainUnderTest::new(program!(), &config("late", 2, &scenario("demo.toml")));
    train.start();
    train.wait_ready(20 * SECOND);
    std::thread::sleep(2 * SECOND);
    let ingest = train.process("ingest");
    ingest.signal(Signal::STOP);
    std::thread::sleep(4 * SECOND);
    let health = train.process("health");
    let old_address = train.http();
    health.kill();
    let _ = train.successor(&health);
    drop(old_address);
    let learned = within(10 * SECOND, || {
        let wagons = wagons(&train);
        let known = wagons.iter().all(|wagon| wagon["age_s"].as_f64().is_some());
        (wagons.len() == 2 && known).then_some(wagons)
    });
    let learned = learned.unwrap_or_else(|| panic!("{:#?}\n{}", wagons(&train), train.log()));
    for wagon in &learned {
        println!("wagon {}: {} {} s old", wagon["id"], wagon["state"], wagon["age_s"]);
        assert_eq!(wagon["state"], "stale", "{wagon:#}");
        assert_eq!(wagon["grade"], "unknown", "stale data must not be judged: {wagon:#}");
        assert!(wagon["age_s"].as_f64().is_some_and(|age_s| age_s >= 3.9), "{wagon:#}");
    }
    let (status, why) = train.http().and_then(|http| http.get("/health/ready")).expect("an answer");
    assert_eq!(status, 503, "{why}");
    ingest.signal(Signal::CONT);
    train.wait_ready(10 * SECOND);
    assert!(train.stop().success());
}
