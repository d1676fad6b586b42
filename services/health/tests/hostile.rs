//! Messages that no process should send: each is refused and counted, or shown for what it is. None makes the service
//! panic, none makes old data pass for present, and what is unknown stays empty.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may end at what it does not expect, and prints"
)]

use axum::body::Body;
use axum::http::Request;
use bytemuck::Pod;
use http_body_util::BodyExt;
use proptest::prelude::*;
use railgrip_causes::Cause;
use railgrip_health::api::router;
use railgrip_health::shared::Shared;
use railgrip_health::store::Store;
use railgrip_indicators::indicator::{ADHESION_AVAILABLE, BRAKE_FRICTION, RAIL};
use railgrip_messages::{
    Condition, Grade, Health, Heard, HearingState, Heartbeat, Indicator, ProcessKind, SourceState, Stamp,
    Verdict, Verdicts,
};
use railgrip_settings::{Overrides, TrainSettings};
use serde_json::Value;
use std::path::Path;
use tower::ServiceExt;

const NOW: Stamp = Stamp { unix_ns: 1_772_366_400_000_000_000, monotonic_ns: 100_000_000_000 };
/// Everything is stale then.
const LATER: Stamp =
    Stamp { unix_ns: NOW.unix_ns + 6_000_000_000, monotonic_ns: NOW.monotonic_ns + 6_000_000_000 };
const WAGONS: u32 = 4;
/// What a word of eight bytes becomes.
const HOSTILE: [u64; 14] = [
    0x7ff8_0000_0000_0000, // NaN
    0xfff8_0000_0000_0001, // another
    0x7ff0_0000_0000_0000, // infinity
    0xfff0_0000_0000_0000, // minus infinity
    1,                     // the smallest subnormal number
    0x8000_0000_0000_0001, // the same, negative
    0,
    u64::MAX, // also two codes of u32::MAX, and text that is no UTF-8
    u64::MAX >> 1,
    0x7fe0_0000_0000_0000, // 9e307
    0xffe0_0000_0000_0000,
    0x0000_0063_0000_0063, // two codes of 99
    0x0000_0001_0000_0001, // two flags
    0xff80_c0fe_ff80_c0fe, // text that is no UTF-8
];

fn store() -> Store {
    store_of("")
}

/// A store of a train that is judged as a whole, or not.
fn store_of(train: &str) -> Store {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/railgrip.toml");
    let text = format!(
        "schema = 1\n[train]\nname = \"hostile\"\nwagons = {WAGONS}\nvehicle = \"vehicle.toml\"\n{train}[source]\nkind = \"simulate\"\nscenario = \"demo\"\nseed = 7\n\
         [[microphone]]\nwagon = 3\nrig = \"track\"\n"
    );
    Store::new(&TrainSettings::parse(&file, &text, &Overrides::default()).unwrap())
}

fn judged(value: f64) -> Indicator {
    let reason = "as it should be".into();
    Indicator { value, low: value - 0.01, high: value + 0.01, grade: Grade::Ok.code(), known: 1, reason }
}

fn health(wagon: u32, at: Stamp) -> Health {
    let mut health = Health {
        wagon,
        wheelsets: 2,
        acquired: at,
        published_monotonic_ns: at.monotonic_ns,
        samples: 100,
        v_m_s: 20.0,
        mu_w: -0.1,
        mu_w_sigma: 0.01,
        position_m: 1000.0,
        grade: Grade::Ok.code(),
        condition_probability: [0.7, 0.3, 0.0, 0.0],
        adhesion_available_is_bound: 1,
        ..Health::default()
    };
    for (spec, value) in [(&BRAKE_FRICTION, 0.35), (&ADHESION_AVAILABLE, 0.2), (&RAIL, 0.7)] {
        spec.put(&mut health, judged(value));
    }
    (0..2).for_each(|index| BRAKE_FRICTION.put_wheelset(&mut health, index, judged(0.35)));
    health
}

