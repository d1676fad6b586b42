//! Thresholds, shown and changed over the interface without a socket.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

use axum::body::Body;
use axum::http::{Request, StatusCode, header};
use http_body_util::BodyExt;
use railgrip_health::api::router;
use railgrip_health::limits::Limits;
use railgrip_health::shared::Shared;
use railgrip_health::store::Store;
use railgrip_messages::Stamp;
use railgrip_settings::{Overrides, TrainSettings};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use tower::ServiceExt;

const NOW: Stamp = Stamp { unix_ns: 1_772_366_400_000_000_000, monotonic_ns: 100_000_000_000 };
const CONFIG: &str = "schema = 1\n\n[train]\nname = \"t\"\nwagons = 2\nvehicle = \"vehicle.toml\"\n\n[source]\n\
                      kind = \"stdin\"\n\n[indicators.wsp]\n# since the trial in May\nshare_watch = 0.3\n";

/// A config file and its vehicle file in a folder.
fn config(folder: &Path) -> PathBuf {
    let vehicle = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/vehicle.toml");
    std::fs::copy(vehicle, folder.join("vehicle.toml")).unwrap();
    let file = folder.join("train.toml");
    std::fs::write(&file, CONFIG).unwrap();
    file
}

fn shared(file: &Path) -> Shared {
    let settings = TrainSettings::load(Some(file), &Overrides::default()).unwrap();
    let shared = Shared::new(Store::new(&settings).snapshot(NOW), || NOW);
    shared.judge_by(Limits::of(&settings));
    shared
}

async fn ask(shared: &Shared, path: &str, body: Option<&Value>) -> (StatusCode, String) {
    let request = Request::builder().uri(path).header(header::HOST, "localhost");
    let request = match body {
        Some(body) => request
            .method("POST")
            .header(header::CONTENT_TYPE, "application/json")
            .body(Body::from(body.to_string())),
        None => request.body(Body::empty()),
    };
    let response = router(shared.clone()).oneshot(request.unwrap()).await.unwrap();
    let status = response.status();
    let bytes = response.into_body().collect().await.unwrap().to_bytes();
    (status, String::from_utf8(bytes.to_vec()).unwrap())
}

#[tokio::test]
async fn a_threshold_is_changed_in_the_file_with_who_when_and_why() {
    let folder = tempfile::tempdir().unwrap();
    let file = config(folder.path());
    let shared = shared(&file);
    let wsp = |text: &str| -> Value {
        let list: Value = serde_json::from_str(text).unwrap();
        let all = list["settings"].as_array().unwrap();
        all.iter().find(|setting| setting["key"] == "wsp.share_watch").unwrap().clone()
    };
    let (status, before) = ask(&shared, "/api/v1/settings", None).await;
    assert_eq!(status, StatusCode::OK);
    let told = wsp(&before);
    assert_eq!(
        (&told["value"], &told["default"], &told["range"]),
        (&json!(0.3), &json!(0.25), &json!([0.0, 1.0]))
    );
    assert_eq!(told["words"], "Watch above this share of the braking time.");

    let change = json!({"key": "wsp.share_watch", "value": 0.35, "by": "kim", "why": "new valves"});
    let (status, after) = ask(&shared, "/api/v1/settings", Some(&change)).await;
    assert_eq!(status, StatusCode::OK, "{after}");
    assert_eq!((&wsp(&after)["value"], &wsp(&after)["next"]), (&json!(0.3), &json!(0.35)));
    let expected = CONFIG.replace(
        "share_watch = 0.3",
        "# changed from 0.3 by kim at 2026-03-01T12:00:00.000Z: new valves\nshare_watch = 0.35",
    );
    assert_eq!(std::fs::read_to_string(&file).unwrap(), expected);
    let (status, page) = ask(&shared, "/settings", None).await;
    assert_eq!(status, StatusCode::OK);
    for needed in
        ["wsp.share_watch", "next start: 0.35", "wait until the processes start again", "data-setting"]
    {
        assert!(page.contains(needed), "{needed}");
    }
}

#[tokio::test]
async fn what_the_file_would_be_refused_for_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let file = config(folder.path());
    let shared = shared(&file);
    for (change, status, said) in [
        (json!({"key": "wsp.share_watch", "value": 1.5, "by": "kim", "why": "x"}), 409, "allowed"),
        (json!({"key": "wsp.share_watch", "value": 0.8, "by": "kim", "why": "x"}), 409, "share_act"),
        (json!({"key": "wsp.share", "value": 0.3, "by": "kim", "why": "x"}), 404, "wsp.share"),
        (json!({"key": "wsp.share_watch", "value": 0.35, "why": "x"}), 422, "`by`"),
        (json!({"key": "wsp.share_watch", "value": 0.35, "by": "kim", "why": "a\nb = 1"}), 422, "`why`"),
        (json!({"key": "wsp.share_watch", "value": 0.35, "by": "kim"}), 422, "why"),
    ] {
        let (found, problem) = ask(&shared, "/api/v1/settings", Some(&change)).await;
        assert!(found.as_u16() == status && problem.contains(said), "{change}: {found} {problem}");
    }
    assert_eq!(std::fs::read_to_string(&file).unwrap(), CONFIG);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing is left beside the file");
}

