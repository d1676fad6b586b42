//! What the interface says of itself, of errors, and what its page needs.

use super::{NOW, get, get_json, serve, sound_train};
use axum::body::Body;
use axum::http::{Request, StatusCode, header};
use tower::ServiceExt;

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
