//! An indicator of one's own, as the README of the crate of the indicators shows it: a spec with its judge. In the crate it
//! would stand in a file of its own below `indicator/`, with the line `&indicator::STANDING_BRAKED,` in the table; here it
//! goes into a table of the test, and everything that loops over the table follows.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

use axum::body::Body;
use axum::http::Request;
use http_body_util::BodyExt;
use railgrip_health::api::router;
use railgrip_health::history::columns;
use railgrip_health::limits::Limits;
use railgrip_health::shared::Shared;
use railgrip_health::store::Store;
use railgrip_indicators::indicator::judging::{known, large};
use railgrip_indicators::{
    Advice, AlertRule, Form, INDICATORS, IndicatorSettings, IndicatorSpec, Judge, Limit, Meaning, Metric,
    Reach, Table, Unit, WagonIndicators,
};
use railgrip_messages::{Estimate, Grade, Health, Sample, Stamp, valid};
use railgrip_settings::{Overrides, TrainSettings};
use serde_json::Value;
use std::path::Path;
use tower::ServiceExt;

const WATCH_S: f64 = 60.0;
const ACT_S: f64 = 600.0;

/// Time for which the wagon has stood with its brakes applied.
pub static STANDING_BRAKED: IndicatorSpec = IndicatorSpec {
    id: "standing_braked",
    unit: Unit::Seconds,
    form: Form::SECONDS,
    judge: Judge {
        take: Some(|memory, now| {
            let pressed = now.sample.pressing_force_n.iter().any(|force_n| *force_n > 2000.0);
            let stands = now.estimate.v_m_s.abs() < 0.1;
            memory[0] = if stands && pressed { memory[0] + now.dt_s } else { 0.0 };
        }),
        wagon: Some(|_, memory| {
            let seconds = memory[0];
            let grade = large(seconds, WATCH_S, ACT_S);
            known(seconds, seconds, seconds, grade, &format!("stands braked for {seconds:.0} s"))
        }),
        ..Judge::NONE
    },
    limit: Some(|_, _| Limit::above(1.2 * ACT_S, WATCH_S, ACT_S)),
    alert: Some(AlertRule::of(
        "standing_braked",
        Reach::Wagon,
        Advice::same("Ask whether the train waits or was left with its brakes on."),
    )),
    trend: Reach::Wagon,
    metric: Some(Metric::gauge("standing_braked_seconds", "Time for which the wagon has stood braked")),
    meaning: Meaning {
        name: "Stands braked",
        definition: "Time for which the wagon has stood with its brakes applied.",
        unit: "s",
        cannot_see: "Why it stands.",
        ..Meaning::PLAIN
    },
    ..IndicatorSpec::PLAIN
};

const NOW: Stamp = Stamp { unix_ns: 1_772_366_400_000_000_000, monotonic_ns: 1_000_000_000_000 };

/// The table of the program with one line more.
fn table() -> Table {
    let all: Vec<&'static IndicatorSpec> = INDICATORS.iter().chain([&STANDING_BRAKED]).collect();
    Table(all.leak())
}

/// What a wagon says that has stood braked for 100 s.
fn standing(table: Table, settings: &TrainSettings, acquired: Stamp) -> Health {
    let nominal = railgrip_settings::nominal(&settings.wagons[0].vehicle);
    let mut indicators = WagonIndicators::with(table, 1, IndicatorSettings::default(), nominal);
    let pressed = valid::SPEED | valid::pressing_force(0) | valid::pressing_force(1);
    let sample = Sample {
        wheelsets: 2,
        valid: pressed,
        pressing_force_n: [30e3, 30e3, 0.0, 0.0],
        ..Sample::default()
    };
    for step in 0..1001_u32 {
        let time_s = 0.1 * f64::from(step);
        let estimate =
            Estimate { time_s, sequence: u64::from(step), wheelsets: 2, acquired, ..Estimate::default() };
        indicators.update(&sample, &estimate, &mut |_| {});
    }
    indicators.health()
}

async fn get(router: &axum::Router, path: &str) -> String {
    let request = Request::get(path).body(Body::empty()).unwrap();
    let response = router.clone().oneshot(request).await.unwrap();
    let body = response.into_body().collect().await.unwrap().to_bytes();
    String::from_utf8(body.to_vec()).unwrap()
}

async fn json(router: &axum::Router, path: &str) -> Value {
    serde_json::from_str(&get(router, path).await).unwrap()
}

#[tokio::test]
async fn an_indicator_of_ones_own_follows_everywhere_from_one_entry() {
    let table = table();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/railgrip.toml");
    let settings = TrainSettings::load(Some(&file), &Overrides::default()).unwrap();
    let mut store = Store::with(table, &settings);
    // A symptom must last until it counts.
    let mut shown = None;
    for second in 0..10_u64 {
        let at = Stamp {
            unix_ns: NOW.unix_ns + 1_000_000_000 * second as i64,
            monotonic_ns: NOW.monotonic_ns + 1_000_000_000 * second,
        };
        let mut health = standing(table, &settings, at);
        health.published_monotonic_ns = at.monotonic_ns;
        assert!(store.receive_health(1, &health, at).is_some());
        shown = Some((store.snapshot(at), health));
    }
    let (snapshot, health) = shown.unwrap();

    let judged = table.wagon(&health, &STANDING_BRAKED);
    assert_eq!((judged.grade(), judged.value.round()), (Grade::Watch, 100.0), "{}", judged.reason);

    let alert = snapshot.alerts.alerts.iter().find(|alert| alert.cause == "standing_braked").unwrap();
    assert_eq!((alert.wagon, alert.advice.as_str()), (1, STANDING_BRAKED.alert.unwrap().advice.wagon));

    let columns = columns::of(table, 2);
    let column = columns.iter().find(|column| column.name == "standing_braked_s").unwrap();
    assert_eq!((column.unit, column.read(&health)[0].round()), ("s", 100.0));

    let shared = Shared::new(snapshot, || NOW);
    shared.judge_by(Limits::of(&settings).with(table));
    let router = router(shared);
    let wagon = json(&router, "/api/v1/wagons/1").await;
    assert_eq!(wagon["standing_braked_s"]["grade"], "watch", "{wagon}");
    let api = json(&router, "/openapi.json").await;
    let form = &api["components"]["schemas"]["WagonView"]["properties"]["standing_braked_s"];
    assert_eq!(form["description"], STANDING_BRAKED.meaning.definition, "{form}");
    let metrics = get(&router, "/metrics").await;
    assert!(metrics.contains("railgrip_standing_braked_seconds{wagon=\"1\"} 100"), "{metrics}");
    let page = get(&router, "/wagons/1").await;
    assert!(page.contains("Stands braked for") && page.contains("/indicators#standing-braked"));
    let meaning = get(&router, "/indicators").await;
    assert!(meaning.contains("id=\"standing-braked\"") && meaning.contains("Why it stands."));
}
