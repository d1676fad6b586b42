//! The HTTP interface without a socket and without channels.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

use axum::body::Body;
use axum::http::{Request, StatusCode, header};
use http_body_util::BodyExt;
use railgrip_health::api::router;
use railgrip_health::shared::{Shared, StreamEvent};
use railgrip_health::store::Store;
use railgrip_indicators::INDICATORS;
use railgrip_indicators::indicator::{BRAKE_FRICTION, RAIL, SLIDES};
use railgrip_messages::{
    Event, EventKind, Grade, Health, Heartbeat, Indicator, NO_WHEELSET, ProcessKind, Stamp, Text,
};
use railgrip_settings::{Overrides, TrainSettings};
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;
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

#[tokio::test]
async fn a_sound_train_is_ready_and_shown_as_present() {
    let (router, _) = serve(&mut sound_train(), later(0.1));
    assert_eq!(get(&router, "/health/live").await.0, StatusCode::OK);
    assert_eq!(get(&router, "/health/ready").await.0, StatusCode::OK);
    let train = get_json(&router, "/api/v1/train").await;
    assert_eq!((&train["ready"], &train["live"], &train["grade"]), (&true.into(), &8.into(), &"ok".into()));
    assert_eq!(train["generated_at"], "2026-03-01T12:00:00.100Z");
    let list = get_json(&router, "/api/v1/wagons").await;
    let wagon = &list["wagons"][2];
    assert_eq!(list["wagons"].as_array().unwrap().len(), 8);
    assert_eq!((&wagon["id"], &wagon["state"], &wagon["age_s"]), (&3.into(), &"live".into(), &0.1.into()));
    assert_eq!((&wagon["v_m_s"], &wagon["adhesion"]), (&20.0.into(), &(-0.1).into()));
    assert_eq!((&wagon["condition"], &wagon["brake_friction"]), (&"dry".into(), &0.35.into()));
    let wagon = get_json(&router, "/api/v1/wagons/3").await;
    assert_eq!(wagon["wheelsets"].as_array().unwrap().len(), 2);
    assert_eq!((&wagon["now"]["adhesion"], &wagon["brake_friction"]["low"]), (&(-0.1).into(), &0.34.into()));
    assert_eq!(get_json(&router, "/api/v1/alerts").await["alerts"], serde_json::json!([]));
}

#[tokio::test]
async fn a_silent_and_a_stale_wagon_are_named_and_never_shown_as_present() {
    let mut store = Store::new(&settings());
    (1..=7).for_each(|wagon| assert!(store.receive_health(wagon, &health(wagon, NOW), NOW).is_some()));
    let fresh = later(12.3);
    (1..=6).for_each(|wagon| assert!(store.receive_health(wagon, &health(wagon, fresh), fresh).is_some()));
    let (router, _) = serve(&mut store, fresh);
    let (status, _, body) = get(&router, "/health/ready").await;
    println!("{body}");
    assert_eq!(status, StatusCode::SERVICE_UNAVAILABLE);
    let reasons = serde_json::from_str::<Value>(&body).unwrap()["reasons"].clone();
    assert_eq!(reasons.as_array().unwrap().len(), 2);
    assert!(reasons[0].as_str().unwrap().contains("wagon 7 (wagon-7) is stale: no new data for 12 s"));
    assert!(reasons[1].as_str().unwrap().contains("wagon 8 (wagon-8) is silent"));

    let stale = get_json(&router, "/api/v1/wagons").await["wagons"][6].clone();
    assert_eq!(
        (&stale["state"], &stale["age_s"], &stale["grade"]),
        (&"stale".into(), &12.3.into(), &"unknown".into())
    );
    for present in ["v_m_s", "adhesion", "adhesion_available", "condition", "sliding", "wsp_active"] {
        assert_eq!(stale[present], Value::Null, "{present}");
    }
    let stale = get_json(&router, "/api/v1/wagons/7").await;
    assert_eq!((&stale["now"], &stale["wheelsets"][0]["now"]), (&Value::Null, &Value::Null));
    assert_eq!(stale["brake_friction"]["grade"], "unknown");
    assert!(stale["brake_friction"]["reason"].as_str().unwrap().starts_with("stale: no new data for 12 s"));
    let silent = get_json(&router, "/api/v1/wagons/8").await;
    assert_eq!((&silent["age_s"], &silent["acquired_at"]), (&Value::Null, &Value::Null));
    let (_, _, metrics) = get(&router, "/metrics").await;
    assert!(
        metrics.contains("railgrip_wagon_up{wagon=\"7\"} 0.0")
            && !metrics.contains("per_second{wagon=\"7\"}")
    );
    assert!(metrics.contains("railgrip_wagon_data_age_seconds{wagon=\"7\"} 12.3"));
}

