//! Requests, token files and instants that nobody should send: each is answered or refused with words, none makes the
//! service panic or answer with a fault of its own.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

use axum::body::Body;
use axum::http::{Method, Request};
use http_body_util::BodyExt;
use proptest::prelude::*;
use railgrip_health::access::tokens;
use railgrip_health::api::router;
use railgrip_health::shared::Shared;
use railgrip_health::store::Store;
use railgrip_health::time::parse_rfc3339;
use railgrip_messages::Stamp;
use railgrip_settings::{Overrides, TrainSettings};
use std::path::Path;
use tower::ServiceExt;

const NOW: Stamp = Stamp { unix_ns: 1_772_366_400_000_000_000, monotonic_ns: 100_000_000_000 };

fn settings(cases: u32) -> ProptestConfig {
    let rng_seed = proptest::test_runner::RngSeed::Fixed(23);
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(cases);
    ProptestConfig { cases, rng_seed, failure_persistence: None, ..ProptestConfig::default() }
}

/// Status and body of an answer.
fn ask(method: Method, target: &str, body: Vec<u8>) -> Option<(u16, String)> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/railgrip.toml");
    let mut store = Store::new(&TrainSettings::load(Some(&file), &Overrides::default()).unwrap());
    let router = router(Shared::new(store.snapshot(NOW), || NOW));
    // What is no request at all never reaches the routes.
    let request = Request::builder().method(method).uri(target).header("content-type", "application/json");
    let request = request.body(Body::from(body)).ok()?;
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(async {
        let response = router.oneshot(request).await.unwrap();
        let status = response.status().as_u16();
        let endless = response.headers().get("content-type").is_some_and(|kind| kind == "text/event-stream");
        let body = if endless {
            Vec::new()
        } else {
            response.into_body().collect().await.unwrap().to_bytes().to_vec()
        };
        Some((status, String::from_utf8_lossy(&body).into_owned()))
    })
}

proptest! {
    #![proptest_config(settings(300))]

    #[test]
    fn no_request_makes_the_service_panic(
        path in "/(api/v1/)?(wagons|alerts|events|history|history/export|train|docs|live|wagons/1/history|wagons/[0-9a-z%]{0,6}|alerts/[0-9a-z%-]{0,8}(/acknowledge|/unacknowledge|/silence|/unsilence|/shelve|/unshelve)?)",
        query in "((from|to|step|fields|limit|after|grade|state|wagon|kind|format)=[0-9a-zA-Z%:.+,_-]{0,12}&){0,4}",
        post in any::<bool>(),
        body in prop_oneof![
            Just(Vec::new()),
            prop::collection::vec(any::<u8>(), 0..60),
            "\\{\"(by|why|note|duration_s)\":(\"[a-z]{0,4}\"|[0-9e.-]{1,6}|null|\\[\\])\\}".prop_map(String::into_bytes),
        ],
    ) {
        let method = if post { Method::POST } else { Method::GET };
        if let Some((status, said)) = ask(method, &format!("{path}?{query}"), body) {
            prop_assert!(status < 500, "{}: {}", status, said);
            prop_assert!(status < 400 || said.contains("\"detail\"") || said.contains("<html"), "{}: {}", status, said);
        }
    }

    #[test]
    fn no_token_file_makes_the_service_panic(
        text in "(schema = [0-9]\\n|\\[\\[token\\]\\]\\n|(name|role|sha256|created|expires|previous_sha256|previous_until) = (\"[0-9a-fA-FTZ:-]{0,70}\"|[0-9]{1,4})\\n|\\PC){0,12}",
    ) {
        if let Err(error) = tokens::parse(Path::new("tokens.toml"), &text) {
            prop_assert!(error.to_string().contains("tokens.toml"));
        }
    }

    #[test]
    fn no_instant_makes_the_service_panic(text in "\\PC{0,40}|[0-9]{4}-[0-9]{2}-[0-9]{2}T[0-9:.]{1,12}(Z|[+-][0-9:]{1,6})?") {
        if let Some(seconds) = parse_rfc3339(&text) {
            prop_assert!(seconds.is_finite());
        }
    }
}
