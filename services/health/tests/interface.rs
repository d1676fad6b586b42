//! What HTTP asks of the interface: tags, compression, negotiation, pages of long lists, stored data as tables.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test may end at what it does not expect, and prints"
)]

use axum::body::Body;
use axum::http::{HeaderMap, Method, Request};
use flate2::read::GzDecoder;
use http_body_util::BodyExt;
use railgrip_health::alerts::Symptom;
use railgrip_health::api::grade::Grade;
use railgrip_health::api::router;
use railgrip_health::history::{History, columns};
use railgrip_health::shared::Shared;
use railgrip_health::store::Store;
use railgrip_history::Event;
use railgrip_messages::{Health, Stamp};
use railgrip_settings::{Overrides, TrainSettings};
use serde_json::Value;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;
use tempfile::TempDir;
use tower::ServiceExt;

const NOW_S: i64 = 1_772_366_400;
const SECOND_NS: i64 = 1_000_000_000;
const NOW: Stamp = Stamp { unix_ns: NOW_S * 1_000_000_000, monotonic_ns: 100_000_000_000 };

struct Train {
    router: axum::Router,
    shared: Shared,
    store: Store,
    _folder: TempDir,
}

struct Answer {
    status: u16,
    headers: HeaderMap,
    body: Vec<u8>,
}

impl Answer {
    fn header(&self, name: &str) -> &str {
        self.headers.get(name).map_or("", |value| value.to_str().unwrap())
    }

    fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap()
    }

    fn is_problem(&self, status: u16) -> bool {
        self.status == status
            && self.header("content-type") == "application/problem+json"
            && self.json()["status"] == status
    }
}

/// Two minutes of three wagons, and seven events, in a database.
fn train() -> Train {
    let folder = tempfile::tempdir().unwrap();
    let database = folder.path().join("history.db");
    let all = columns::all(2);
    let names = columns::stored(&all);
    let names: Vec<_> = names.iter().map(|(name, keep)| (name.as_str(), *keep)).collect();
    let mut kept = railgrip_history::Store::open(&database, &names).unwrap();
    for second in 0..120 {
        for wagon in 1..=3 {
            let health = Health { wagon, wheelsets: 2, v_m_s: second as f64, ..Health::default() };
            kept.push(wagon, NOW_S - 120 + second, &columns::values(&all, &health)).unwrap();
        }
    }
    for number in 1..=7 {
        kept.push_event(Event {
            unix_ms: (NOW_S - 100 + number) * 1000,
            kind: if number % 2 == 0 { "slides" } else { "process_started" }.to_owned(),
            wagon: Some(number as u32 % 3 + 1),
            text: format!("event {number}"),
            ..Event::default()
        });
    }
    kept.flush(true).unwrap();
    drop(kept);
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/railgrip.toml");
    let mut store = Store::new(&TrainSettings::load(Some(&file), &Overrides::default()).unwrap());
    let shared = Shared::new(store.snapshot(NOW), || NOW);
    shared.remember(Arc::new(History::new(database, 2)));
    Train { router: router(shared.clone()), shared, store, _folder: folder }
}

impl Train {
    async fn ask(&self, method: Method, path: &str, headers: &[(&str, &str)], body: &str) -> Answer {
        let mut request = Request::builder().method(method).uri(path);
        for (name, value) in headers {
            request = request.header(*name, *value);
        }
        let response =
            self.router.clone().oneshot(request.body(Body::from(body.to_owned())).unwrap()).await.unwrap();
        let (parts, body) = response.into_parts();
        let body = body.collect().await.unwrap().to_bytes().to_vec();
        Answer { status: parts.status.as_u16(), headers: parts.headers, body }
    }

    async fn get(&self, path: &str, headers: &[(&str, &str)]) -> Answer {
        self.ask(Method::GET, path, headers, "").await
    }
}

