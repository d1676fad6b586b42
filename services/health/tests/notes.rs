//! Notes on a vehicle, over the interface without a socket.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

use axum::body::Body;
use axum::http::{Request, StatusCode, header};
use http_body_util::BodyExt;
use railgrip_health::api::router;
use railgrip_health::history::{History, columns, consist};
use railgrip_health::limits::Limits;
use railgrip_health::notes::Whose;
use railgrip_health::shared::Shared;
use railgrip_health::store::Store;
use railgrip_messages::Stamp;
use railgrip_settings::{Overrides, TrainSettings};
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Arc;
use tower::ServiceExt;

const NOW: Stamp = Stamp { unix_ns: 1_772_366_400_000_000_000, monotonic_ns: 100_000_000_000 };

/// A train of two vehicles in this order.
fn consist(folder: &Path, numbers: [&str; 2]) -> Shared {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = format!(
        "schema = 1\n[train]\nname = \"t\"\nwagons = 2\nvehicle = \"{}\"\n[source]\nkind = \"stdin\"\n\
         [[wagon]]\nnumber = \"{}\"\n[[wagon]]\nnumber = \"{}\"\n",
        root.join("config/vehicle.toml").display(),
        numbers[0],
        numbers[1]
    );
    let settings = TrainSettings::parse(&folder.join("train.toml"), &text, &Overrides::default()).unwrap();
    let shared = Shared::new(Store::new(&settings).snapshot(NOW), || NOW);
    shared.judge_by(Limits::of(&settings));
    shared.notes().keep(folder.join("notes.jsonl"));
    let history = History::new(folder.join("history.db"), 2);
    shared.remember(Arc::new(history.of_vehicles(consist::numbers(&settings))));
    shared
}

/// Twenty days of pad friction, an hour a point.
fn follows(folder: &Path, numbers: [&str; 2], of_day: impl Fn(f64) -> f32) {
    let all = columns::all(2);
    let names = columns::stored(&all);
    let names: Vec<_> = names.iter().map(|(name, keep)| (name.as_str(), *keep)).collect();
    let mut kept = railgrip_history::Store::open(&folder.join("history.db"), &names).unwrap();
    let numbers: Vec<_> = numbers.into_iter().map(railgrip_settings::VehicleNumber::new).collect();
    let order = consist::Consist::enter(&kept, &numbers).unwrap();
    let at = names.iter().position(|(name, _)| *name == "brake_friction").unwrap();
    for hour in 0..20 * 24 {
        let mut row = vec![f32::NAN; names.len()];
        // A little noise, so that a trend has an interval.
        row[at] = of_day(f64::from(hour) / 24.0) + 1e-4 * (hour % 3) as f32;
        let unix_s = NOW.unix_ns.div_euclid(1_000_000_000) - 3600 * (20 * 24 - i64::from(hour)) + 60;
        for place in 1..=2 {
            kept.push(order.id(place), unix_s, &row).unwrap();
        }
    }
    kept.flush(true).unwrap();
}

async fn pad_trend(shared: &Shared, wagon: u32) -> Value {
    let (status, told) = ask(shared, &format!("/api/v1/wagons/{wagon}/trends"), None).await;
    assert_eq!(status, StatusCode::OK, "{told}");
    let trends = told["trends"].as_array().unwrap();
    trends.iter().find(|trend| trend["indicator"] == "brake_friction").unwrap().clone()
}