/// Samples that the source withholds because of their units once were "no data: check the data connection", and a clock that
/// drifts reached nobody.
#[tokio::test]
async fn what_the_source_says_of_a_wagon_is_its_alert() {
    let mut store = sound_train();
    let event = |kind: EventKind, grade: Grade, wagon: u32, text: &str, now: Stamp| Event {
        stamp: now,
        kind: kind.code(),
        grade: grade.code(),
        wagon,
        wheelset: NO_WHEELSET,
        text: Text::new(text),
        ..Event::default()
    };
    let why = "samples withheld: column v_m_s cannot be in m/s";
    let drift = "the clock of the source drifts by 1000 parts in a million";
    let run = |store: &mut Store, from: f64, withheld: bool| {
        for tenth in 0..300 {
            let now = later(from + f64::from(tenth) * 0.1);
            for wagon in (1..=8).filter(|wagon| !withheld || *wagon != 2) {
                store.receive_health(wagon, &health(wagon, now), now).unwrap();
            }
            if tenth % 100 == 0 {
                let grade = if withheld { Grade::Act } else { Grade::Ok };
                store.receive_event(&event(EventKind::UnitsImplausible, grade, 2, why, now), now).unwrap();
                let grade = if withheld { Grade::Watch } else { Grade::Ok };
                store.receive_event(&event(EventKind::ClockDrifts, grade, 3, drift, now), now).unwrap();
            }
            let _ = store.snapshot(now);
        }
        later(from + 30.0)
    };
    let causes = |alerts: Value| -> Vec<(String, String)> {
        let text = |alert: &Value, key: &str| alert[key].as_str().unwrap_or_default().to_owned();
        let all = alerts["alerts"].as_array().unwrap().clone();
        all.iter()
            .filter(|alert| alert["active"] == true)
            .map(|a| (text(a, "cause"), text(a, "reason")))
            .collect()
    };
    let now = run(&mut store, 0.0, true);
    let (router, _) = serve(&mut store, now);
    let mut active = causes(get_json(&router, "/api/v1/alerts").await);
    active.sort();
    assert_eq!(active.len(), 2, "{active:?}");
    assert!(active[0].0 == "source_clock" && active[0].1.contains("1000 parts"), "{active:?}");
    assert!(active[1].0 == "units" && active[1].1.contains(why), "{active:?}");
    // A process that says what is none of its business is refused.
    let wrong =
        Event { values: [f64::NAN; 4], ..event(EventKind::UnitsImplausible, Grade::Act, 5, "x", now) };
    assert!(store.receive_event(&wrong, now).is_none());
    let wrong = event(EventKind::UnitsImplausible, Grade::Act, 99, "x", now);
    assert!(store.receive_event(&wrong, now).is_none());
    let wrong = Event { kind: 9999, ..wrong };
    assert!(store.receive_event(&wrong, now).is_none());
    let mut now = run(&mut store, 30.0, false);
    for minutes in 1..=4 {
        now = run(&mut store, 30.0 + 30.0 * f64::from(minutes), false);
    }
    let (router, _) = serve(&mut store, now);
    assert_eq!(causes(get_json(&router, "/api/v1/alerts").await), []);
}

