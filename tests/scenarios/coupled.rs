//! A coupled train through real processes: wagons that are well are left alone, one fault makes one alert at its place, and
//! everything that is shown says the same. The trains come from the plant that judges alarms, which shares no formula with
//! what is tested.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

use railgrip_tests::{TrainUnderTest, program, within};
use railgrip_truth_plant::train::{FaultWish, TrainOrder, TrainSpec, files};
use serde_json::Value;

railgrip_requirements::tests! {
    at_once = Some(1);
    a_healthy_coupled_train_raises_nothing: [],
    a_dragging_brake_is_one_alert_at_its_wagon: [],
}

const PATIENCE: Duration = Duration::from_secs(20);
/// Seconds of the run in one second.
const SPEED: f64 = 20.0;
const HOURS: f64 = 0.5;
const SEED: u64 = 20_261_122;

/// Eight coupled wagons on disk, with the fault of that kind on wagon 3 or none; its folder.
fn train(folder: &Path, fault: Option<&str>) -> PathBuf {
    let order = TrainOrder {
        coupled: Some(true),
        family: Some("coaches"),
        wagons: Some(8),
        hours: HOURS,
        rate_hz: 20.0,
        fault: fault.map_or(FaultWish::None, FaultWish::Of),
    };
    let mut spec = TrainSpec::draw_to(SEED, &order).expect("a train");
    if let Some(fault) = &mut spec.fault {
        (fault.wagon, fault.wheelset, fault.size) = (2, 1, 0.25);
        fault.onset_s = 0.4 * HOURS * 3600.0;
    }
    let at = folder.join("eight");
    files::write_train("eight", &at, &folder.join("truth"), spec).expect("written");
    at
}

/// What the interface said while the train ran: every alert that was raised, in the order of their numbers.
struct Said {
    alerts: Vec<Value>,
    train: Value,
    wagons: Vec<Value>,
}

/// Plays a train to just before its end, and kills its judge once an alert stands, if asked to. At no time may the banner be
/// better than the alerts that it counts.
fn play(recorded: &Path, kills: bool) -> Said {
    let config = "schema = 1\n[train]\nname = \"x\"\nwagons = 1\nvehicle = \"none.toml\"\n[source]\nkind = \"simulate\"\n";
    let speed = SPEED.to_string();
    let options = ["--train", &recorded.display().to_string(), "--speed", &speed].map(str::to_owned);
    let options: Vec<&str> = options.iter().map(String::as_str).collect();
    let mut train = TrainUnderTest::new(program!(), config).with(&options);
    train.start();
    train.wait_ready(PATIENCE);
    let begun = Instant::now();
    let http = train.http().expect("an address");
    let length = Duration::from_secs_f64(HOURS * 3600.0 / SPEED - 4.0);
    let (mut last, mut to_kill) = (Value::Null, kills);
    while begun.elapsed() < length {
        last = within(PATIENCE, || http.json("/api/v1/train")).expect("the train");
        let worst = match (&last["alerts"]["act"], &last["alerts"]["watch"]) {
            (act, _) if act.as_u64() > Some(0) => &["act"][..],
            (_, watch) if watch.as_u64() > Some(0) => &["watch", "act"],
            _ => &["ok", "unknown", "watch", "act"],
        };
        let grade = last["grade"].as_str().unwrap_or_default();
        assert!(worst.contains(&grade), "banner {grade} beside alerts {}", last["alerts"]);
        if to_kill && (last["alerts"]["act"].as_u64() > Some(0) || last["alerts"]["watch"].as_u64() > Some(0))
        {
            to_kill = false;
            outlived(&train, last["brakings_judged"].as_u64());
        }
        std::thread::sleep(Duration::from_millis(300));
    }
    let list = http.json("/api/v1/alerts?limit=100").expect("alerts");
    let mut alerts = list["alerts"].as_array().cloned().unwrap_or_default();
    alerts.sort_by_key(|alert| alert["id"].as_u64());
    let wagons = (1..=8).map(|id| http.json(&format!("/api/v1/wagons/{id}")).expect("a wagon")).collect();
    assert!(train.stop().success(), "{}", train.log());
    println!("judged {} applications; alerts {alerts:#?}", last["brakings_judged"]);
    assert!(!to_kill, "nothing was found, so that the judge was never killed");
    Said { alerts, train: last, wagons }
}