#[tokio::test]
async fn what_a_client_has_is_not_sent_again() {
    let mut train = train();
    for path in
        ["/api/v1/train", "/api/v1/wagons", "/api/v1/wagons/1", "/api/v1/alerts", "/openapi.json", "/docs"]
    {
        let first = train.get(path, &[]).await;
        let tag = first.header("etag").to_owned();
        assert!(first.status == 200 && tag.starts_with("W/\""), "{path}: {tag:?}");
        assert!(
            first.header("cache-control").contains("no-cache"),
            "{path}: {}",
            first.header("cache-control")
        );
        let known = format!("\"other\", {tag}");
        let again = train.get(path, &[("if-none-match", &known)]).await;
        assert_eq!((again.status, again.body.len(), again.header("etag")), (304, 0, tag.as_str()), "{path}");
        assert_eq!(train.get(path, &[("if-none-match", "W/\"other\"")]).await.status, 200, "{path}");
    }
    let before = train.get("/api/v1/wagons", &[]).await.header("etag").to_owned();
    let later = Stamp { unix_ns: NOW.unix_ns + 150_000_000, ..NOW };
    train.shared.replace(Arc::new(train.store.snapshot(later)));
    assert_eq!(train.get("/api/v1/wagons", &[("if-none-match", &before)]).await.status, 200, "a new picture");
}

#[tokio::test]
async fn long_answers_are_compressed_for_those_who_take_that() {
    let train = train();
    let plain = train.get("/openapi.json", &[]).await;
    assert_eq!((plain.header("content-encoding"), plain.header("vary")), ("", "Accept-Encoding"));
    let packed = train.get("/openapi.json", &[("accept-encoding", "br, gzip;q=0.5")]).await;
    assert_eq!(packed.header("content-encoding"), "gzip");
    println!("{} bytes instead of {}", packed.body.len(), plain.body.len());
    assert!(packed.body.len() * 4 < plain.body.len());
    let mut text = Vec::new();
    GzDecoder::new(packed.body.as_slice()).read_to_end(&mut text).unwrap();
    assert_eq!(text, plain.body);
    assert_eq!(
        train.get("/openapi.json", &[("accept-encoding", "gzip;q=0")]).await.header("content-encoding"),
        ""
    );
    let short = train.get("/health/ready", &[("accept-encoding", "gzip")]).await;
    assert!(short.body.len() > 1024 || short.header("content-encoding").is_empty());
}

/// Has the leading pads of wagon 2 act for some seconds, until there is an alert.
fn raise_an_alert(train: &mut Train) {
    for second in 0..5 {
        let later_ns = second * SECOND_NS;
        let now = Stamp {
            unix_ns: NOW.unix_ns + later_ns,
            monotonic_ns: NOW.monotonic_ns + later_ns.unsigned_abs(),
        };
        let symptom = Symptom { wagon: 2, wheelset: Some(1), rule: "brake_friction" };
        let book = train.store.book();
        book.lock().judge(symptom, Grade::Act, "far too low", now);
        book.lock().settle(now);
    }
    train.shared.replace(Arc::new(train.store.snapshot(NOW)));
}

