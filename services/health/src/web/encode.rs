//! `ETag`, 304, gzip, and refusals as problems.

use crate::api::problem::Problem;
use crate::web::accept::quality;
use crate::web::room;
use axum::body::{Body, Bytes};
use axum::extract::Request;
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use flate2::Compression;
use flate2::write::GzEncoder;
use http_body_util::BodyExt;
use hyper::body::Body as HttpBody;
use std::hash::{DefaultHasher, Hasher};
use std::io::Write;

/// Shorter answers fit into one packet anyhow.
const WORTH_COMPRESSING_BYTES: usize = 1024;
/// Longer ones are compressed where that holds up nobody else.
const LONG_BYTES: usize = 32 * 1024;
/// Level 3 of 9: JSON becomes nearly as small as at 9, in a third of the time.
const LEVEL: Compression = Compression::new(3);

/// What a request says about the answer that it wants.
struct Wish {
    looks: bool,
    known: Option<HeaderValue>,
    gzip: bool,
}

/// Gives answers their `ETag`, compresses them, and turns plain refusals into problems.
pub(crate) async fn encode(request: Request, next: Next) -> Response {
    let headers = request.headers();
    let wish = Wish {
        looks: *request.method() == Method::GET,
        known: headers.get(header::IF_NONE_MATCH).cloned(),
        gzip: takes_gzip(headers),
    };
    let response = next.run(request).await;
    let status = response.status();
    if status.is_client_error() || status.is_server_error() {
        return as_problem(response).await;
    }
    if !wish.looks || status != StatusCode::OK || HttpBody::size_hint(response.body()).exact().is_none() {
        return response;
    }
    room::hold(shape(response, wish).await)
}

/// True if the client takes gzip.
pub(crate) fn takes_gzip(headers: &HeaderMap) -> bool {
    headers.contains_key(header::ACCEPT_ENCODING)
        && quality(headers, header::ACCEPT_ENCODING, "gzip").is_some_and(|quality| quality > 0.0)
}

async fn shape(response: Response, wish: Wish) -> Response {
    let (mut parts, body) = response.into_parts();
    let kept = parts.headers.get(header::CACHE_CONTROL).is_some_and(|cache| cache == "no-store");
    let kind = parts.headers.get(header::CONTENT_TYPE).map_or("", |kind| kind.to_str().unwrap_or_default());
    let compressible = is_text(kind) && !parts.headers.contains_key(header::CONTENT_ENCODING);
    let length = HttpBody::size_hint(&body).exact().unwrap_or(0) as usize;
    let compress = compressible && wish.gzip && length >= WORTH_COMPRESSING_BYTES;
    let tagged = kept || parts.headers.contains_key(header::ETAG);
    if compressible {
        parts.headers.append(header::VARY, HeaderValue::from_static("Accept-Encoding"));
    }
    if !compress && tagged {
        return conditional(Response::from_parts(parts, body), &wish);
    }
    let bytes = match body.collect().await {
        Ok(bytes) => bytes.to_bytes(),
        Err(error) => {
            let detail = format!("the answer broke off: {error}");
            return Problem::new(StatusCode::INTERNAL_SERVER_ERROR, detail).into_response();
        }
    };
    if !tagged && let Ok(tag) = HeaderValue::from_str(&tag(&bytes)) {
        parts.headers.insert(header::ETAG, tag);
    }
    let response = conditional(Response::from_parts(parts, Body::from(bytes.clone())), &wish);
    if !compress || response.status() != StatusCode::OK {
        return response;
    }
    let Some(packed) = compressed(bytes).await else { return response };
    let (mut parts, _) = response.into_parts();
    parts.headers.insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
    parts.headers.remove(header::CONTENT_LENGTH);
    Response::from_parts(parts, Body::from(packed))
}

/// Says how long the answer may be kept, and leaves it out if the client has it.
fn conditional(response: Response, wish: &Wish) -> Response {
    let (mut parts, body) = response.into_parts();
    let Some(tag) = parts.headers.get(header::ETAG).cloned() else {
        return Response::from_parts(parts, body);
    };
    parts.headers.entry(header::CACHE_CONTROL).or_insert(HeaderValue::from_static("private, no-cache"));
    if !wish.known.as_ref().is_some_and(|known| is_known(known, &tag)) {
        return Response::from_parts(parts, body);
    }
    parts.status = StatusCode::NOT_MODIFIED;
    parts.headers.remove(header::CONTENT_TYPE);
    parts.headers.remove(header::CONTENT_LENGTH);
    Response::from_parts(parts, Body::empty())
}

/// Weak, because the same answer travels with and without gzip.
fn tag(bytes: &[u8]) -> String {
    let mut hasher = DefaultHasher::new();
    hasher.write(bytes);
    format!("W/\"{:016x}\"", hasher.finish())
}

/// Compares weakly, as RFC 9110 13.1.2 asks.
fn is_known(known: &HeaderValue, tag: &HeaderValue) -> bool {
    let (Ok(known), Ok(tag)) = (known.to_str(), tag.to_str()) else { return false };
    let bare = |tag: &str| tag.trim().trim_start_matches("W/").to_owned();
    known.trim() == "*" || known.split(',').any(|one| bare(one) == bare(tag))
}

fn is_text(kind: &str) -> bool {
    let kind = kind.split(';').next().unwrap_or_default().trim();
    (kind.starts_with("text/") && kind != "text/event-stream")
        || matches!(kind, "application/json" | "application/problem+json" | "application/openmetrics-text")
        || kind.ends_with("+xml")
}

async fn compressed(bytes: Bytes) -> Option<Vec<u8>> {
    let long = bytes.len() > LONG_BYTES;
    let pack = move || {
        let mut encoder = GzEncoder::new(Vec::with_capacity(bytes.len() / 4), LEVEL);
        encoder.write_all(&bytes).ok()?;
        encoder.finish().ok()
    };
    if long { tokio::task::spawn_blocking(pack).await.ok().flatten() } else { pack() }
}

/// Refusals of the libraries below are plain text; people and programs get them in the form of all others.
async fn as_problem(response: Response) -> Response {
    let kind = response.headers().get(header::CONTENT_TYPE).map(HeaderValue::as_bytes);
    if kind.is_some_and(|kind| !kind.starts_with(b"text/plain")) {
        return response;
    }
    let (mut parts, body) = response.into_parts();
    let text = body.collect().await.unwrap_or_default().to_bytes();
    let text = String::from_utf8_lossy(&text);
    let detail = if text.trim().is_empty() {
        parts.status.canonical_reason().unwrap_or("refused").to_owned()
    } else {
        text.trim().to_owned()
    };
    let problem = Problem::new(parts.status, detail).into_response();
    let (told, body) = problem.into_parts();
    parts.headers.remove(header::CONTENT_LENGTH);
    parts.headers.extend(told.headers);
    Response::from_parts(parts, body)
}