/// Kills the judge; its successor knows the applications that it had judged, to within the one that ran.
fn outlived(train: &TrainUnderTest, judged: Option<u64>) {
    // What was found is kept within seconds.
    std::thread::sleep(Duration::from_secs(6));
    let judge = train.process("judge");
    judge.kill();
    let successor = train.successor(&judge);
    assert_ne!(successor.pid, judge.pid);
    let http = train.http().expect("an address");
    let known = || http.json("/api/v1/train").filter(|view| view["brakings_judged"].as_u64() >= judged);
    let view = within(PATIENCE, known).expect("the successor has begun anew");
    println!("judged {judged:?} applications before it was killed, {} after", view["brakings_judged"]);
    assert!(judged > Some(0));
}

/// Causes and wagons of the alerts that the same train raises offline.
fn replayed(recorded: &Path) -> Vec<(String, Value)> {
    let json = recorded.with_extension("json");
    let mut replay = Command::new(program!());
    replay.args(["drill", "replay"]).arg(recorded).arg("--json").arg(&json);
    assert!(replay.status().expect("start").success());
    let alerts: Vec<Value> =
        serde_json::from_str(&std::fs::read_to_string(&json).expect("alerts")).expect("JSON");
    let told =
        |alert: &Value| (alert["cause"].as_str().unwrap_or_default().to_owned(), alert["wagon"].clone());
    alerts.iter().map(told).collect()
}

fn a_healthy_coupled_train_raises_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let recorded = train(folder.path(), None);
    assert_eq!(replayed(&recorded), vec![]);
    let said = play(&recorded, false);
    assert_eq!(said.alerts, Vec::<Value>::new());
    assert!(said.train["brakings_judged"].as_u64() > Some(3), "{}", said.train);
    for wagon in &said.wagons {
        assert!(matches!(wagon["grade"].as_str(), Some("ok")), "{}: {}", wagon["id"], wagon["reason"]);
    }
}

fn a_dragging_brake_is_one_alert_at_its_wagon() {
    let folder = tempfile::tempdir().expect("a folder");
    let recorded = train(folder.path(), Some("hand_brake"));
    let offline = replayed(&recorded);
    let said = play(&recorded, true);
    let [alert] = &said.alerts[..] else { panic!("{} alerts instead of one", said.alerts.len()) };
    assert_eq!((alert["cause"].as_str(), alert["wagon"].as_u64()), (Some("dragging"), Some(3)));
    // The brake holds the first bogie; its two wheelsets are what may be named.
    let wheelsets = alert["wheelsets"].as_array().cloned().unwrap_or_default();
    assert!((1..=2).contains(&wheelsets.len()) && wheelsets.iter().all(|k| k.as_u64() <= Some(2)), "{alert}");
    assert_eq!(offline.len(), 1, "{offline:?}");
    assert_eq!((offline[0].0.as_str(), &offline[0].1), ("dragging", &said.wagons[2]["vehicle_number"]));
    let worst: Vec<u64> = said.train["worst"]
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(|wagon| wagon["id"].as_u64())
        .collect();
    assert_eq!(worst, [3], "{}", said.train);
    assert_eq!(said.train["grade"], alert["grade_now"]);
    for wheelset in said.wagons[2]["wheelsets"].as_array().into_iter().flatten() {
        let accused = wheelsets.contains(&wheelset["id"]);
        assert_eq!(wheelset["grade"] == alert["grade_now"], accused, "{wheelset}");
    }
}
