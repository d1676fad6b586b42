//! A train that is made up anew: what is remembered goes with the vehicle numbers, and a wagon without one starts fresh and says so.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::time::Duration;

use railgrip_tests::{TrainUnderTest, program, within};

const PATIENCE: Duration = Duration::from_secs(30);

fn config(numbers: &[&str]) -> String {
    let vehicle = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/vehicle.toml");
    let wagons: String = numbers
        .iter()
        .map(|number| match *number {
            "" => "[[wagon]]\n".to_owned(),
            number => format!("[[wagon]]\nnumber = \"{number}\"\n"),
        })
        .collect();
    format!(
        "schema = 1\n[train]\nname = \"consist\"\nvehicle = \"{vehicle}\"\n[source]\nkind = \"simulate\"\nscenario = \"demo\"\n\
         speed = 4.0\n[history]\nflush_s = 0.5\n[logging]\nlevel = \"info\"\nformat = \"text\"\n{wagons}"
    )
}

/// Samples that the history of the wagon at a place holds of the latest ten minutes.
fn remembered(train: &TrainUnderTest, place: u32) -> u64 {
    let path = format!("/api/v1/wagons/{place}/history?from=10m&step=1s&fields=v_m_s");
    let view = train.http().and_then(|http| http.json(&path)).unwrap_or_default();
    view["samples"].as_array().into_iter().flatten().filter_map(serde_json::Value::as_u64).sum()
}

#[test]
fn memory_follows_the_vehicle_through_a_new_order_and_length() {
    let mut train = TrainUnderTest::new(program!(), &config(&["51 80 1", "51 80 2", "", ""]));
    train.start();
    train.wait_ready(PATIENCE);
    let enough = within(PATIENCE, || (remembered(&train, 2) > 20).then_some(()));
    assert!(enough.is_some(), "{}", train.log());
    assert!(train.stop().success());
    let first = train.log();
    assert!(first.contains("estimator has started"), "{first}");

    std::fs::write(train.folder().join("train.toml"), config(&["51-80-2", "", "51 80 1", "", ""]))
        .expect("write");
    train.start();
    train.wait_ready(PATIENCE);
    let log = train.log();
    let second = &log[first.len()..];
    let says = |wagon: u32, words: &str| {
        second.lines().any(|line| line.contains(&format!("wagon={wagon}")) && line.contains(words))
    };
    for (wagon, words) in [
        (1, "goes on from a snapshot"),
        (2, "the wagon has no vehicle number"),
        (3, "goes on from a snapshot"),
        (4, "without a vehicle number it may be of another wagon"),
    ] {
        assert!(says(wagon, words), "wagon {wagon}: {words}\n{second}");
    }
    // Vehicle 2 brings its history along, read by its new place; so does the number that the interface shows.
    assert!(remembered(&train, 1) > 20);
    let view = train.http().and_then(|http| http.json("/api/v1/wagons/1")).expect("wagon 1");
    assert_eq!(view["vehicle_number"], "51-80-2");
    assert!(train.stop().success());
}