fn heard(at: Stamp) -> Heard {
    Heard {
        acquired: at,
        published_monotonic_ns: at.monotonic_ns,
        wagon: 3,
        state: HearingState::Heard.code(),
        condition: Condition::Wet.code(),
        known: 1,
        wet_probability: 0.9,
        decided: 1,
        sample_rate_hz: 44_100,
        ..Heard::default()
    }
}

fn beat(at: Stamp) -> Heartbeat {
    Heartbeat {
        stamp: at,
        process: ProcessKind::Estimator.code(),
        wagon: 3,
        pid: 7,
        uptime_s: 5.0,
        ..Heartbeat::default()
    }
}

fn verdicts(at: Stamp) -> Verdicts {
    let mut all =
        Verdicts { sequence: 7, stamp: at, time_s: 30.0, count: 2, wagons: WAGONS, ..Verdicts::default() };
    for (number, wagon) in [(1, 3), (2, 4)] {
        let mut verdict = Verdict { number, probability: 0.9, found_t_s: 12.0, ..Verdict::default() };
        (verdict.cause, verdict.grade) = (Cause::Dragging.code(), Grade::Watch.code());
        verdict.reason = "a brake drags".into();
        verdict.add_wagon(wagon);
        all.verdict[number as usize - 1] = verdict;
    }
    all
}

/// A train in which everything is well.
fn sound() -> Store {
    with_wagons(store())
}

fn with_wagons(mut store: Store) -> Store {
    for wagon in 1..=WAGONS {
        assert!(store.receive_health(wagon, &health(wagon, NOW), NOW).is_some());
    }
    assert!(store.receive_heard(3, &heard(NOW), NOW).is_some());
    assert!(store.receive_heartbeat(&beat(NOW), NOW).is_some());
    store
}

/// Writes hostile words into a message.
fn spoil<T: Pod>(message: &mut T, words: &[(usize, usize)]) {
    let bytes = bytemuck::bytes_of_mut(message);
    for (place, hostile) in words {
        let from = (place % (bytes.len() / 8)) * 8;
        bytes[from..from + 8].copy_from_slice(&HOSTILE[hostile % HOSTILE.len()].to_ne_bytes());
    }
}

/// Everything that the service says at that instant: JSON by path, then metrics and pages as text.
fn said(store: &mut Store, at: Stamp) -> (Value, String) {
    let clock: fn() -> Stamp = if at == NOW { || NOW } else { || LATER };
    let router = router(Shared::new(store.snapshot(at), clock));
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let ask = async |path: &str| {
            let response =
                router.clone().oneshot(Request::get(path).body(Body::empty()).unwrap()).await.unwrap();
            assert!(matches!(response.status().as_u16(), 200 | 503), "{path}: {}", response.status());
            String::from_utf8(response.into_body().collect().await.unwrap().to_bytes().to_vec()).unwrap()
        };
        let mut all = serde_json::Map::new();
        for path in [
            "/health/ready",
            "/api/v1/train",
            "/api/v1/train/capability",
            "/api/v1/train/adhesion-map",
            "/api/v1/wagons",
            "/api/v1/wagons/3",
            "/api/v1/alerts",
        ] {
            all.insert(path.to_owned(), serde_json::from_str(&ask(path).await).unwrap());
        }
        let metrics = ask("/metrics").await;
        for path in ["/", "/wagons/3", "/alerts"] {
            ask(path).await;
        }
        (Value::Object(all), metrics)
    })
}

