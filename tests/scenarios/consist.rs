//! A train that is made up anew: what is remembered goes with the vehicle numbers, and a wagon without one starts fresh and says so.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::path::Path;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use railgrip_tests::{TrainUnderTest, program, within};
use serde_json::{Value, json};

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

/// What the service answers; one that is busy, or has just come back, is asked again.
fn get(train: &TrainUnderTest, path: &str) -> Value {
    within(PATIENCE, || train.http()?.json(path)).unwrap_or_else(|| panic!("{path}: {}", train.log()))
}

/// Samples that the history of the wagon at a place holds of the latest ten minutes, or of those before that second.
fn remembered(train: &TrainUnderTest, place: u32, before_s: Option<u64>) -> u64 {
    let to = before_s.map_or_else(String::new, |second| format!("&to={second}"));
    let view = get(train, &format!("/api/v1/wagons/{place}/history?from=10m{to}&step=1s&fields=v_m_s"));
    view["samples"].as_array().into_iter().flatten().filter_map(Value::as_u64).sum()
}

/// Waits for a second to begin, and says which: the history counts by the second.
fn next_second() -> u64 {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).expect("now");
    let next = Duration::from_secs(now.as_secs() + 1);
    std::thread::sleep(next - now);
    next.as_secs()
}

#[test]
fn memory_follows_the_vehicle_through_a_new_order_and_length() {
    let mut train = TrainUnderTest::new(program!(), &config(&["51 80 1", "51 80 2", "", ""]));
    train.start();
    train.wait_ready(PATIENCE);
    let enough = within(PATIENCE, || (remembered(&train, 2, None) > 20).then_some(()));
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
    assert!(remembered(&train, 1, None) > 20);
    assert_eq!(get(&train, "/api/v1/wagons/1")["vehicle_number"], "51-80-2");
    assert!(train.stop().success());
}

/// Two wagons whose pads rub far too little, one with a number and one without; then, in the same folder, sound ones. What is well
/// again is no alert that was forgotten: none ends by itself here, however long a busy machine takes.
fn with_pads(file: Option<&Path>) -> String {
    let simulated = file.map_or_else(String::new, |file| format!("simulated = \"{}\"\n", file.display()));
    let vehicle = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/vehicle.toml");
    format!(
        "schema = 1\n[train]\nname = \"fresh\"\nvehicle = \"{vehicle}\"\n[source]\nkind = \"simulate\"\nscenario = \"demo\"\n\
         speed = 4.0\n[history]\nflush_s = 0.5\n[alerts]\ngroup_least = 9\nclear_after_s = 3600\n[logging]\nlevel = \"info\"\nformat = \"text\"\n\
         [[wagon]]\nnumber = \"51 80 1\"\n{simulated}[[wagon]]\n{simulated}"
    )
}