#[tokio::test]
async fn a_bad_brake_becomes_one_alert_with_advice() {
    let mut store = sound_train();
    let mut news = Vec::new();
    for tenth in 0..40 {
        let now = later(f64::from(tenth) * 0.1);
        for wagon in 1..=8 {
            let mut health = health(wagon, now);
            if wagon == 5 {
                BRAKE_FRICTION.put_wheelset(&mut health, 1, indicator(0.2, Grade::Act, "far too low: 0.200"));
                health.grade = Grade::Act.code();
            }
            assert!(store.receive_health(wagon, &health, now).is_some());
        }
        news.extend(store.snapshot(now).news);
    }
    assert_eq!(news.len(), 1);
    let (router, _) = serve(&mut store, later(4.0));
    let alerts = get_json(&router, "/api/v1/alerts").await["alerts"].clone();
    println!("{alerts}");
    assert_eq!(alerts.as_array().unwrap().len(), 1);
    let alert = &alerts[0];
    assert_eq!(
        (&alert["wagon"], &alert["wheelset"], &alert["cause"]),
        (&5.into(), &2.into(), &"brake_friction".into())
    );
    assert_eq!((&alert["active"], &alert["grade"]), (&true.into(), &"act".into()));
    assert_eq!(alert["raised_at"], "2026-03-01T12:00:02.000Z");
    let train = get_json(&router, "/api/v1/train").await;
    assert_eq!((&train["grade"], &train["worst"][0]["id"]), (&"act".into(), &5.into()));
    assert_eq!(train["reason"], "wagon 5: Pad friction of wheelset 2: far too low: 0.200");
    assert_eq!(train["alerts"]["act"], 1);
    let (_, _, page) = get(&router, "/").await;
    assert!(page.contains("Wheelset 2: far too low: 0.200"), "{page}");
}

/// Eight wagons slide over one slippery stretch: that is no fault of theirs.
#[tokio::test]
async fn a_low_rail_is_one_alert_of_the_line_and_leaves_the_wagons_as_they_are() {
    let mut store = sound_train();
    let mut play = |from: u32, until: u32, rail: Indicator| {
        for tenth in from..until {
            let now = later(f64::from(tenth) * 0.1);
            for wagon in 1..=8 {
                let mut health = health(wagon, now);
                RAIL.put(&mut health, rail);
                health.grade = INDICATORS.worst(&health).code();
                assert!(store.receive_health(wagon, &health, now).is_some());
            }
            store.snapshot(now);
        }
        serve(&mut store, later(f64::from(until) * 0.1)).0
    };
    let router = play(0, 40, indicator(0.9, Grade::Watch, "adhesion is low: low 90 %, wet 10 %"));
    let alerts = get_json(&router, "/api/v1/alerts").await["alerts"].clone();
    assert_eq!(alerts.as_array().unwrap().len(), 1, "{alerts}");
    assert_eq!((&alerts[0]["scope"], &alerts[0]["grade"]), (&"train".into(), &"watch".into()));
    let train = get_json(&router, "/api/v1/train").await;
    assert_eq!((&train["grade"], train["worst"].as_array().unwrap().len()), (&"watch".into(), 0));
    let wagons = get_json(&router, "/api/v1/wagons").await["wagons"].clone();
    assert!(wagons.as_array().unwrap().iter().all(|wagon| wagon["grade"] == "ok"), "{wagons}");
    let (_, _, page) = get(&router, "/").await;
    assert!(page.contains("The train needs a look") && page.contains("<small> alert</small>"), "{page}");
    // Dry again: the alert lasts a little, and does not say what is no longer so.
    let router = play(40, 60, indicator(0.9, Grade::Ok, "adhesion is not low: dry 90 %"));
    let reason = get_json(&router, "/api/v1/alerts").await["alerts"][0]["reason"].clone();
    let reason = reason.as_str().unwrap().to_owned();
    assert!(reason.contains("well since 2026-03-01T12:00:04.000Z; before: adhesion is low"), "{reason}");
}

