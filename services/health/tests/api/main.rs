//! The HTTP interface without a socket and without channels.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

mod alerts;
mod described;
mod live;
mod stream;

use axum::body::Body;
use axum::http::{Request, StatusCode, header};
use http_body_util::BodyExt;
use railgrip_health::api::router;
use railgrip_health::shared::Shared;
use railgrip_health::store::Store;
use railgrip_indicators::indicator::{BRAKE_FRICTION, RAIL, SLIDES};
use railgrip_messages::{Grade, Health, Indicator, Stamp};
use railgrip_settings::{Overrides, TrainSettings};
use serde_json::Value;
use std::path::Path;
use tower::ServiceExt;

const NOW: Stamp = Stamp { unix_ns: 1_772_366_400_000_000_000, monotonic_ns: 100_000_000_000 };

fn settings() -> TrainSettings {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/railgrip.toml");
    TrainSettings::load(Some(&file), &Overrides::default()).unwrap()
}

fn later(seconds: f64) -> Stamp {
    let ns = (seconds * 1e9) as i64;
    Stamp { unix_ns: NOW.unix_ns + ns, monotonic_ns: NOW.monotonic_ns.saturating_add_signed(ns) }
}

fn indicator(value: f64, grade: Grade, reason: &str) -> Indicator {
    Indicator {
        value,
        low: value - 0.01,
        high: value + 0.01,
        grade: grade.code(),
        known: 1,
        reason: reason.into(),
    }
}

/// A wagon in which everything is ok.
fn health(wagon: u32, acquired: Stamp) -> Health {
    let mut health = Health {
        wagon,
        wheelsets: 2,
        acquired,
        published_monotonic_ns: acquired.monotonic_ns,
        samples: 100,
        v_m_s: 20.0,
        mu_w: -0.1,
        grade: Grade::Ok.code(),
        condition_probability: [0.7, 0.3, 0.0, 0.0],
        ..Health::default()
    };
    BRAKE_FRICTION.put(&mut health, indicator(0.35, Grade::Ok, "as it should be"));
    RAIL.put(&mut health, indicator(0.7, Grade::Ok, "adhesion is not low"));
    for index in 0..2 {
        BRAKE_FRICTION.put_wheelset(&mut health, index, indicator(0.35, Grade::Ok, "as it should be"));
        SLIDES.put_wheelset(&mut health, index, indicator(0.0, Grade::Ok, "none"));
    }
    health
}

/// Eight wagons, all live and ok.
fn sound_train() -> Store {
    let mut store = Store::new(&settings());
    (1..=8).for_each(|wagon| assert!(store.receive_health(wagon, &health(wagon, NOW), NOW).is_some()));
    store
}

fn serve(store: &mut Store, at: Stamp) -> (axum::Router, Shared) {
    let shared = Shared::new(store.snapshot(at), || NOW);
    (router(shared.clone()), shared)
}

async fn get(router: &axum::Router, path: &str) -> (StatusCode, String, String) {
    let request = Request::get(path).body(Body::empty()).unwrap();
    let response = router.clone().oneshot(request).await.unwrap();
    let kind = response.headers().get(header::CONTENT_TYPE).map(|kind| kind.to_str().unwrap().to_owned());
    let status = response.status();
    let body = response.into_body().collect().await.unwrap().to_bytes();
    (status, kind.unwrap_or_default(), String::from_utf8(body.to_vec()).unwrap())
}

async fn get_json(router: &axum::Router, path: &str) -> Value {
    let (status, kind, body) = get(router, path).await;
    assert_eq!((status, kind.as_str()), (StatusCode::OK, "application/json"), "{path}: {body}");
    serde_json::from_str(&body).unwrap()
}