#[tokio::test]
async fn a_receiver_is_added_changed_and_removed_in_the_file() {
    const PATH: &str = "/api/v1/settings/receivers";
    let folder = tempfile::tempdir().unwrap();
    let file = config(folder.path());
    let night = "\n[[receiver]]\nkind = \"webhook\"\nname = \"night\"\nurl = \"https://night.example/T0/word\"\ntoken_file = \"night.token\"\n";
    std::fs::write(&file, CONFIG.to_owned() + night).unwrap();
    let shared = shared(&file);
    let states = |text: &str| -> Vec<String> {
        let list: Value = serde_json::from_str(text).unwrap();
        let one = |one: &Value| {
            format!(
                "{} {} {} now {} next {}",
                one["name"], one["address"], one["grade"], one["now"], one["next"]
            )
            .replace('"', "")
        };
        list["receivers"].as_array().unwrap().iter().map(one).collect()
    };
    let (status, before) = ask(&shared, PATH, None).await;
    assert_eq!(status, StatusCode::OK);
    assert_eq!(states(&before), ["night https://night.example watch now true next true"]);
    assert!(!before.contains("word"), "the path of an address may be a secret: {before}");

    let add = json!({"name": "depot", "kind": "mqtt", "host": "broker", "grade": "act", "by": "kim", "why": "trial"});
    let (status, after) = ask(&shared, PATH, Some(&add)).await;
    assert_eq!(status, StatusCode::OK, "{after}");
    let told =
        ["night https://night.example watch now true next true", "depot broker:1883 act now false next true"];
    assert_eq!(states(&after), told);
    let change = json!({"name": "night", "grade": "act", "by": "lee", "why": "too many"});
    assert_eq!(ask(&shared, PATH, Some(&change)).await.0, StatusCode::OK);
    let text = std::fs::read_to_string(&file).unwrap();
    for line in [
        "# receiver depot added by kim at 2026-03-01T12:00:00.000Z: trial\n[[receiver]]\nkind = \"mqtt\"\nname = \"depot\"\n",
        "# receiver night changed by lee at 2026-03-01T12:00:00.000Z: too many\n[[receiver]]\nkind = \"webhook\"\nname = \"night\"\n",
        "token_file = \"night.token\"\ngrade = \"act\"\n",
        "# since the trial in May\nshare_watch = 0.3\n",
    ] {
        assert!(text.contains(line), "{line}\nin\n{text}");
    }
    let (_, page) = ask(&shared, "/settings", None).await;
    for needed in [
        "from the next start on",
        "data-receiver=\"depot\"",
        "data-secret",
        "wait until the processes start again",
    ] {
        assert!(page.contains(needed), "{needed}");
    }
    let remove = json!({"name": "night", "remove": true, "by": "kim", "why": "moved"});
    let (status, after) = ask(&shared, PATH, Some(&remove)).await;
    assert_eq!(status, StatusCode::OK);
    let told = [
        "depot broker:1883 act now false next true",
        "night https://night.example watch now true next false",
    ];
    assert_eq!(states(&after), told);
    let settings = TrainSettings::load(Some(&file), &Overrides::default()).unwrap();
    assert_eq!(settings.notify.receivers.len(), 1, "the next start reads what was written");
}

#[tokio::test]
async fn a_broker_is_reached_by_tls_and_its_authorities_are_checked_before_they_are_written() {
    const PATH: &str = "/api/v1/settings/receivers";
    let folder = tempfile::tempdir().unwrap();
    let file = config(folder.path());
    let shared = shared(&file);
    let add = |ca: &str| json!({"name": "yard", "kind": "mqtt", "host": "broker", "tls": true, "ca_file": ca, "by": "kim", "why": "x"});
    let (status, problem) = ask(&shared, PATH, Some(&add("ca.pem"))).await;
    assert!(status == 409 && problem.contains("receiver.1.ca_file"), "{status} {problem}");
    assert_eq!(std::fs::read_to_string(&file).unwrap(), CONFIG);
    let ca = folder.path().join("ca.pem");
    std::fs::write(&ca, "-----BEGIN CERTIFICATE-----\n").unwrap();
    let (status, told) = ask(&shared, PATH, Some(&add("ca.pem"))).await;
    assert_eq!(status, StatusCode::OK, "{told}");
    let one = |text: &str| serde_json::from_str::<Value>(text).unwrap()["receivers"][0].clone();
    let (told, path) = (one(&told), json!(ca.display().to_string()));
    assert_eq!(
        (&told["address"], &told["tls"], &told["ca_file"]),
        (&json!("broker:8883"), &json!(true), &path)
    );
    let (_, page) = ask(&shared, "/settings?lang=de", None).await;
    for words in ["Zertifizierungsstellen in", "data-tls", "ca.pem"] {
        assert!(page.contains(words), "{words}: {page}");
    }
    let off = json!({"name": "yard", "tls": false, "by": "kim", "why": "x"});
    let (_, told) = ask(&shared, PATH, Some(&off)).await;
    let told = one(&told);
    assert_eq!(
        (&told["address"], &told["tls"], &told["ca_file"]),
        (&json!("broker:1883"), &json!(false), &Value::Null)
    );
    // A webhook has no such key.
    let wrong = json!({"name": "hook", "kind": "webhook", "url": "https://depot/a", "tls": true, "by": "kim", "why": "x"});
    let (status, problem) = ask(&shared, PATH, Some(&wrong)).await;
    assert!(status == 409 && problem.contains("tls"), "{status} {problem}");
}