#[tokio::test]
async fn an_alert_is_silenced_and_the_old_paths_still_work() {
    let mut train = train();
    raise_an_alert(&mut train);
    let json = [("content-type", "application/json")];
    let silence = "{\"by\":\"Ada\",\"why\":\"pads ordered\",\"duration_s\":3600}";
    for (set, end) in [("silence", "unsilence"), ("shelve", "unshelve"), ("silence", "unshelve")] {
        let path = |act: &str| format!("/api/v1/alerts/1/{act}");
        let alert = train.ask(Method::POST, &path(set), &json, silence).await;
        assert_eq!(alert.status, 200, "{}", String::from_utf8_lossy(&alert.body));
        let alert = alert.json();
        assert_eq!(
            (&alert["state"], &alert["silenced"]["why"]),
            (&"silenced".into(), &"pads ordered".into())
        );
        for state in ["silenced", "shelved"] {
            let found = train.get(&format!("/api/v1/alerts?state={state}"), &[]).await.json();
            assert_eq!(found["alerts"][0]["id"], 1, "{state}");
        }
        let alert = train.ask(Method::POST, &path(end), &json, "{\"by\":\"Ada\"}").await.json();
        assert_eq!((&alert["state"], &alert["silenced"]), (&"active".into(), &Value::Null));
        let twice = train.ask(Method::POST, &path(end), &json, "{\"by\":\"Ada\"}").await;
        assert!(twice.is_problem(409), "{}", twice.status);
    }
    let act = |act: &str| format!("/api/v1/alerts/1/{act}");
    for (act, state, again) in
        [(act("acknowledge"), "acknowledged", 200), (act("unacknowledge"), "active", 409)]
    {
        let alert = train.ask(Method::POST, &act, &json, "{\"by\":\"Ada\"}").await.json();
        assert_eq!(alert["state"], state, "{act}");
        assert_eq!(
            train.ask(Method::POST, &act, &json, "{\"by\":\"Ada\"}").await.status,
            again,
            "{act} twice"
        );
    }
    assert_eq!(train.get("/api/v1/receivers", &[]).await.body, train.get("/api/v1/delivery", &[]).await.body);
    let api = train.get("/openapi.json", &[]).await.json();
    let old: Vec<&str> = routes(&api)
        .into_iter()
        .filter(|(.., route)| route["deprecated"] == true)
        .map(|(path, ..)| path)
        .collect();
    println!("deprecated: {old:?}");
    assert_eq!(old.len(), 3);
}

#[tokio::test]
async fn every_refusal_is_a_problem() {
    let train = train();
    let json = ("content-type", "application/json");
    let act = "/api/v1/alerts/1/acknowledge";
    assert!(train.get("/api/v1/nothing", &[]).await.is_problem(404));
    assert!(train.get("/api/v1/wagons/%FF", &[]).await.is_problem(400), "no UTF-8");
    assert!(train.get("/api/v1/wagons", &[("accept", "text/html")]).await.is_problem(406));
    assert!(train.get("/api/v1/stream", &[("accept", "application/json")]).await.is_problem(406));
    assert!(train.get("/api/v1/wagons", &[("accept", "text/html, */*;q=0.1")]).await.status == 200);
    let wrong = train.ask(Method::POST, "/api/v1/wagons", &[], "").await;
    assert!(wrong.is_problem(405) && wrong.header("allow").contains("GET"), "{:?}", wrong.headers);
    for (headers, body, status) in [
        (&[("content-type", "text/plain")][..], "{\"by\":\"x\"}", 415),
        (&[], "{\"by\":\"x\"}", 415),
        (&[json, ("accept", "text/html")], "{\"by\":\"x\"}", 406),
        (&[json], "{\"by\":", 400),
        (&[json], "", 400),
        (&[json], "{\"by\":7}", 422),
        (&[json], "{}", 422),
        (&[json], "{\"by\":\"x\",\"else\":1}", 422),
        (&[json], "{\"by\":\"  \"}", 422),
        (&[json], "{\"by\":\"x\"}", 404),
    ] {
        let answer = train.ask(Method::POST, act, headers, body).await;
        assert!(
            answer.is_problem(status),
            "{body}: {} {}",
            answer.status,
            String::from_utf8_lossy(&answer.body)
        );
    }
    for (query, status) in [
        ("from=yesterday", 400),
        ("step=0", 400),
        ("step=1x", 400),
        ("until=1", 400),
        ("from=1&from=2", 400),
        ("fields=nothing", 400),
        ("from=200&to=100", 409),
        ("from=1d&to=-2d", 409),
        ("from=7w", 400),
        ("from=0&to=99999999&step=1", 409),
    ] {
        let answer = train.get(&format!("/api/v1/wagons/1/history?{query}"), &[]).await;
        assert!(answer.is_problem(status), "{query}: {}", answer.status);
    }
}

