//! The cookie of a session.

use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::Response;

/// Browsers take a cookie of that name only over TLS and for this very host.
fn cookie_name(tls: bool) -> &'static str {
    if tls { "__Host-railgrip" } else { "railgrip_session" }
}

/// The session that a browser shows.
pub(super) fn session(headers: &HeaderMap, tls: bool) -> Option<String> {
    let name = cookie_name(tls);
    headers.get_all(header::COOKIE).iter().filter_map(|value| value.to_str().ok()).find_map(|cookies| {
        cookies.split(';').find_map(|cookie| {
            let (key, value) = cookie.trim().split_once('=')?;
            (key == name).then(|| value.to_owned())
        })
    })
}

/// Has a browser keep a session for this long; an empty one for 0 s has it forget.
pub(super) fn set_cookie(response: &mut Response, session: &str, lasts_s: u64, tls: bool) {
    let secure = if tls { "; Secure" } else { "" };
    let name = cookie_name(tls);
    let text = format!("{name}={session}; Path=/; Max-Age={lasts_s}; HttpOnly; SameSite=Strict{secure}");
    if let Ok(value) = HeaderValue::from_str(&text) {
        response.headers_mut().append(header::SET_COOKIE, value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cookie_is_found_among_others() {
        let mut headers = HeaderMap::new();
        headers
            .insert(header::COOKIE, HeaderValue::from_static("a=b; railgrip_session=x~1; __Host-railgrip=y"));
        assert_eq!(session(&headers, false).as_deref(), Some("x~1"));
        assert_eq!(session(&headers, true).as_deref(), Some("y"));
        assert_eq!(session(&HeaderMap::new(), true), None);
    }
}