/// What must hold whatever was sent for wagon 3: what is unknown is empty, and six seconds later nothing is live.
fn check(store: &mut Store) -> Result<(), TestCaseError> {
    let (all, metrics) = said(store, NOW);
    prop_assert!(!metrics.contains("NaN") && !metrics.contains("inf\n"), "{metrics}");
    let wagon = &all["/api/v1/wagons/3"];
    let figures = wagon
        .as_object()
        .unwrap()
        .values()
        .chain(wagon["wheelsets"][0].as_object().into_iter().flat_map(|set| set.values()));
    for figure in figures.filter(|figure| figure.get("grade").is_some() && figure.get("value").is_some()) {
        let ends = [&figure["low"], &figure["high"]];
        prop_assert!(ends.iter().all(|end| end.is_null() == figure["value"].is_null()), "{figure}");
    }
    let capability = &all["/api/v1/train/capability"]["stops"][0];
    prop_assert!(capability["distance_m"].is_number(), "{capability}");
    let (all, metrics) = said(store, LATER);
    prop_assert_eq!(&all["/health/ready"]["status"], "not ready");
    prop_assert_eq!(&all["/api/v1/train"]["live"], 0);
    for row in all["/api/v1/wagons"]["wagons"].as_array().unwrap() {
        prop_assert!(row["state"] != "live" && row["v_m_s"].is_null() && row["grade"] == "unknown", "{row}");
        prop_assert!(row["age_s"].as_f64().unwrap() >= 6.0, "{row}");
    }
    prop_assert_eq!(&all["/api/v1/wagons/3"]["now"], &Value::Null);
    prop_assert_eq!(&all["/api/v1/wagons/3"]["acoustic"]["wet_probability"], &Value::Null);
    prop_assert_eq!(&all["/api/v1/train/capability"]["grade"], "unknown");
    prop_assert!(metrics.contains("railgrip_wagon_up{wagon=\"3\"} 0.0"), "{metrics}");
    Ok(())
}

fn refused(store: &mut Store, at: Stamp) -> Vec<(String, String, u64)> {
    let snapshot = store.snapshot(at);
    let refused = snapshot.train.refused.iter();
    refused.map(|one| (one.payload.clone(), one.reason.clone(), one.count)).collect()
}

#[test]
fn an_interval_that_is_not_a_number_is_refused_and_nothing_panics() {
    let mut store = sound();
    let mut bad = health(3, NOW);
    let mut available = *ADHESION_AVAILABLE.of(&bad);
    (available.low, available.high) = (f64::NAN, f64::NAN);
    ADHESION_AVAILABLE.put(&mut bad, available);
    assert!(store.receive_health(3, &bad, NOW).is_none());
    assert_eq!(refused(&mut store, NOW), [("health".to_owned(), "not_finite".to_owned(), 1)]);
    let (all, metrics) = said(&mut store, NOW);
    assert_eq!(all["/api/v1/wagons/3"]["adhesion_available"]["value"], 0.2, "the message before stands");
    assert!(
        metrics.contains("railgrip_payloads_refused_total{payload=\"health\",reason=\"not_finite\"} 1.0"),
        "{metrics}"
    );
}

#[test]
fn a_stamp_from_the_future_freezes_no_wagon() {
    let mut store = sound();
    let ahead = Health { published_monotonic_ns: u64::MAX, ..health(3, NOW) };
    assert!(store.receive_health(3, &ahead, NOW).is_none());
    let acquired = Stamp { monotonic_ns: u64::MAX, ..NOW };
    assert!(store.receive_health(3, &Health { acquired, ..health(3, NOW) }, NOW).is_none());
    assert_eq!(refused(&mut store, NOW), [("health".to_owned(), "future_stamp".to_owned(), 2)]);
    let (all, _) = said(&mut store, LATER);
    assert_eq!(
        (&all["/api/v1/wagons/3"]["state"], &all["/api/v1/wagons/3"]["age_s"]),
        (&"stale".into(), &6.0.into())
    );
    // The wagon goes on as soon as a sound message comes.
    assert!(store.receive_health(3, &health(3, LATER), LATER).is_some());
    let (all, _) = said(&mut store, LATER);
    assert_eq!(all["/api/v1/wagons/3"]["state"], "live");
}

#[test]
fn a_message_about_another_wagon_than_its_channel_is_refused() {
    let mut store = sound();
    assert!(store.receive_health(3, &health(2, NOW), NOW).is_none());
    let stranger = Heartbeat { wagon: 4_000_000_000, ..beat(NOW) };
    assert!(store.receive_heartbeat(&stranger, NOW).is_none());
    let words: Vec<String> =
        refused(&mut store, NOW).into_iter().map(|(payload, why, _)| format!("{payload} {why}")).collect();
    assert_eq!(words, ["health wrong_wagon", "heartbeat wrong_wagon"]);
}