#[tokio::test]
async fn a_login_in_an_address_is_a_secret_that_is_not_told_and_not_sent_in_the_clear() {
    const PATH: &str = "/api/v1/settings/receivers";
    let folder = tempfile::tempdir().unwrap();
    let file = config(folder.path());
    let login = "\n[[receiver]]\nkind = \"webhook\"\nname = \"near\"\nurl = \"http://kim:word@127.0.0.1:9/a\"\n\
                 [[receiver]]\nkind = \"webhook\"\nname = \"open\"\nurl = \"http://depot:9/a\"\n";
    std::fs::write(&file, CONFIG.to_owned() + login).unwrap();
    let shared = shared(&file);
    let (status, text) = ask(&shared, PATH, None).await;
    assert_eq!(status, StatusCode::OK);
    let list: Value = serde_json::from_str(&text).unwrap();
    let told: Vec<_> =
        list["receivers"].as_array().unwrap().iter().map(|one| (&one["address"], &one["secret"])).collect();
    let (near, open) = (json!("http://127.0.0.1:9"), json!("http://depot:9"));
    assert_eq!(told, [(&near, &json!(true)), (&open, &json!(false))]);
    assert!(!text.contains("word") && !text.contains("kim"), "{text}");
    for (change, said) in [
        (json!({"name": "near", "url": "http://127.0.0.1:10/a", "by": "lee", "why": "x"}), "secret"),
        (
            json!({"name": "open", "url": "http://kim:word@depot:9/a", "by": "lee", "why": "x"}),
            "receiver.2.url",
        ),
    ] {
        let (status, problem) = ask(&shared, PATH, Some(&change)).await;
        assert!(status == 409 && problem.contains(said) && !problem.contains("word@"), "{status} {problem}");
    }
    assert_eq!(std::fs::read_to_string(&file).unwrap(), CONFIG.to_owned() + login);
}

#[tokio::test]
async fn a_receiver_that_a_start_would_refuse_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let file = config(folder.path());
    let shared = shared(&file);
    for (change, status, said) in [
        (
            json!({"name": "a", "kind": "webhook", "url": "depot", "by": "kim", "why": "x"}),
            409,
            "receiver.1.url",
        ),
        (json!({"name": "a", "kind": "webhook", "by": "kim", "why": "x"}), 409, "url"),
        (
            json!({"name": "a", "kind": "mqtt", "host": "b", "topic": "a/#", "by": "kim", "why": "x"}),
            409,
            "topic",
        ),
        (
            json!({"name": "a", "kind": "mqtt", "host": "b", "url": "http://b", "by": "kim", "why": "x"}),
            409,
            "url",
        ),
        (json!({"name": "a", "url": "http://b", "by": "kim", "why": "x"}), 409, "kind"),
        (json!({"name": "a", "kind": "pigeon", "by": "kim", "why": "x"}), 422, "pigeon"),
        (
            json!({"name": "a", "kind": "mqtt", "host": "b", "token_file": "t", "by": "kim", "why": "x"}),
            422,
            "token_file",
        ),
        (json!({"name": "a", "kind": "mqtt", "host": "b", "why": "x"}), 422, "`by`"),
        (json!({"name": "a\nb", "kind": "mqtt", "host": "b", "by": "kim", "why": "x"}), 422, "`name`"),
        (json!({"name": "a", "remove": true, "by": "kim", "why": "x"}), 404, "[[receiver]] `a`"),
    ] {
        let (found, problem) = ask(&shared, "/api/v1/settings/receivers", Some(&change)).await;
        assert!(found.as_u16() == status && problem.contains(said), "{change}: {found} {problem}");
    }
    assert_eq!(std::fs::read_to_string(&file).unwrap(), CONFIG);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing is left beside the file");
}
