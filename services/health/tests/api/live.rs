//! What is shown of a train now: what is live, what is stale, whom it names, and who works on it.

use super::{NOW, get, get_json, health, indicator, later, serve, settings, sound_train};
use axum::http::StatusCode;
use railgrip_health::api::router;
use railgrip_health::shared::Shared;
use railgrip_health::store::Store;
use railgrip_indicators::indicator::BRAKE_FRICTION;
use railgrip_messages::{Grade, Heartbeat, ProcessKind, SourceState, Stamp};
use serde_json::Value;
use std::sync::Arc;

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
                let low = indicator(0.2, Grade::Act, "far too low: 0.200");
                BRAKE_FRICTION.put(&mut health, low);
                BRAKE_FRICTION.put_wheelset(&mut health, 1, low);
                health.grade = Grade::Act.code();
            }
            assert!(store.receive_health(wagon, &health, now).is_some());
        }
        store.snapshot(now);
    }
    for wagon in [4, 5] {
        let mut beat = Heartbeat { stamp: later(3.9), wagon, ..Heartbeat::default() };
        beat.process = ProcessKind::Estimator.code();
        assert!(store.receive_heartbeat(&beat, later(3.9)).is_some());
        let source = SourceState { sequence: 1, stamp: later(3.9), wagon, ..SourceState::default() };
        assert!(store.receive_source(&source, later(3.9)));
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
    let train = get_json(&router, "/api/v1/train").await;
    let capability = get_json(&router, "/api/v1/train/capability").await;
    for list in [&train["sources"], &train["processes"], &capability["worst_wagons"]] {
        let told = |wagon: u32| {
            let found = list.as_array().and_then(|all| all.iter().find(|one| one["wagon"] == wagon));
            found.unwrap_or_else(|| panic!("wagon {wagon}: {list}"))
        };
        assert_eq!((&told(5)["vehicle_number"], &told(4)["vehicle_number"]), (&number, &null), "{list}");
    }
    let (_, _, page) = get(&router, "/").await;
    let card = page.split_once("id=\"stops\"").unwrap().1;
    let card = card.split_once("</p></div>").unwrap().0;
    assert!(card.contains("51 80 21-75 019-3"), "{card}");
    for path in ["/", "/wagons/5", "/alerts"] {
        let (_, _, page) = get(&router, path).await;
        assert!(page.contains("51 80 21-75 019-3"), "{path}: {page}");
    }
}
