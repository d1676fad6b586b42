//! What browsers are kept from doing for strangers.
//!
//! * A page elsewhere must not change anything here with this browser's session, or with a service on this machine that asks for no token:
//!   whatever changes something must come from a page of this service (`Sec-Fetch-Site`, else `Origin`). Session cookies
//!   are `SameSite=Strict` besides.
//! * A page elsewhere must not read a service without tokens by giving its own name our address (DNS rebinding): where no token is
//!   asked for, the service must be called by an address, by `localhost`, or by a name in `[http] hosts`.
//!
//! A header of a token is sent by no page unasked, so whoever shows one passes.

use crate::access::role::Proof;
use axum::http::{HeaderMap, Uri, Version, header};
use std::net::IpAddr;

/// True if the request has as many `Host` headers as it should (RFC 9112, 3.2): a proxy may read one of two, and we the other.
pub(super) fn names_one_host(version: Version, headers: &HeaderMap) -> bool {
    let hosts = headers.get_all(header::HOST).iter().count();
    hosts == 1 || (hosts == 0 && version != Version::HTTP_11)
}

/// True if the name that the request was sent to is one of ours, or nothing hangs on it.
pub(super) fn host_is_known(uri: &Uri, headers: &HeaderMap, hosts: &[String]) -> bool {
    let Some(authority) = authority(uri, headers) else { return true };
    let host = host_of(&authority);
    let bare = host.trim_start_matches('[').trim_end_matches(']');
    bare.parse::<IpAddr>().is_ok()
        || host == "localhost"
        || host.ends_with(".localhost")
        || hosts.iter().any(|known| *known == host)
}

/// True if a request that changes something may have been meant by whoever sent it.
pub(super) fn is_meant(
    uri: &Uri,
    headers: &HeaderMap,
    proof: Proof,
    scheme: &str,
    cors_origins: &[String],
) -> bool {
    if matches!(proof, Proof::Token | Proof::Local) {
        return true;
    }
    let text = |name| headers.get(name).and_then(|value: &axum::http::HeaderValue| value.to_str().ok());
    let origin = text(header::ORIGIN.as_str());
    // Another origin may be let in by the config where no tokens are asked for; a session it never gets.
    if proof == Proof::None && origin.is_some_and(|origin| cors_origins.iter().any(|known| known == origin)) {
        return true;
    }
    match text("sec-fetch-site") {
        Some("same-origin") => return true,
        // The address bar, or a form that the user opened without a page; no page can bring it about.
        Some("none") => return true,
        Some(_) => return false,
        None => {}
    }
    match origin {
        Some(origin) => {
            let ours = authority(uri, headers).unwrap_or_default();
            origin.split_once("://").is_some_and(|(theirs, rest)| {
                rest.eq_ignore_ascii_case(&ours) && (theirs == scheme || scheme == "http")
            })
        }
        // Browsers name the origin of whatever is not a GET; a program without a session may leave it out.
        None => proof == Proof::None,
    }
}

/// The name and port that the request was sent to.
fn authority(uri: &Uri, headers: &HeaderMap) -> Option<String> {
    let text = uri.authority().map(|authority| authority.as_str().to_owned());
    let text = text.or_else(|| headers.get(header::HOST)?.to_str().ok().map(str::to_owned))?;
    Some(text.to_ascii_lowercase())
}

/// Without the port.
fn host_of(authority: &str) -> &str {
    match authority.rsplit_once(':') {
        Some((host, port)) if port.bytes().all(|byte| byte.is_ascii_digit()) => host,
        _ => authority,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::{HeaderName, HeaderValue};

    fn headers(pairs: &[(&str, &str)]) -> HeaderMap {
        let pair = |(name, value): &(&str, &str)| {
            (name.parse::<HeaderName>().expect("name"), HeaderValue::from_str(value).expect("value"))
        };
        pairs.iter().map(pair).collect()
    }

    #[test]
    fn strange_names_are_not_ours() {
        let hosts = vec!["train7.example".to_owned()];
        let uri = Uri::from_static("/");
        for (host, ours) in [
            ("127.0.0.1:8080", true),
            ("[::1]:8080", true),
            ("[::1]", true),
            ("localhost", true),
            ("LocalHost:80", true),
            ("train7.example:443", true),
            ("evil.example", false),
            ("127.0.0.1.evil.example", false),
            ("localhost.evil.example:8080", false),
            ("", false),
        ] {
            assert_eq!(host_is_known(&uri, &headers(&[("host", host)]), &hosts), ours, "{host}");
        }
        assert!(host_is_known(&uri, &headers(&[]), &hosts), "HTTP/1.0 names none");
        let absolute = Uri::from_static("http://evil.example/");
        assert!(!host_is_known(&absolute, &headers(&[("host", "localhost")]), &hosts));
    }

    #[test]
    fn pages_elsewhere_change_nothing() {
        let uri = Uri::from_static("/api/v1/alerts/1/acknowledge");
        let host = ("host", "127.0.0.1:8080");
        let meant = |pairs: &[(&str, &str)], proof| is_meant(&uri, &headers(pairs), proof, "http", &[]);
        for proof in [Proof::None, Proof::Session] {
            assert!(meant(&[host, ("sec-fetch-site", "same-origin")], proof));
            assert!(!meant(&[host, ("sec-fetch-site", "cross-site")], proof));
            assert!(!meant(&[host, ("sec-fetch-site", "same-site")], proof));
            assert!(meant(&[host, ("origin", "http://127.0.0.1:8080")], proof));
            assert!(!meant(&[host, ("origin", "http://127.0.0.1:9090")], proof));
            assert!(!meant(&[host, ("origin", "null")], proof));
        }
        assert!(meant(&[host], Proof::None), "curl");
        assert!(!meant(&[host], Proof::Session));
        assert!(meant(&[host, ("origin", "http://evil.example")], Proof::Token));
        let cors = vec!["https://depot.example".to_owned()];
        let from_depot =
            headers(&[host, ("origin", "https://depot.example"), ("sec-fetch-site", "cross-site")]);
        assert!(is_meant(&uri, &from_depot, Proof::None, "http", &cors));
        assert!(!is_meant(&uri, &from_depot, Proof::Session, "http", &cors));
    }

    #[test]
    fn a_page_without_tls_is_another_origin() {
        let uri = Uri::from_static("/logout");
        let pairs = headers(&[("host", "train7:8443"), ("origin", "http://train7:8443")]);
        assert!(!is_meant(&uri, &pairs, Proof::Session, "https", &[]));
    }
}
