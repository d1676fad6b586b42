//! What the train says of itself meanwhile.

use crate::nonsense::Sent;
use railgrip_bus::{Bus, BusConfig};
use railgrip_messages::ProcessKind;
use railgrip_settings::{Overrides, TrainSettings};
use railgrip_tests::{TrainUnderTest, within};
use std::time::Duration;

/// Longest wait for anything.
pub const PATIENCE: Duration = Duration::from_secs(60);

/// The sum of the counts of a payload that metrics tell.
fn counted(metrics: &str, payload: &str) -> u64 {
    let line = format!("railgrip_payloads_refused_total{{payload=\"{payload}\"");
    let of_payload = metrics.lines().filter(|text| text.starts_with(&line));
    of_payload.filter_map(|text| text.rsplit(' ').next()?.parse::<f64>().ok()).sum::<f64>() as u64
}

/// Of each of these payloads the service counts what it refused, once; it may be a moment behind.
pub fn assert_counted(train: &TrainUnderTest, sent: &Sent, payloads: &[&str]) {
    for payload in payloads {
        let expected = sent.refused[payload];
        let metrics = || train.http()?.get("/metrics").map(|(_, text)| text);
        let told = || metrics().map(|text| counted(&text, payload));
        assert!(expected > 0, "nothing to refuse of {payload}");
        let all = within(PATIENCE, || told().filter(|told| *told >= expected));
        assert_eq!(all, Some(expected), "{payload}: {:?}\n{}", told(), train.log());
    }
}

/// The states of all wagons, front first.
pub fn states(train: &TrainUnderTest) -> Option<Vec<String>> {
    let wagons = train.http()?.json("/api/v1/wagons")?;
    let rows = wagons["wagons"].as_array()?.iter();
    Some(rows.map(|row| row["state"].as_str().unwrap_or("").to_owned()).collect())
}

/// How many samples or messages a process says it has refused.
pub fn rejected(train: &TrainUnderTest, process: &str, wagon: u32) -> Option<u64> {
    let view = train.http()?.json("/api/v1/train")?;
    let mut all = view["processes"].as_array()?.clone().into_iter();
    let is_it = |one: &serde_json::Value| one["process"] == process && (wagon == 0 || one["wagon"] == wagon);
    all.find(is_it)?["rejected"].as_u64()
}

/// The channels as a program of the same user sees them.
pub fn bus(train: &TrainUnderTest) -> Bus {
    let file = train.folder().join("train.toml");
    let overrides = Overrides { instance_dir: Some(train.instance()), ..Overrides::default() };
    let settings = TrainSettings::load(Some(&file), &overrides).expect("sound");
    Bus::open(BusConfig::of(&settings), ProcessKind::Record, 99).expect("a bus")
}

/// Waits until so many processes serve.
pub fn wait_serving(train: &TrainUnderTest, least: usize) {
    let serves = || train.http()?.json("/api/v1/train")?["processes"].as_array().map(Vec::len);
    let all = within(PATIENCE, || serves().filter(|processes| *processes >= least));
    assert!(all.is_some(), "{:?}\n{}", serves(), train.log());
}

/// In silence nothing of all that was sent looks live.
pub fn assert_stale(train: &TrainUnderTest) {
    let stale =
        within(PATIENCE, || states(train).filter(|states| states.iter().all(|state| state != "live")));
    assert!(stale.is_some(), "{:?}", states(train));
    let wagons = train.http().and_then(|http| http.json("/api/v1/wagons")).expect("wagons");
    let old = wagons["wagons"].as_array().expect("rows").iter();
    assert!(old.clone().all(|row| row["v_m_s"].is_null()), "{wagons}");
}
