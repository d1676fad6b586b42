//! Answers that are the same for everybody until there is a newer snapshot.

use crate::store::Snapshot;
use axum::body::Bytes;
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};

/// An answer of JSON that is already written.
pub(crate) fn as_json(body: Bytes) -> Response {
    ([(header::CONTENT_TYPE, HeaderValue::from_static("application/json"))], body).into_response()
}

/// What is the same in every answer from one snapshot has a tag that costs nothing to make.
pub(crate) fn of_snapshot(snapshot: &Snapshot, body: Bytes) -> Response {
    let tag = format!("W/\"{:x}-{:x}\"", snapshot.as_of.unix_ns, snapshot.alert_version);
    let mut response = as_json(body);
    if let Ok(tag) = HeaderValue::from_str(&tag) {
        response.headers_mut().insert(header::ETAG, tag);
    }
    response
}
