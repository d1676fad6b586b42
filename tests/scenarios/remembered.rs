//! What a train remembers outlives the processes that know it, and what the model does not explain is told and kept.
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use railgrip_tests::{TrainUnderTest, program, within};
use serde_json::Value;
use std::time::Duration;

const PATIENCE: Duration = Duration::from_secs(60);
/// A diagnosis has the lowest priority, beside whatever tests run.
const DIAGNOSIS: Duration = Duration::from_secs(900);

fn config(name: &str, more: &str) -> String {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../config");
    format!(
        "schema = 1\n[train]\nname = \"{name}\"\nvehicle = \"{folder}/vehicle.toml\"\n[source]\nkind = \"simulate\"\n\
         scenario = \"{folder}/scenarios/demo.toml\"\nspeed = 4.0\n[logging]\nlevel = \"info\"\nformat = \"text\"\n{more}"
    )
}

fn cells(train: &TrainUnderTest) -> Vec<Value> {
    let map = train.http().and_then(|http| http.json("/api/v1/train/adhesion-map"));
    map.and_then(|map| map["cells"].as_array().cloned()).unwrap_or_default()
}

#[test]
fn the_adhesion_map_outlives_a_killed_service() {
    let more = "[[wagon]]\n[[wagon]]\n[capability]\nmap_save_s = 0.5\n[history]\nflush_s = 0.5\n";
    let mut train = TrainUnderTest::new(program!(), &config("map", more));
    train.start();
    train.wait_ready(PATIENCE);
    let passed = |cell: &&Value| cell["age_s"].as_f64().is_some_and(|age_s| age_s > 4.0);
    let before = within(PATIENCE, || {
        let behind: Vec<Value> = cells(&train).iter().filter(passed).cloned().collect();
        (behind.len() >= 5).then_some(behind)
    });
    let before = before.expect("cells that the train has left behind");
    let health = train.process("health");
    health.kill();
    let _ = train.successor(&health);
    train.wait_ready(PATIENCE);
    let after = within(PATIENCE, || Some(cells(&train)).filter(|cells| !cells.is_empty())).expect("a map");
    println!(
        "{} cells behind the train before, {} cells after the service was killed",
        before.len(),
        after.len()
    );
    for cell in &before {
        let same = after.iter().find(|other| other["from_m"] == cell["from_m"]);
        let same = same.unwrap_or_else(|| panic!("forgotten: {cell}"));
        assert_eq!((&same["wagons"], &same["slides"]), (&cell["wagons"], &cell["slides"]), "{cell}");
        let [a, b] = [cell, same].map(|cell| cell["age_s"].as_f64().expect("an age"));
        assert!((0.0..30.0).contains(&(b - a)), "it has aged by {} s", b - a);
    }
    assert!(train.stop().success());
}

#[test]
fn what_the_model_lacks_raises_an_alert_with_a_suspect_and_a_recording() {
    let more = "[[wagon]]\n[[wagon]]\nsimulated = \"real.toml\"\n";
    let mut train = TrainUnderTest::new(program!(), &config("lacks", more));
    let plain = include_str!("../../config/vehicle.toml");
    let effect =
        "[[effect]]\nid = \"brake_lag\"\nparameters = { time_constant_s = 1.0, dead_time_s = 0.3 }\n";
    let real = train.folder().join("real.toml");
    std::fs::write(&real, format!("{plain}\n{effect}")).expect("write the vehicle");
    train.start();
    train.wait_ready(PATIENCE);
    let found = || {
        let list = train.http().and_then(|http| http.json("/api/v1/alerts"))?;
        let all = list["alerts"].as_array()?.clone();
        assert!(!all.iter().any(|alert| alert["cause"] == "sensors"), "every sensor is sound: {all:?}");
        let of_model = all.into_iter().filter(|alert| alert["cause"] == "filter");
        of_model.into_iter().find(|alert| alert["evidence"]["recording"].is_string())
    };
    let alert = within(4 * PATIENCE, found).unwrap_or_else(|| panic!("no alert:\n{}", train.log()));
    println!("{}", alert["reason"]);
    assert_eq!((&alert["wagons"], &alert["scope"]), (&serde_json::json!([2]), &"wagon".into()), "{alert}");
    assert!(
        alert["reason"].as_str().is_some_and(|words| words.contains("suspect brake actuation")),
        "{alert}"
    );
    assert!(alert["advice"].as_str().is_some_and(|words| words.contains("gap diagnose")), "{alert}");
    let case = std::path::PathBuf::from(alert["evidence"]["recording"].as_str().unwrap_or_default());
    assert!(case.join("vehicle.toml").is_file() && case.join("fit").is_dir(), "{}", case.display());
    // Minutes later the answer joins the alert by itself, and the report can be read.
    let id = alert["id"].as_u64().expect("a number");
    let diagnosed = || {
        let alert = train.http().and_then(|http| http.json(&format!("/api/v1/alerts/{id}")))?;
        Some(alert["evidence"]["diagnosis"].clone()).filter(Value::is_object)
    };
    let diagnosis = within(DIAGNOSIS, diagnosed).unwrap_or_else(|| panic!("no diagnosis:\n{}", train.log()));
    println!("{diagnosis}");
    let named: Vec<&str> =
        diagnosis["effects"].as_array().into_iter().flatten().filter_map(|it| it["id"].as_str()).collect();
    assert_eq!(named.first(), Some(&"brake_lag"), "{diagnosis}");
    let page = train.http().and_then(|http| http.get(&format!("/api/v1/alerts/{id}/report")));
    assert!(
        page.is_some_and(|(status, page)| status == 200 && page.contains("brake lag")),
        "the whole report"
    );
    assert!(train.stop().success());
}