#[tokio::test]
async fn what_is_well_again_is_worth_a_look_until_its_alert_is_over() {
    let mut store = sound_train();
    for tenth in 0..60 {
        let now = later(f64::from(tenth) * 0.1);
        for wagon in 1..=8 {
            let mut health = health(wagon, now);
            if wagon == 5 && tenth < 40 {
                BRAKE_FRICTION.put_wheelset(&mut health, 1, indicator(0.2, Grade::Act, "far too low: 0.200"));
                health.grade = Grade::Act.code();
            }
            assert!(store.receive_health(wagon, &health, now).is_some());
        }
        store.snapshot(now);
    }
    let (router, _) = serve(&mut store, later(6.0));
    let train = get_json(&router, "/api/v1/train").await;
    let since = "2026-03-01T12:00:04.000Z";
    assert_eq!(train["grade"], "watch", "the figures are well again, and the alert is there still");
    assert_eq!((&train["worst"][0]["id"], &train["worst"][0]["grade"]), (&5.into(), &"watch".into()));
    assert_eq!(train["alerts"], serde_json::json!({"watch": 1, "act": 0}));
    let alert = get_json(&router, "/api/v1/alerts").await["alerts"][0].clone();
    assert_eq!(
        (&alert["active"], &alert["grade"], &alert["grade_now"]),
        (&true.into(), &"act".into(), &"watch".into())
    );
    assert_eq!(
        (&alert["places"][0]["grade"], &alert["places"][0]["well_since"]),
        (&"watch".into(), &since.into())
    );
    let wagon = get_json(&router, "/api/v1/wagons/5").await;
    assert_eq!((&wagon["grade"], &wagon["wheelsets"][1]["grade"]), (&"watch".into(), &"watch".into()));
    // Banner, tile, wheel marker, table and alerts of all pages: where it says that it is well, nothing is red.
    for path in ["/", "/wagons/5", "/alerts"] {
        let (_, _, page) = get(&router, path).await;
        assert!(page.contains("ell since") && !page.contains("All wagons are well"), "{path}: {page}");
        let legend = page.matches("chip g-act").count() + page.matches("class=\"axle g-act\"").count();
        let shown = page.matches("g-act").count();
        let explained = if path == "/" { 3 } else { 1 };
        assert_eq!((legend, shown), (explained, explained), "only the legend and the foot of {path}: {page}");
    }
    let (_, _, page) = get(&router, "/").await;
    assert!(page.contains("1 wagon needs a look") && page.contains("verdict g-watch"), "{page}");
    let (_, _, well) = get(&serve(&mut sound_train(), NOW).0, "/").await;
    assert!(well.contains("All wagons are well"));
}

/// Whoever comes back after a kill is shown at once.
#[test]
fn the_first_news_of_a_wagon_are_told_once() {
    let mut store = Store::new(&settings());
    assert!(!store.take_first_news());
    assert!(store.receive_health(2, &health(2, NOW), NOW).is_some());
    assert!(store.take_first_news() && !store.take_first_news());
    assert!(store.receive_health(2, &health(2, later(0.1)), later(0.1)).is_some());
    assert!(!store.take_first_news());
}

/// Wherever a wagon is named, its vehicle is.
#[tokio::test]
async fn a_wagon_is_named_with_the_number_of_its_vehicle() {
    let mut settings = settings();
    settings.wagons[4].vehicle_number = railgrip_settings::VehicleNumber::new("51 80 21-75 019-3");
    let (number, null) = (Value::from("51 80 21-75 019-3"), Value::Null);
    let mut store = Store::new(&settings);
    let silent = get_json(&serve(&mut store, NOW).0, "/api/v1/wagons/5").await;
    assert_eq!(silent["vehicle_number"], number, "the config knows it before the first news");
    for tenth in 0..40 {
        let now = later(f64::from(tenth) * 0.1);
        for wagon in 1..=8 {
            let mut health = health(wagon, now);
            if [4, 5].contains(&wagon) {
                BRAKE_FRICTION.put_wheelset(&mut health, 1, indicator(0.2, Grade::Act, "far too low: 0.200"));
                health.grade = Grade::Act.code();
            }
            assert!(store.receive_health(wagon, &health, now).is_some());
        }
        store.snapshot(now);
    }
    let (router, _) = serve(&mut store, later(4.0));
    let rows = get_json(&router, "/api/v1/wagons").await["wagons"].clone();
    assert_eq!((&rows[4]["vehicle_number"], &rows[3]["vehicle_number"]), (&number, &null));
    let alerts = get_json(&router, "/api/v1/alerts").await["alerts"].clone();
    let of =
        |wagon: u32| alerts.as_array().unwrap().iter().find(|alert| alert["wagon"] == wagon).unwrap().clone();
    let (with, without) = (of(5), of(4));
    assert_eq!((&with["vehicle_number"], &with["vehicle_numbers"]), (&number, &serde_json::json!([number])));
    assert_eq!(with["places"][0]["vehicle_number"], number);
    assert_eq!(
        (&without["vehicle_number"], &without["vehicle_numbers"]),
        (&null, &serde_json::json!([null]))
    );
    let (_, _, metrics) = get(&router, "/metrics").await;
    for line in [
        "railgrip_wagon_info{wagon=\"5\",name=\"wagon-5\",vehicle_number=\"51 80 21-75 019-3\"} 1",
        "railgrip_wagon_info{wagon=\"4\",name=\"wagon-4\",vehicle_number=\"\"} 1",
    ] {
        assert!(metrics.contains(line), "{line}: {metrics}");
    }
    for path in ["/", "/wagons/5", "/alerts"] {
        let (_, _, page) = get(&router, path).await;
        assert!(page.contains("51 80 21-75 019-3"), "{path}: {page}");
    }
}