/// A train of another length is another train: what is said of it is of none of these wagons.
#[test]
fn verdicts_about_a_longer_train_are_refused() {
    let mut store = with_wagons(store_of("coupled = true\n"));
    let mut longer = Verdicts { wagons: 99, ..verdicts(NOW) };
    longer.verdict[0].add_wagon(90);
    assert!(!store.receive_verdicts(&longer, NOW));
    assert_eq!(refused(&mut store, NOW), [("verdicts".to_owned(), "wrong_wagon".to_owned(), 1)]);
    assert!(store.receive_verdicts(&verdicts(NOW), NOW));
}

#[test]
fn what_a_sound_message_does_not_know_stays_empty() {
    let mut store = sound();
    let unknown = Health {
        v_m_s: f64::NAN,
        mu_w: f64::NAN,
        position_m: f64::NAN,
        pressing_force_n: f64::NAN,
        samples: 0,
        condition: u32::MAX,
        ..health(3, NOW)
    };
    assert!(store.receive_health(3, &unknown, NOW).is_some());
    let (all, metrics) = said(&mut store, NOW);
    let wagon = &all["/api/v1/wagons/3"];
    assert_eq!(wagon["state"], "live");
    for empty in ["v_m_s", "position_m", "adhesion"] {
        assert_eq!(wagon["now"][empty], Value::Null, "{empty}");
    }
    assert_eq!((&wagon["rail_dry"], &wagon["condition"]), (&Value::Null, &Value::Null));
    assert!(!metrics.contains("railgrip_wagon_speed_meters_per_second{wagon=\"3\"}"), "{metrics}");
    assert!(!metrics.contains("railgrip_rail_condition_probability_ratio{wagon=\"3\""), "{metrics}");
}

fn settings(cases: u32) -> ProptestConfig {
    let rng_seed = proptest::test_runner::RngSeed::Fixed(29);
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(cases);
    ProptestConfig { cases, rng_seed, failure_persistence: None, ..ProptestConfig::default() }
}

/// Places and hostile words.
fn words() -> impl Strategy<Value = Vec<(usize, usize)>> {
    prop::collection::vec((any::<usize>(), any::<usize>()), 1..4)
}

proptest! {
    #![proptest_config(settings(200))]

    #[test]
    fn no_message_of_indicators_does_harm(words in words()) {
        let mut store = sound();
        let mut bad = health(3, NOW);
        spoil(&mut bad, &words);
        let _ = store.receive_health(3, &bad, NOW);
        check(&mut store)?;
    }

    #[test]
    fn no_message_of_a_microphone_does_harm(words in words()) {
        let mut store = sound();
        let mut bad = heard(NOW);
        spoil(&mut bad, &words);
        let _ = store.receive_heard(3, &bad, NOW);
        check(&mut store)?;
    }

    #[test]
    fn no_verdict_does_harm(words in words()) {
        let mut store = with_wagons(store_of("coupled = true\n"));
        prop_assert!(store.receive_verdicts(&verdicts(NOW), NOW));
        let mut bad = verdicts(NOW);
        spoil(&mut bad, &words);
        let _ = store.receive_verdicts(&bad, NOW);
        check(&mut store)?;
    }

    #[test]
    fn no_state_of_a_source_does_harm(words in words()) {
        let mut store = sound();
        let good = SourceState { sequence: 1, stamp: NOW, wagon: 3, drift_ppm: 12.0, drift_known: 1, ..SourceState::default() };
        prop_assert!(store.receive_source(&good, NOW));
        let mut bad = good;
        spoil(&mut bad, &words);
        let _ = store.receive_source(&bad, NOW);
        check(&mut store)?;
    }

    #[test]
    fn no_heartbeat_does_harm(words in words()) {
        let mut store = sound();
        let mut bad = beat(NOW);
        spoil(&mut bad, &words);
        let _ = store.receive_heartbeat(&bad, NOW);
        check(&mut store)?;
    }
}
