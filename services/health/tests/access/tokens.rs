//! Tokens: what they open, under whose name, how they change, and what is written down of it.

use crate::service::{PATIENCE, Service, within};
use railgrip_health::access::{Role, tokens};
use serde_json::Value;

#[test]
fn tokens_open_what_their_role_allows_and_are_rotated_without_a_restart() {
    let service = Service::start("", true);
    let file = service.file("tokens.toml");
    let of = |name: &str, role| tokens::add(&file, name, role, None).unwrap();
    let (reader, worker, admin) =
        (of("reader", Role::Read), of("worker", Role::Acknowledge), of("admin", Role::Admin));
    let as_ = |token: &str| format!("Bearer {token}");
    let get = |path: &str, token: &str| service.get(path, &[("authorization", &as_(token))]).0;
    assert!(
        within(PATIENCE, || get("/api/v1/train", &reader) == 200),
        "tokens are read while the service runs"
    );

    let (status, headers, body) = service.get("/api/v1/wagons", &[]);
    assert_eq!(status, 401, "{body}");
    assert!(
        headers.contains("application/problem+json") && headers.contains("www-authenticate: Bearer"),
        "{headers}"
    );
    assert_eq!(service.get("/api/v1/wagons", &[("authorization", "Bearer railgrip_wrong")]).0, 401);
    assert_eq!(
        service.get("/health/ready", &[]).0,
        503,
        "a supervisor holds no token; nothing feeds this service"
    );

    let act = |token: &str| {
        let body = "{\"by\":\"depot\"}";
        service.post("/api/v1/alerts/7/acknowledge", &[("authorization", &as_(token))], body).0
    };
    assert_eq!((act(&reader), act(&worker), act(&admin)), (403, 404, 404), "there is no alert 7");
    assert_eq!(get("/api/v1/audit", &reader), 403);
    assert_eq!(get("/api/v1/audit", &worker), 403);
    assert_eq!(get("/api/v1/audit", &admin), 200);

    let kept = std::fs::read_to_string(&file).unwrap();
    for secret in [&reader, &worker, &admin] {
        assert!(!kept.contains(secret.as_str()), "only hashes are kept");
        assert!(!service.audit().contains(secret.as_str()), "no secret in the log");
    }

    let renewed = tokens::rotate(&file, "reader", 3600).unwrap();
    assert!(within(PATIENCE, || get("/api/v1/train", &renewed) == 200));
    assert_eq!(get("/api/v1/train", &reader), 200, "the old secret counts for an hour more");
    let again = tokens::rotate(&file, "reader", 0).unwrap();
    assert!(within(PATIENCE, || get("/api/v1/train", &renewed) == 401), "without overlap it ends at once");
    assert_eq!(get("/api/v1/train", &again), 200);
    tokens::revoke(&file, "reader").unwrap();
    assert!(within(PATIENCE, || get("/api/v1/train", &again) == 401), "revoked");

    assert!(within(PATIENCE, || service.audit().contains("token_reload")));
    let lines: Vec<Value> =
        service.audit().lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    let found = |who: &str, status: u16| {
        lines.iter().any(|line| line["who"] == who && line["status"] == status && line["method"] == "POST")
    };
    assert!(found("worker", 404) && found("reader", 403), "{lines:?}");
    assert!(lines.iter().any(|line| line["status"] == 401 && line["event"] == "refused"));
}

#[test]
fn whoever_shows_a_token_acts_under_its_name() {
    let service = Service::start("", true);
    let file = service.file("tokens.toml");
    let kim = tokens::add(&file, "kim", Role::Acknowledge, None).unwrap();
    let bearer = format!("Bearer {kim}");
    let headers = [("authorization", bearer.as_str())];
    assert!(within(PATIENCE, || service.get("/api/v1/train", &headers).0 == 200));
    let (_, _, told) = service.get("/api/v1/identity", &headers);
    assert_eq!(told, r#"{"name":"kim","role":"acknowledge"}"#);
    // The name of the token comes first; whom the body names, if anybody, stands behind it.
    for (body, by) in [
        (r#"{"by":"boss","text":"squeals"}"#, "kim (boss)"),
        (r#"{"by":" kim ","text":"squeals"}"#, "kim"),
        (r#"{"text":"squeals"}"#, "kim"),
    ] {
        let (status, _, told) = service.post("/api/v1/wagons/1/notes", &headers, body);
        let told: Value = serde_json::from_str(&told).unwrap();
        let notes = told["notes"].as_array().unwrap();
        let signed = notes.iter().filter(|note| note["by"] == by).count();
        assert!(status == 200 && signed >= 1, "{by}: {told}");
    }
    let id = service.raise();
    for (act, body, by) in [
        ("acknowledge", r#"{"by":"boss"}"#, "kim (boss)"),
        ("unacknowledge", "{}", "kim"),
        ("silence", r#"{"by":"boss","why":"known","duration_s":3600}"#, "kim (boss)"),
        ("unsilence", "{}", "kim"),
    ] {
        let (status, _, told) = service.post(&format!("/api/v1/alerts/{id}/{act}"), &headers, body);
        let told: Value = serde_json::from_str(&told).unwrap();
        let last = told["history"].as_array().unwrap().last().unwrap();
        assert_eq!((status, &last["by"]), (200, &Value::from(by)), "{act}: {told}");
    }
    let open = Service::start("", false);
    assert_eq!(open.get("/api/v1/identity", &[]).2, r#"{"name":null,"role":"admin"}"#);
    let (status, _, told) = open.post("/api/v1/wagons/1/notes", &[], r#"{"text":"squeals"}"#);
    assert!(status == 422 && told.contains("`by`"), "without tokens people sign themselves: {told}");
}

/// Somebody without a token once wrote all 25 MB of the log out within half a minute.
#[test]
fn strangers_write_nobody_out_of_the_audit_log() {
    let service = Service::start("[http.audit]\nmax_mb = 0.01\nkeep = 2\n", true);
    let kim = tokens::add(&service.file("tokens.toml"), "kim", Role::Acknowledge, None).unwrap();
    let bearer = format!("Bearer {kim}");
    let headers = [("authorization", bearer.as_str())];
    assert!(within(PATIENCE, || service.get("/api/v1/train", &headers).0 == 200));
    assert_eq!(service.post("/api/v1/wagons/1/notes", &headers, r#"{"text":"squeals"}"#).0, 200);
    for _ in 0..100 {
        service.post("/health/live", &[], "");
        service.post("/api/v1/wagons/1/notes", &[], "");
    }
    let log = std::fs::read_to_string(service.file("i/audit.jsonl")).unwrap();
    assert!(log.contains("\"start\"") && log.contains("\"kim\"") && !log.contains("/health/live"), "{log}");
    assert!(service.audit().contains("/health/live"), "and it is known that they came");
}