#[tokio::test]
async fn errors_are_problems() {
    let (router, _) = serve(&mut sound_train(), NOW);
    for (path, status, words) in [
        ("/api/v1/wagons/9", 404, "allowed is 1 to 8"),
        ("/api/v1/wagons/front", 404, "there is no wagon \\\"front\\\""),
        ("/api/v1/nothing", 404, "there is nothing at /api/v1/nothing"),
    ] {
        let (found, kind, body) = get(&router, path).await;
        assert_eq!((found.as_u16(), kind.as_str()), (status, "application/problem+json"), "{path}");
        assert!(body.contains(words), "{body}");
    }
    let request = Request::post("/api/v1/wagons").body(Body::empty()).unwrap();
    let response = router.oneshot(request).await.unwrap();
    assert_eq!(response.status(), StatusCode::METHOD_NOT_ALLOWED);
    assert_eq!(response.headers()[header::CONTENT_TYPE], "application/problem+json");
}

#[tokio::test]
async fn the_description_names_every_route_and_resolves_every_schema() {
    let (router, _) = serve(&mut sound_train(), NOW);
    let api = get_json(&router, "/openapi.json").await;
    let paths: Vec<&String> = api["paths"].as_object().unwrap().keys().collect();
    println!("{paths:?}");
    for path in [
        "/api/v1/train",
        "/api/v1/wagons",
        "/api/v1/wagons/{id}",
        "/api/v1/alerts",
        "/api/v1/stream",
        "/metrics",
    ] {
        assert!(api["paths"][path]["get"].is_object(), "{path}");
    }
    let schemas = api["components"]["schemas"].as_object().unwrap();
    let text = api.to_string();
    let mut references = 0;
    for reference in text.split("\"#/components/schemas/").skip(1) {
        let name = reference.split('"').next().unwrap();
        assert!(schemas.contains_key(name), "{name} is referred to and not described");
        references += 1;
    }
    assert!(references > 20);
    // This train remembers nothing, and access control keeps the audit log: both have tests of their own.
    let elsewhere = ["{", "stream", "history", "events", "audit"];
    for path in paths.iter().filter(|path| !elsewhere.iter().any(|part| path.contains(part))) {
        assert_eq!(get(&router, path).await.0, StatusCode::OK, "{path}");
    }
}

#[tokio::test]
async fn the_stream_begins_with_the_whole_picture_and_ends_with_the_service() {
    let (router, shared) = serve(&mut sound_train(), NOW);
    let request = Request::get("/api/v1/stream").body(Body::empty()).unwrap();
    let mut body = router.oneshot(request).await.unwrap().into_body();
    let mut text = String::new();
    let mut frame = async || {
        let frame = body.frame().await?.unwrap();
        Some(String::from_utf8(frame.into_data().unwrap().to_vec()).unwrap())
    };
    text += &frame().await.unwrap();
    text += &frame().await.unwrap();
    assert!(text.contains("event: train") && text.contains("event: wagons") && text.contains("\"wagon-8\""));
    shared.send(StreamEvent { name: "alert", data: "{\"id\":1}".into() });
    assert_eq!(frame().await.unwrap(), "event: alert\ndata: {\"id\":1}\n\n");
    shared.close();
    assert_eq!(frame().await, None);
}