#[tokio::test]
async fn long_lists_come_page_by_page() {
    let train = train();
    let mut seen = Vec::new();
    let mut next = Some("/api/v1/wagons?limit=3".to_owned());
    while let Some(path) = next {
        let answer = train.get(&path, &[]).await;
        let list = answer.json();
        seen.extend(list["wagons"].as_array().unwrap().iter().map(|row| row["id"].as_u64().unwrap()));
        next = list["next"].as_str().map(str::to_owned);
        let link = next.as_deref().map_or_else(String::new, |next| format!("<{next}>; rel=\"next\""));
        assert_eq!(answer.header("link"), link);
    }
    assert_eq!(seen, (1..=8).collect::<Vec<u64>>());
    assert_eq!(train.get("/api/v1/wagons?state=live", &[]).await.json()["wagons"], serde_json::json!([]));
    assert!(train.get("/api/v1/wagons?limit=0", &[]).await.is_problem(400));
    assert!(train.get("/api/v1/alerts?state=gone", &[]).await.is_problem(400));
    assert_eq!(
        train.get("/api/v1/alerts?state=active&limit=5", &[]).await.json()["alerts"],
        serde_json::json!([])
    );
}

#[tokio::test]
async fn what_happened_is_told_newest_first() {
    let train = train();
    let first = train.get("/api/v1/events?limit=3", &[]).await.json();
    let texts = |page: &Value| -> Vec<String> {
        page["events"]
            .as_array()
            .unwrap()
            .iter()
            .map(|event| event["text"].as_str().unwrap().to_owned())
            .collect()
    };
    assert_eq!(texts(&first), ["event 7", "event 6", "event 5"]);
    let second = train.get(first["next"].as_str().unwrap(), &[]).await.json();
    assert_eq!(texts(&second), ["event 4", "event 3", "event 2"]);
    let third = train.get(second["next"].as_str().unwrap(), &[]).await.json();
    assert_eq!((texts(&third), &third["next"]), (vec!["event 1".to_owned()], &Value::Null));
    assert_eq!(texts(&train.get("/api/v1/events?kind=slides&wagon=2", &[]).await.json()), ["event 4"]);
    let span = format!("/api/v1/events?from={}&to={}", NOW_S - 98, NOW_S - 96);
    assert_eq!(texts(&train.get(&span, &[]).await.json()), ["event 3", "event 2"]);
    assert!(train.get("/api/v1/events?wagon=99", &[]).await.is_problem(404));
    assert!(train.get("/api/v1/events?kind=No", &[]).await.is_problem(400));
}

#[tokio::test]
async fn stored_data_leave_as_csv_and_as_parquet() {
    let train = train();
    let csv = train.get("/api/v1/history/export?step=60&fields=v_m_s,brake_friction&wagon=1,3", &[]).await;
    let text = String::from_utf8(csv.body.clone()).unwrap();
    println!("{text}");
    assert_eq!(csv.header("content-type"), "text/csv; charset=utf-8");
    assert!(csv.header("content-disposition").contains(".csv"));
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines[0].starts_with(
        "time,wagon,vehicle,samples,v_m_s,v_m_s_min,v_m_s_max,brake_friction,brake_friction_low"
    ));
    assert_eq!(lines[1], "2026-03-01T11:58:00Z,1,,60,29.5,0,59,,,,,");
    assert_eq!(lines.len(), 5);

    let parquet =
        train.get("/api/v1/history/export?step=1", &[("accept", "application/vnd.apache.parquet")]).await;
    assert_eq!(parquet.header("content-type"), "application/vnd.apache.parquet");
    assert!(parquet.body.starts_with(b"PAR1") && parquet.body.ends_with(b"PAR1"));
    let reader = parquet::file::reader::SerializedFileReader::new(bytes::Bytes::from(parquet.body)).unwrap();
    let metadata = parquet::file::reader::FileReader::metadata(&reader).file_metadata();
    assert_eq!(metadata.num_rows(), 360);

    let packed = train.get("/api/v1/history/export?format=csv&step=60", &[("accept-encoding", "gzip")]).await;
    let mut unpacked = String::new();
    GzDecoder::new(packed.body.as_slice()).read_to_string(&mut unpacked).unwrap();
    assert_eq!(unpacked.lines().count(), 7);
    for (query, headers, status) in [
        ("format=xls", &[][..], 400),
        ("wagon=9", &[], 404),
        ("fields=nothing", &[], 400),
        ("from=200&to=100", &[], 409),
        ("", &[("accept", "text/html")], 406),
    ] {
        let answer = train.get(&format!("/api/v1/history/export?{query}"), headers).await;
        assert!(answer.is_problem(status), "{query}: {}", answer.status);
    }
}

