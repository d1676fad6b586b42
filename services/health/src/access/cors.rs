//! Which pages elsewhere may read the interface: none, but for those that `[http] cors_origins` lists.
//!
//! Cookies never travel to another origin: a page elsewhere reads a service without tokens, or sends a token of its own.

use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};

const METHODS: HeaderValue = HeaderValue::from_static("GET, HEAD, POST");
const HEADERS: HeaderValue =
    HeaderValue::from_static("authorization, content-type, if-none-match, last-event-id");
const EXPOSED: HeaderValue = HeaderValue::from_static("etag, link, retry-after, content-disposition");
/// A browser asks again after this time, s.
const MAX_AGE: HeaderValue = HeaderValue::from_static("600");

/// The origin that a request names, if it is one that the config lists.
pub(super) fn allowed(headers: &HeaderMap, origins: &[String]) -> Option<HeaderValue> {
    let origin = headers.get(header::ORIGIN)?;
    origins.iter().any(|known| known.as_bytes() == origin.as_bytes()).then(|| origin.clone())
}

/// True if a browser only asks whether it may ask.
pub(super) fn is_question(method: &Method, headers: &HeaderMap) -> bool {
    method == Method::OPTIONS
        && headers.contains_key(header::ORIGIN)
        && headers.contains_key(header::ACCESS_CONTROL_REQUEST_METHOD)
}

/// The answer to such a question.
pub(super) fn answer() -> Response {
    let mut response = StatusCode::NO_CONTENT.into_response();
    let headers = response.headers_mut();
    headers.insert(header::ACCESS_CONTROL_ALLOW_METHODS, METHODS);
    headers.insert(header::ACCESS_CONTROL_ALLOW_HEADERS, HEADERS);
    headers.insert(header::ACCESS_CONTROL_MAX_AGE, MAX_AGE);
    response
}

/// Lets the page of that origin see the answer. Where origins are listed, answers differ by origin.
pub(super) fn mark(headers: &mut HeaderMap, origin: Option<HeaderValue>, origins: &[String]) {
    if origins.is_empty() {
        return;
    }
    headers.append(header::VARY, HeaderValue::from_static("Origin"));
    if let Some(origin) = origin {
        headers.insert(header::ACCESS_CONTROL_ALLOW_ORIGIN, origin);
        headers.insert(header::ACCESS_CONTROL_EXPOSE_HEADERS, EXPOSED);
        headers.insert("cross-origin-resource-policy", HeaderValue::from_static("cross-origin"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_listed_origins_are_let_in() {
        let origins = vec!["https://depot.example".to_owned()];
        let from = |origin: &'static str| {
            let mut headers = HeaderMap::new();
            headers.insert(header::ORIGIN, HeaderValue::from_static(origin));
            headers
        };
        assert!(allowed(&from("https://depot.example"), &origins).is_some());
        for other in ["https://depot.example.evil", "http://depot.example", "null", "https://DEPOT.example"] {
            assert!(allowed(&from(other), &origins).is_none(), "{other}");
        }
        assert!(allowed(&from("https://depot.example"), &[]).is_none());
        let mut plain = HeaderMap::new();
        mark(&mut plain, None, &[]);
        assert!(plain.is_empty());
        mark(&mut plain, allowed(&from("https://depot.example"), &origins), &origins);
        assert_eq!(plain[header::ACCESS_CONTROL_ALLOW_ORIGIN], "https://depot.example");
        assert!(!plain.contains_key(header::ACCESS_CONTROL_ALLOW_CREDENTIALS));
    }
}
