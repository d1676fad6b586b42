//! The stream of changes.

use super::{NOW, serve, sound_train};
use axum::body::Body;
use axum::http::Request;
use http_body_util::BodyExt;
use railgrip_health::shared::StreamEvent;
use tower::ServiceExt;

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