#[tokio::test]
async fn a_slow_listener_gets_the_whole_picture_anew() {
    let (router, shared) = serve(&mut sound_train(), NOW);
    let request = Request::get("/api/v1/stream").body(Body::empty()).unwrap();
    let mut body = router.oneshot(request).await.unwrap().into_body();
    for _ in 0..200 {
        shared.send(StreamEvent { name: "wagons", data: "[]".into() });
    }
    let mut names = Vec::new();
    for _ in 0..4 {
        let frame = body.frame().await.unwrap().unwrap().into_data().unwrap();
        names.push(String::from_utf8_lossy(&frame).lines().next().unwrap().to_owned());
    }
    assert_eq!(names, ["event: train", "event: wagons", "event: train", "event: wagons"]);
}

#[tokio::test]
async fn a_stuck_feeder_shows_in_liveness_and_a_newer_snapshot_replaces_the_older() {
    let mut store = sound_train();
    let shared =
        Shared::new(store.snapshot(NOW), || Stamp { monotonic_ns: NOW.monotonic_ns + 9_000_000_000, ..NOW });
    let router = router(shared.clone());
    let (status, _, body) = get(&router, "/health/live").await;
    assert_eq!(status, StatusCode::SERVICE_UNAVAILABLE);
    assert!(body.contains("not been renewed for 9 s"), "{body}");
    // Whoever asks is told the age as it is now, though nobody renews the snapshot.
    assert_eq!(get(&router, "/health/ready").await.0, StatusCode::SERVICE_UNAVAILABLE);
    let row = get_json(&router, "/api/v1/wagons").await["wagons"][0].clone();
    assert_eq!((&row["state"], &row["age_s"], &row["v_m_s"]), (&"stale".into(), &9.0.into(), &Value::Null));
    assert_eq!(get_json(&router, "/api/v1/train").await["live"], 0);
    shared.replace(Arc::new(store.snapshot(later(8.0))));
    assert_eq!(get(&router, "/health/live").await.0, StatusCode::OK);
}

#[tokio::test]
async fn processes_are_listed_while_they_live() {
    let mut store = sound_train();
    let mut beat = Heartbeat { stamp: NOW, wagon: 4, pid: 77, step_p99_ns: 900, ..Heartbeat::default() };
    beat.process = ProcessKind::Estimator.code();
    assert!(store.receive_heartbeat(&beat, NOW).is_some());
    let (router, _) = serve(&mut store, later(1.0));
    assert_eq!(get_json(&router, "/api/v1/wagons/4").await["estimator"]["pid"], 77);
    let (_, _, metrics) = get(&router, "/metrics").await;
    assert!(metrics.contains("railgrip_estimator_step_seconds{wagon=\"4\",quantile=\"0.99\"}"), "{metrics}");
    assert!(metrics.ends_with("# EOF\n"));
    let (router, _) = serve(&mut store, later(60.0));
    assert_eq!(get_json(&router, "/api/v1/train").await["processes"], serde_json::json!([]));
}

#[tokio::test]
async fn the_page_needs_nothing_from_elsewhere() {
    let (router, _) = serve(&mut sound_train(), NOW);
    let (status, kind, page) = get(&router, "/").await;
    assert_eq!((status, kind.starts_with("text/html")), (StatusCode::OK, true));
    assert!(!page.contains("http://") && !page.contains("https://"), "{page}");
    assert_eq!(page.matches("<li id=\"w-").count(), 8);
    let mut count = 0;
    for asset in page.split('"').filter(|text| text.starts_with("/assets/")) {
        let (status, kind, _) = get(&router, asset).await;
        assert_eq!(status, StatusCode::OK, "{asset}: {kind}");
        count += 1;
    }
    assert!(count >= 10, "{count} files");
}
