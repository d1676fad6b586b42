//! What a client takes (`Accept`, `Accept-Encoding`), and in which form it may send something (`Content-Type`).

use crate::api::problem::Problem;
use axum::body::Body;
use axum::extract::Request;
use axum::http::{HeaderMap, HeaderName, HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use hyper::body::Body as HttpBody;

/// Refuses bodies in other forms than JSON, and answers in forms that the client does not take.
pub(super) async fn negotiate(request: Request, next: Next) -> Response {
    let path = request.uri().path();
    let of_interface = path.starts_with("/api/") || path == "/openapi.json";
    if !of_interface {
        return next.run(request).await;
    }
    let changes = !matches!(*request.method(), Method::GET | Method::HEAD | Method::OPTIONS);
    if changes {
        // Before anything is changed. Routes that take no such method say so themselves.
        if path.starts_with("/api/v1/alerts/") {
            if let Some(problem) = unsupported(request.headers(), request.body()) {
                return problem;
            }
            if !takes(request.headers(), "application/json") {
                return unacceptable("application/json");
            }
        }
        return next.run(request).await;
    }
    let headers = request.headers().get(header::ACCEPT).is_some().then(|| request.headers().clone());
    let response = next.run(request).await;
    let Some(headers) = headers.filter(|_| response.status().is_success()) else { return response };
    let kind = response.headers().get(header::CONTENT_TYPE).and_then(|kind| kind.to_str().ok());
    let kind = kind.unwrap_or_default().split(';').next().unwrap_or_default().trim().to_owned();
    if kind.is_empty() || takes(&headers, &kind) { response } else { unacceptable(&kind) }
}

fn unacceptable(kind: &str) -> Response {
    let detail = format!("the answer is {kind}, and the header `Accept` does not allow that");
    Problem::new(StatusCode::NOT_ACCEPTABLE, detail).into_response()
}

/// A refusal if there is a body that says that it is no JSON.
fn unsupported(headers: &HeaderMap, body: &Body) -> Option<Response> {
    let kind = headers.get(header::CONTENT_TYPE).map(|kind| kind.to_str().unwrap_or_default());
    let kind = kind.map(|kind| kind.split(';').next().unwrap_or_default().trim().to_ascii_lowercase());
    let detail = match kind.as_deref() {
        Some("application/json") => return None,
        None if HttpBody::is_end_stream(body) => return None,
        Some(kind) => format!("the body is {kind:?}; taken is application/json"),
        None => "the body has no Content-Type; taken is application/json".to_owned(),
    };
    let mut response = Problem::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, detail).into_response();
    let taken = HeaderValue::from_static("application/json");
    response.headers_mut().insert(HeaderName::from_static("accept-post"), taken);
    Some(response)
}

/// True if `Accept` allows this media type; without that header everything is allowed.
pub(crate) fn takes(headers: &HeaderMap, kind: &str) -> bool {
    quality(headers, header::ACCEPT, kind).is_none_or(|quality| quality > 0.0)
}

/// How much a client wants something by a header such as `Accept`; `None` if it does not say anything at all. The most
/// particular range that fits counts.
pub(crate) fn quality(headers: &HeaderMap, name: HeaderName, what: &str) -> Option<f64> {
    let all = what.split_once('/').map(|(kind, _)| format!("{kind}/*"));
    let mut said = false;
    let mut best = (0, 0.0);
    let values = headers.get_all(name).iter().filter_map(|value| value.to_str().ok());
    for range in values.flat_map(|value| value.split(',')) {
        let mut parts = range.split(';').map(str::trim);
        let name = parts.next().unwrap_or_default();
        if name.is_empty() {
            continue;
        }
        said = true;
        let weight = parts.find_map(|part| part.strip_prefix("q=").or_else(|| part.strip_prefix("Q=")));
        let quality = weight.map_or(1.0, |weight| weight.trim().parse().unwrap_or(0.0));
        let rank = match name {
            _ if name.eq_ignore_ascii_case(what) => 3,
            _ if all.as_deref().is_some_and(|all| name.eq_ignore_ascii_case(all)) => 2,
            "*/*" | "*" => 1,
            _ => 0,
        };
        if rank > best.0 || (rank == best.0 && rank > 0 && quality > best.1) {
            best = (rank, quality);
        }
    }
    said.then_some(best.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_most_particular_range_counts() {
        for (accept, json) in [
            ("*/*", true),
            ("", true),
            ("application/json", true),
            ("Application/JSON; charset=utf-8", true),
            ("application/*", true),
            ("text/html", false),
            ("text/html, */*;q=0.1", true),
            ("application/json;q=0, */*", false),
            ("application/json;q=0.5, */*;q=0", true),
            ("application/*;q=0, application/json", true),
        ] {
            let mut headers = HeaderMap::new();
            headers.insert(header::ACCEPT, HeaderValue::from_static(accept));
            assert_eq!(takes(&headers, "application/json"), json, "{accept:?}");
        }
        assert!(takes(&HeaderMap::new(), "application/json"));
        let mut headers = HeaderMap::new();
        headers.insert(header::ACCEPT_ENCODING, HeaderValue::from_static("gzip;q=0.2, br, *;q=0"));
        assert_eq!(quality(&headers, header::ACCEPT_ENCODING, "gzip"), Some(0.2));
        assert_eq!(quality(&headers, header::ACCEPT_ENCODING, "zstd"), Some(0.0));
    }
}
