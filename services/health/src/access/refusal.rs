//! Why a request is turned away, and how that is answered.

use crate::access::role::Role;
use crate::api::problem::Problem;
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Redirect, Response};
use std::fmt::Write;
use std::time::Duration;

/// Why a request was turned away.
pub(super) enum Refusal {
    TooMany(Duration),
    StrangeHost,
    HostsDiffer,
    NoToken { page: Option<String> },
    WrongToken { page: Option<String> },
    RoleTooLow { has: Role, needs: Role },
    NotMeant,
    TooLarge(usize),
    TooSlow(Duration),
    Broken,
}

impl Refusal {
    /// For the audit log.
    pub(super) fn word(&self) -> &'static str {
        match self {
            Self::TooMany(_) => "too many requests",
            Self::StrangeHost => "strange host",
            Self::HostsDiffer => "no host, or several",
            Self::NoToken { .. } => "no token",
            Self::WrongToken { .. } => "wrong token",
            Self::RoleTooLow { .. } => "role too low",
            Self::NotMeant => "sent by another page",
            Self::TooLarge(_) => "body too large",
            Self::TooSlow(_) => "body too slow",
            Self::Broken => "body broken",
        }
    }

    pub(super) fn response(&self) -> Response {
        let (status, detail) = match self {
            Self::NoToken { page: Some(page) } | Self::WrongToken { page: Some(page) } => {
                return Redirect::to(&format!("/login?next={}", encoded(page))).into_response();
            }
            Self::TooMany(wait) => {
                let seconds = wait.as_secs_f64().ceil().max(1.0) as u64;
                let detail = format!("too many requests; the next one in {seconds} s");
                let mut response = Problem::new(StatusCode::TOO_MANY_REQUESTS, detail).into_response();
                response.headers_mut().insert(header::RETRY_AFTER, seconds.into());
                return response;
            }
            Self::NoToken { .. } => {
                let detail = "a token is needed: Authorization: Bearer railgrip_…; an operator makes one with `railgrip token add`";
                return unauthorized(detail, "Bearer realm=\"railgrip\"");
            }
            Self::WrongToken { .. } => {
                let challenge = "Bearer realm=\"railgrip\", error=\"invalid_token\"";
                return unauthorized("the token is unknown, revoked or expired", challenge);
            }
            Self::StrangeHost => (
                StatusCode::MISDIRECTED_REQUEST,
                "this service is not known by that name; [http] hosts lists the names that it answers to"
                    .to_owned(),
            ),
            Self::HostsDiffer => (
                StatusCode::BAD_REQUEST,
                "a request of HTTP/1.1 names its host once, in the header `Host`".to_owned(),
            ),
            Self::RoleTooLow { has, needs } => (
                StatusCode::FORBIDDEN,
                format!("the role `{}` does not allow this; `{}` does", has.word(), needs.word()),
            ),
            Self::NotMeant => (
                StatusCode::FORBIDDEN,
                "a session may only be used by pages of this service; programs send a token".to_owned(),
            ),
            Self::TooLarge(most) => {
                (StatusCode::PAYLOAD_TOO_LARGE, format!("the body is too large; allowed are {most} bytes"))
            }
            Self::TooSlow(patience) => (
                StatusCode::REQUEST_TIMEOUT,
                format!("the body took longer than {:.0} s", patience.as_secs_f64()),
            ),
            Self::Broken => (StatusCode::BAD_REQUEST, "the body broke off".to_owned()),
        };
        Problem::new(status, detail).into_response()
    }
}

fn unauthorized(detail: &str, challenge: &'static str) -> Response {
    let mut response = Problem::new(StatusCode::UNAUTHORIZED, detail).into_response();
    response.headers_mut().insert(header::WWW_AUTHENTICATE, HeaderValue::from_static(challenge));
    response
}

/// A path as the value of a query.
fn encoded(path: &str) -> String {
    let mut text = String::with_capacity(path.len());
    for byte in path.bytes() {
        if byte.is_ascii_alphanumeric() || matches!(byte, b'/' | b'-' | b'_' | b'.' | b'~') {
            text.push(char::from(byte));
        } else {
            // Writing into a string cannot fail.
            let _ = write!(text, "%{byte:02X}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_is_written_as_the_value_of_a_query() {
        assert_eq!(encoded("/a b?c=d&e"), "/a%20b%3Fc%3Dd%26e");
    }
}