#[tokio::test]
async fn new_pads_begin_their_trend_anew_and_it_follows_the_vehicle() {
    let folder = tempfile::tempdir().unwrap();
    let numbers = ["51 80 21-75 019-3", "51 80 21-75 020-1"];
    // The pads fall by 0.004 a day for 15 days; the new ones, noted five days ago, stay where they are.
    follows(folder.path(), numbers, |day| 0.36 - 0.004 * day.min(15.0) as f32);
    let before = consist(folder.path(), numbers);
    let old = pad_trend(&before, 1).await;
    assert!(old["verdict"] == "falling" && old["span_days"].as_f64() > Some(19.0), "{old}");
    let changed_at = NOW.unix_ns - 5 * 86_400 * 1_000_000_000;
    let note = json!({"vehicle": "518021750193", "at": railgrip_health::time::rfc3339(changed_at), "by": "kim", "kind": "pads_changed", "text": "new"});
    std::fs::write(folder.path().join("notes.jsonl"), format!("{note}\n")).unwrap();
    let after = consist(folder.path(), numbers);
    let new = pad_trend(&after, 1).await;
    assert!(new["verdict"] == "no_trend" && new["remaining_days"].is_null(), "{new}");
    let days = new["span_days"].as_f64().unwrap();
    assert!((4.8..=5.0).contains(&days) && new["points"].as_u64() > Some(100), "five days of hours: {new}");
    assert_eq!(pad_trend(&after, 2).await["verdict"], "falling", "the other vehicle keeps its past");
    // The train is turned round, and the numbers are written otherwise: the note runs with its vehicle.
    let turned = consist(folder.path(), ["518021750201", "518021750193"]);
    assert_eq!(pad_trend(&turned, 2).await["verdict"], "no_trend");
    assert_eq!(pad_trend(&turned, 1).await["verdict"], "falling");
    let (_, told) = ask(&turned, "/api/v1/wagons/2/notes", None).await;
    assert_eq!(told["notes"][0]["by"], "kim");
}

fn shared() -> Shared {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/railgrip.toml");
    let settings = TrainSettings::load(Some(&file), &Overrides::default()).unwrap();
    Shared::new(Store::new(&settings).snapshot(NOW), || NOW)
}

async fn ask(shared: &Shared, path: &str, body: Option<&str>) -> (StatusCode, Value) {
    let request = Request::builder().uri(path).header(header::HOST, "localhost");
    let request = match body {
        Some(body) => request
            .method("POST")
            .header(header::CONTENT_TYPE, "application/json")
            .body(Body::from(body.to_owned())),
        None => request.body(Body::empty()),
    };
    let response = router(shared.clone()).oneshot(request.unwrap()).await.unwrap();
    let status = response.status();
    let bytes = response.into_body().collect().await.unwrap().to_bytes();
    (status, serde_json::from_slice(&bytes).unwrap_or(Value::Null))
}

