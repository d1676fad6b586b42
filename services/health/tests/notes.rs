//! Notes on a vehicle, over the interface without a socket.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

use axum::body::Body;
use axum::http::{Request, StatusCode, header};
use http_body_util::BodyExt;
use railgrip_health::api::router;
use railgrip_health::shared::Shared;
use railgrip_health::store::Store;
use railgrip_messages::Stamp;
use railgrip_settings::{Overrides, TrainSettings};
use serde_json::{Value, json};
use std::path::Path;
use tower::ServiceExt;

const NOW: Stamp = Stamp { unix_ns: 1_772_366_400_000_000_000, monotonic_ns: 100_000_000_000 };

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
    assert_eq!(shared.notes().pads_changed_unix_s(vehicle), Some(1_772_366_400));
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