/// All routes of a description, with path and method.
fn routes(api: &Value) -> Vec<(&str, &str, &Value)> {
    let paths = api["paths"].as_object().unwrap().iter();
    paths
        .flat_map(|(path, methods)| {
            let methods = methods.as_object().unwrap().iter();
            methods.map(move |(method, route)| (path.as_str(), method.as_str(), route))
        })
        .collect()
}

#[tokio::test]
async fn the_interface_is_described_for_people_and_for_programs() {
    let train = train();
    let docs = String::from_utf8(train.get("/docs", &[]).await.body).unwrap();
    let api = train.get("/openapi.json", &[]).await.json();
    assert!(api["openapi"].as_str().unwrap().starts_with("3.1"));
    for path in api["paths"].as_object().unwrap().keys() {
        assert!(docs.contains(path.as_str()), "{path} is missing at /docs");
    }
    let fields = api["paths"]["/api/v1/wagons/{id}/history"]["get"]["parameters"].as_array().unwrap();
    let fields =
        fields.iter().find(|one| one["name"] == "fields").unwrap()["schema"]["pattern"].as_str().unwrap();
    assert!(fields.contains("|dragging_n|") && fields.contains("|wheelset_2\\.slides|"), "{fields}");
    for (path, method, route) in routes(&api) {
        for (status, answer) in route["responses"].as_object().unwrap() {
            let said = format!("{method} {path} {status}: {answer}");
            assert!(answer["description"].as_str().is_some_and(|words| !words.is_empty()), "{said}");
            let is_check = path.starts_with("/health/") && status == "503";
            let refuses = status.starts_with(['4', '5']) && !is_check;
            assert_eq!(refuses, answer["content"]["application/problem+json"].is_object(), "{said}");
        }
        let operations: Vec<&Value> =
            routes(&api).into_iter().map(|(.., route)| &route["operationId"]).collect();
        for link in
            route["responses"]["200"]["links"].as_object().into_iter().flat_map(|links| links.values())
        {
            assert!(operations.contains(&&link["operationId"]), "{path}: {link}");
        }
    }
    assert_eq!(
        api["paths"]["/api/v1/alerts"]["get"]["responses"]["200"]["links"].as_object().unwrap().len(),
        4
    );
    assert!(api["paths"]["/api/v1/audit"]["get"].is_object());
    assert!(!docs.contains("<script") && !docs.contains("http://www") && docs.contains("id=\"WagonView\""));
    assert_eq!(api["components"]["securitySchemes"]["token"]["scheme"], "bearer");
    assert_eq!(train.get("/docs.css", &[]).await.status, 200);
    let overview = train.get("/api/v1/history", &[]).await.json();
    assert!(
        overview["indicators"]
            .as_array()
            .unwrap()
            .iter()
            .any(|one| one["name"] == "dragging_n" && one["unit"] == "N")
    );
    let metrics = String::from_utf8(train.get("/metrics", &[]).await.body).unwrap();
    assert!(
        metrics.contains("railgrip_history_up 1.0")
            && metrics.contains("railgrip_history_written_bytes_total 0"),
        "{metrics}"
    );
}