#[test]
fn a_wagon_without_a_number_inherits_neither_alerts_nor_history_of_its_place() {
    let mut train = TrainUnderTest::new(program!(), "");
    let worn = train.folder().join("worn.toml");
    let sound = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../config/vehicle.toml"));
    let text =
        sound.expect("the vehicle").replace("friction_coefficient = 0.35", "friction_coefficient = 0.15");
    std::fs::write(&worn, text).expect("write the vehicle");
    let file = train.folder().join("train.toml");
    std::fs::write(&file, with_pads(Some(&worn))).expect("write");
    train.start();
    train.wait_ready(PATIENCE);
    let pads = |train: &TrainUnderTest| -> Vec<Value> {
        let all = get(train, "/api/v1/alerts")["alerts"].as_array().cloned().unwrap_or_default();
        all.into_iter().filter(|alert| alert["cause"] == "brake_friction").collect()
    };
    let both = within(3 * PATIENCE, || Some(pads(&train)).filter(|alerts| alerts.len() == 2));
    let both = both.unwrap_or_else(|| panic!("no alerts: {}", train.log()));
    let id =
        |wagon: u32| both.iter().find(|alert| alert["wagon"] == wagon).expect("of the wagon")["id"].clone();
    let (numbered, nameless) = (id(1), id(2));
    assert!(
        within(PATIENCE, || (remembered(&train, 2, None) > 20).then_some(())).is_some(),
        "{}",
        train.log()
    );

    // A process that is started again still knows the wagon: it is the same start of the train.
    let health = train.process("health");
    health.kill();
    let _ = train.successor(&health);
    train.wait_ready(PATIENCE);
    let known = within(PATIENCE, || Some(pads(&train)).filter(|alerts| !alerts.is_empty())).expect("alerts");
    assert!(known.iter().all(|alert| alert["active"] == true), "{known:?}");
    // Whoever is killed takes the last second along; whoever is stopped keeps all.
    let kept = remembered(&train, 1, None);
    let raised = get(&train, "/api/v1/alerts")["alerts"].as_array().cloned().expect("a list");
    let last_id = raised.iter().filter_map(|alert| alert["id"].as_u64()).max();
    assert!(train.stop().success());

    std::fs::write(&file, with_pads(None)).expect("write");
    let started_s = next_second();
    let before = train.log().len();
    train.start();
    train.wait_ready(PATIENCE);
    let get = |path: &str| get(&train, path);
    let now = pads(&train);
    let of = |id: &Value| now.iter().find(|alert| alert["id"] == *id).expect("kept").clone();
    assert_eq!(
        (&of(&numbered)["active"], &of(&numbered)["vehicle_number"]),
        (&true.into(), &"51 80 1".into())
    );
    let over = of(&nameless);
    assert_eq!((&over["active"], &over["wagons"]), (&false.into(), &json!([])), "{over}");
    let last = over["history"].as_array().and_then(|lines| lines.last()).cloned().unwrap_or_default();
    assert!(last["note"].as_str().is_some_and(|note| note.contains("without a vehicle number")), "{over}");
    // Of its own are those that were raised since; a busy machine may raise one of late news.
    let own = get("/api/v1/alerts?wagon=2")["alerts"].as_array().cloned().expect("a list");
    assert!(own.iter().all(|alert| alert["id"].as_u64() > last_id), "{own:?}");
    assert!(train.log()[before..].contains("wagons without one start fresh"), "{}", train.log());
    // What was kept before this start belongs to the number, and to nobody where there is none.
    let earlier = |place: u32| remembered(&train, place, Some(started_s));
    assert!(kept > 0 && earlier(1) >= kept, "{} of {kept} samples", earlier(1));
    assert_eq!(earlier(2), 0, "samples of another wagon");
    assert!(
        within(PATIENCE, || (remembered(&train, 2, None) > 0).then_some(())).is_some(),
        "its own are kept"
    );
    let of_place = get("/api/v1/events?wagon=2&limit=1000");
    let told = of_place["events"].as_array().cloned().unwrap_or_default();
    assert!(told.iter().all(|event| event["cause"] != "brake_friction"), "{told:?}");
    let all = get("/api/v1/events?limit=1000");
    let raised = |event: &&Value| event["kind"] == "alert_raised" && event["cause"] == "brake_friction";
    let whose: Vec<_> = all["events"].as_array().into_iter().flatten().filter(raised).collect();
    let whose: Vec<_> = whose.iter().map(|event| (&event["wagon"], &event["vehicle_number"])).collect();
    assert!(whose.contains(&(&1.into(), &"51 80 1".into())), "{whose:?}");
    assert!(whose.iter().all(|(wagon, number)| number.is_string() || wagon.is_null()), "{whose:?}");
    let status = String::from_utf8(train.run(&["status"]).stdout).expect("text");
    assert!(status.lines().any(|line| line.contains("wagon-1") && line.contains("51 80 1")), "{status}");
    assert!(train.stop().success());
}