#[tokio::test]
async fn what_is_written_down_is_told_to_the_next_who_looks() {
    let (shared, path) = (shared(), "/api/v1/wagons/3/notes");
    let folder = tempfile::tempdir().unwrap();
    shared.notes().keep(folder.path().join("notes.jsonl"));
    let (status, nothing) = ask(&shared, path, None).await;
    assert_eq!(
        (status, &nothing["notes"], &nothing["pads_changed_at"]),
        (StatusCode::OK, &json!([]), &Value::Null)
    );
    let (status, told) =
        ask(&shared, path, Some(r#"{"by": "  fitter ", "text": "squeals at 20 km/h"}"#)).await;
    assert_eq!(status, StatusCode::OK);
    assert_eq!(told["notes"][0]["text"], "squeals at 20 km/h");
    let (status, _) =
        ask(&shared, path, Some(r#"{"by": "fitter", "kind": "pads_changed", "text": "new set"}"#)).await;
    assert_eq!(status, StatusCode::OK);
    let (_, told) = ask(&shared, path, None).await;
    let vehicle = told["vehicle"].as_str().unwrap();
    let expected = json!([
        {"vehicle": vehicle, "at": "2026-03-01T12:00:00.000Z", "by": "fitter", "kind": "pads_changed", "text": "new set"},
        {"vehicle": vehicle, "at": "2026-03-01T12:00:00.000Z", "by": "fitter", "kind": "note", "text": "squeals at 20 km/h"},
    ]);
    assert_eq!(told["notes"], expected);
    assert_eq!(told["pads_changed_at"], "2026-03-01T12:00:00.000Z");
    let whose = Whose { vehicle: vehicle.to_owned(), start: None };
    assert_eq!(shared.notes().pads_changed_unix_s(&whose), Some(1_772_366_400));
    // Another vehicle knows nothing of it.
    let (_, other) = ask(&shared, "/api/v1/wagons/4/notes", None).await;
    assert_eq!(other["notes"], json!([]));
}

#[tokio::test]
async fn what_makes_no_sense_is_refused_with_a_reason() {
    let (shared, path) = (shared(), "/api/v1/wagons/3/notes");
    let long = format!(r#"{{"by": "x", "text": "{}"}}"#, "a".repeat(501));
    for (body, status, said) in [
        (r#"{"text": "no name"}"#, StatusCode::UNPROCESSABLE_ENTITY, "`by`"),
        (r#"{"by": "x"}"#, StatusCode::UNPROCESSABLE_ENTITY, "`text`"),
        (r#"{"by": "x", "text": "\u0007"}"#, StatusCode::UNPROCESSABLE_ENTITY, "`text`"),
        (r#"{"by": "x", "kind": "moved"}"#, StatusCode::UNPROCESSABLE_ENTITY, "moved"),
        (r#"{"by": "x", "txt": "y"}"#, StatusCode::UNPROCESSABLE_ENTITY, "txt"),
        (r#"{"by": "#, StatusCode::BAD_REQUEST, "JSON"),
        (&long, StatusCode::UNPROCESSABLE_ENTITY, "500"),
    ] {
        let (found, problem) = ask(&shared, path, Some(body)).await;
        let detail = problem["detail"].as_str().unwrap_or_default();
        assert!(found == status && detail.contains(said), "{body}: {found} {detail}");
    }
    let (status, _) = ask(&shared, "/api/v1/wagons/99/notes", Some(r#"{"by": "x", "text": "y"}"#)).await;
    assert_eq!(status, StatusCode::NOT_FOUND);
    let (_, told) = ask(&shared, path, None).await;
    assert_eq!(told["notes"], json!([]));
}

/// A train in this folder, first wagon with a number, second without, whose start has this sign.
fn started(folder: &Path, sign: &str) -> Shared {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let text = format!(
        "schema = 1\n[train]\nname = \"t\"\nvehicle = \"{}\"\n[source]\nkind = \"stdin\"\n\
         [[wagon]]\nnumber = \"51 80 1\"\n[[wagon]]\n",
        root.join("config/vehicle.toml").display()
    );
    std::fs::write(folder.join("session"), sign).unwrap();
    let overrides = Overrides { instance_dir: Some(folder.to_owned()), ..Overrides::default() };
    let settings = TrainSettings::parse(&folder.join("train.toml"), &text, &overrides).unwrap();
    let shared = Shared::new(Store::new(&settings).snapshot(NOW), || NOW);
    shared.judge_by(Limits::of(&settings));
    shared.notes().keep(folder.join("notes.jsonl"));
    shared
}

#[tokio::test]
async fn notes_of_a_wagon_without_a_number_end_with_the_start_of_the_train() {
    let folder = tempfile::tempdir().unwrap();
    let pads = r#"{"by": "kim", "kind": "pads_changed", "text": "new"}"#;
    let told = async |shared: &Shared, wagon: u32| {
        let (status, told) = ask(shared, &format!("/api/v1/wagons/{wagon}/notes"), None).await;
        assert_eq!(status, StatusCode::OK, "{told}");
        (told["notes"].as_array().unwrap().len(), told["pads_changed_at"].is_string())
    };
    let first = started(folder.path(), "1 7\n");
    for wagon in 1..=2 {
        let (status, now) = ask(&first, &format!("/api/v1/wagons/{wagon}/notes"), Some(pads)).await;
        assert_eq!((status, &now["notes"][0]["start"]), (StatusCode::OK, &Value::Null), "{now}");
    }
    let again = started(folder.path(), "1 7\n");
    assert_eq!((told(&again, 1).await, told(&again, 2).await), ((1, true), (1, true)), "the same start");
    // Also what an older version wrote, which knows no start.
    let old = json!({"vehicle": "wagon-2", "at": "2026-02-01T12:00:00Z", "by": "kim", "kind": "pads_changed", "text": "old"});
    let path = folder.path().join("notes.jsonl");
    let kept = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, format!("{kept}{old}\n")).unwrap();
    let next = started(folder.path(), "2 8\n");
    assert_eq!((told(&next, 1).await, told(&next, 2).await), ((1, true), (0, false)), "another start");
    let (status, _) = ask(&next, "/api/v1/wagons/2/notes", Some(r#"{"by": "kim", "text": "squeals"}"#)).await;
    assert_eq!((status, told(&next, 2).await), (StatusCode::OK, (1, false)));
    assert!(std::fs::read_to_string(&path).unwrap().contains("old"), "nothing is deleted");
}
