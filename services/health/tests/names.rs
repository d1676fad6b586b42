//! One name for one thing: in the live API, in the history, in Prometheus and on the dashboards.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

use railgrip_health::api::metrics;
use railgrip_health::history::{HistoryStatus, columns};
use railgrip_health::shared::Build;
use railgrip_health::store::{Snapshot, Store};
use railgrip_indicators::INDICATORS;
use railgrip_messages::{Grade, Health, Heartbeat, Indicator, ProcessKind, SourceState, Stamp};
use railgrip_settings::{Overrides, TrainSettings};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const NOW: Stamp = Stamp { unix_ns: 1_772_366_400_000_000_000, monotonic_ns: 1_000_000_000_000 };

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A train of which everything is known.
fn snapshot() -> Snapshot {
    let file = root().join("config/railgrip.toml");
    let mut store = Store::new(&TrainSettings::load(Some(&file), &Overrides::default()).unwrap());
    let judged = |value: f64| Indicator {
        value,
        low: value - 0.01,
        high: value + 0.01,
        grade: Grade::Ok.code(),
        known: 1,
        reason: "known".into(),
    };
    for tenth in 0..1800_u64 {
        let monotonic_ns = NOW.monotonic_ns - (1800 - tenth) * 100_000_000;
        let pressed = tenth % 300 > 20 && tenth % 300 < 150;
        for wagon in 1..=8 {
            let mut health =
                Health { wagon, wheelsets: 2, samples: 100, missed: 1, v_m_s: 20.0, ..Health::default() };
            health.acquired = Stamp { monotonic_ns, ..NOW };
            health.published_monotonic_ns = monotonic_ns;
            health.brake_applications = (tenth + 279) / 300;
            health.brake_applied.monotonic_ns = monotonic_ns - (tenth % 300) * 100_000_000;
            health.pressing_force_n = if pressed { 60e3 } else { 0.0 };
            for spec in INDICATORS.iter() {
                spec.put(&mut health, judged(0.3));
                (0..2).for_each(|index| spec.put_wheelset(&mut health, index, judged(0.3)));
            }
            let now = Stamp { monotonic_ns, ..NOW };
            assert!(store.receive_health(wagon, &health, now).is_some());
        }
        store.snapshot(Stamp { monotonic_ns, ..NOW });
    }
    let beat = Heartbeat {
        process: ProcessKind::Estimator.code(),
        wagon: 1,
        stamp: NOW,
        step_p50_ns: 1,
        step_p99_ns: 2,
        latency_p50_ns: 3,
        latency_p99_ns: 4,
        ..Heartbeat::default()
    };
    assert!(store.receive_heartbeat(&beat, NOW).is_some());
    let source = SourceState {
        stamp: NOW,
        wagon: 1,
        drift_known: 1,
        drift_ppm: 600.0,
        counts: [7; 24],
        ..SourceState::default()
    };
    assert!(store.receive_source(&source, NOW));
    store.snapshot(NOW)
}

/// Names of the metrics of that train.
fn metric_names() -> BTreeSet<String> {
    let status = HistoryStatus { written_until_unix_s: Some(1), ..HistoryStatus::default() };
    let text = metrics::text(&snapshot(), 1, Some(&status), Build::default());
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.map(|line| line.split(['{', ' ']).next().unwrap().to_owned()).collect()
}

#[test]
fn every_metric_of_the_table_is_served() {
    let served = metric_names();
    for spec in INDICATORS.iter() {
        let Some(metric) = spec.metric else { continue };
        let total = if metric.counter { "_total" } else { "" };
        let own = format!("railgrip_{}{total}", metric.name);
        let needed = metric.counter || metric.reach.wagon();
        assert!(!needed || served.contains(&own), "{own} is missing in {served:?}");
        let of_wheelset = format!("railgrip_wheelset_{}", metric.name);
        let needed = !metric.counter && metric.reach.wheelsets();
        assert!(!needed || served.contains(&of_wheelset), "{of_wheelset} is missing in {served:?}");
    }
}

#[test]
fn rules_and_dashboards_name_metrics_that_there_are() {
    let served = metric_names();
    let files =
        ["prometheus/railgrip.rules.yml", "prometheus/railgrip.rules.test.yml", "grafana/railgrip.json"];
    for file in files {
        let text = std::fs::read_to_string(root().join("deploy").join(file)).unwrap();
        let words = text.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_'));
        let named: BTreeSet<&str> = words.filter(|word| word.starts_with("railgrip_")).collect();
        assert!(named.len() > 5, "{file}: {named:?}");
        for name in named {
            assert!(served.contains(name), "{file} names {name}, which is not served: {served:?}");
        }
    }
}

#[test]
fn the_history_calls_everything_as_the_live_api_does() {
    let wagon = serde_json::to_value(&snapshot().wagons[0]).unwrap();
    let in_present =
        |view: &Value, field: &str| view.get(field).is_some() || view["now"].get(field).is_some();
    for column in columns::all(2) {
        let found = match column.wheelset {
            None => in_present(&wagon, &column.name),
            Some(index) => {
                let field = column.name.split_once('.').unwrap().1;
                in_present(&wagon["wheelsets"][index], field)
            }
        };
        assert!(found, "the history has {}, the live API does not: {wagon}", column.name);
    }
}

#[test]
fn a_unit_stands_in_the_name_of_every_field_that_has_one() {
    for column in columns::all(2) {
        let suffix = match column.unit {
            "" => continue,
            "m/s" => "_m_s".to_owned(),
            unit => format!("_{}", unit.to_lowercase()),
        };
        assert!(column.name.ends_with(&suffix), "{} is in {}", column.name, column.unit);
    }
}

#[test]
fn what_older_versions_kept_is_read_under_the_names_of_today() {
    let former = columns::former(&columns::all(2));
    let now_of = |then: &str| former.iter().find(|name| name.then == then).map(|name| name.now.as_str());
    for (then, now) in [
        ("speed", "v_m_s"),
        ("position", "position_m"),
        ("braking", "braking_s"),
        ("pressing_force", "pressing_force_n"),
        ("response", "response_s"),
        ("response.low", "response_s.low"),
        ("dragging", "dragging_n"),
        ("dragging.high", "dragging_n.high"),
        ("wheelset_2.slide_energy", "wheelset_2.slide_energy_j"),
        ("wheelset_1.slide_time", "wheelset_1.slide_s"),
    ] {
        assert_eq!(now_of(then), Some(now), "{then}");
    }
}
