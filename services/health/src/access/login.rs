//! Where a browser trades a token for a session, and gives it back.

use crate::access::audit::Record;
use crate::access::control::Access;
use crate::access::cookie::{session, set_cookie};
use crate::access::peer::Peer;
use crate::access::records::records;
use crate::access::role::{Identity, Proof};
use crate::time::unix_s;
use crate::web::language;
use axum::Router;
use axum::extract::{Extension, Form, FromRequest, Query, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Redirect, Response};
use axum::routing::{get, post};
use maud::{DOCTYPE, html};
use railgrip_words::{Language, speak, spoken, t};
use serde::Deserialize;

const STYLE: &str = include_str!("login.css");
/// Longest token that is looked at.
const MAX_TOKEN: usize = 256;

#[derive(Deserialize)]
struct Target {
    next: Option<String>,
}

#[derive(Deserialize)]
struct Entry {
    token: String,
    next: Option<String>,
}

pub(super) fn routes(access: &Access) -> Router {
    Router::new()
        .route("/login", get(form).post(enter))
        .route("/logout", post(leave))
        .route("/login.css", get(style))
        .route("/api/v1/audit", get(records))
        .with_state(access.clone())
}

async fn style() -> impl IntoResponse {
    ([(header::CONTENT_TYPE, "text/css; charset=utf-8")], STYLE)
}

async fn form(State(access): State<Access>, headers: HeaderMap, Query(target): Query<Target>) -> Response {
    let next = own_path(target.next.as_deref());
    if access.inner.tokens.is_none() {
        return Redirect::to(&next).into_response();
    }
    page(language::of_page(None, &headers), StatusCode::OK, &next, None)
}

async fn enter(State(access): State<Access>, headers: HeaderMap, request: Request) -> Response {
    let peer = request.extensions().get::<Peer>().cloned().unwrap_or_default();
    let language = language::of_page(None, &headers);
    let Ok(Form(entry)) = Form::<Entry>::from_request(request, &()).await else {
        return page(language, StatusCode::BAD_REQUEST, "/", Some("Please type a token."));
    };
    let next = own_path(entry.next.as_deref());
    let Some(tokens) = &access.inner.tokens else { return Redirect::to(&next).into_response() };
    let now_s = unix_s();
    let secret = entry.token.trim();
    let token = tokens.of_secret(secret, now_s).filter(|_| secret.len() <= MAX_TOKEN);
    let record = |who, role, status: StatusCode, result| Record {
        event: "login",
        who,
        role,
        peer: &peer,
        method: "POST",
        path: "/login",
        status: status.as_u16(),
        result,
    };
    let Some((token, session)) = token.and_then(|token| {
        let session = access.inner.sessions.begin(&token, now_s)?;
        Some((token, session))
    }) else {
        access.inner.audit.refusal(&record(None, None, StatusCode::UNAUTHORIZED, "wrong token"));
        access.fine(&peer);
        let wrong = "This token is unknown, revoked or expired.";
        return page(language, StatusCode::UNAUTHORIZED, &next, Some(wrong));
    };
    access.end_session(&headers, now_s);
    let status = StatusCode::SEE_OTHER;
    access.inner.audit.request(&record(Some(&token.name), Some(token.role.word()), status, "ok"));
    let mut response = Redirect::to(&next).into_response();
    set_cookie(&mut response, &session, access.inner.sessions.lasts().as_secs(), access.scheme() == "https");
    response
}

async fn leave(
    State(access): State<Access>,
    identity: Option<Extension<Identity>>,
    headers: HeaderMap,
    request: Request,
) -> Response {
    let peer = request.extensions().get::<Peer>().cloned().unwrap_or_default();
    let identity =
        identity.map(|Extension(identity)| identity).filter(|identity| identity.by == Proof::Session);
    if let Some(identity) = &identity {
        access.end_session(&headers, unix_s());
        access.inner.audit.request(&Record {
            event: "logout",
            who: Some(&identity.name),
            role: Some(identity.role.word()),
            peer: &peer,
            method: "POST",
            path: "/logout",
            status: StatusCode::SEE_OTHER.as_u16(),
            result: "ok",
        });
    }
    let mut response = Redirect::to("/login").into_response();
    set_cookie(&mut response, "", 0, access.scheme() == "https");
    response
}

impl Access {
    /// Ends the session that somebody shows, if it is one.
    fn end_session(&self, headers: &HeaderMap, now_s: i64) {
        let (Some(tokens), Some(session)) = (&self.inner.tokens, session(headers, self.scheme() == "https"))
        else {
            return;
        };
        if self.inner.sessions.owner(&session, &tokens.all(), now_s).is_some() {
            self.inner.sessions.end(&session, now_s);
        }
    }
}

/// A path of this service, and nothing that a browser could take for another place.
fn own_path(next: Option<&str>) -> String {
    let own = next.filter(|next| {
        next.starts_with('/')
            && !next.starts_with("//")
            && !next.starts_with("/login")
            && next.bytes().all(|byte| byte.is_ascii_graphic() && byte != b'\\')
    });
    own.unwrap_or("/").to_owned()
}

fn page(language: Language, status: StatusCode, next: &str, wrong: Option<&'static str>) -> Response {
    let page = speak(language, || {
        html! {
            (DOCTYPE)
            html lang=(spoken().tag()) {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    title { "railgrip – " (t("log in")) }
                    link rel="stylesheet" href="/login.css";
                    link rel="icon" href="data:,";
                }
                body {
                    main {
                        h1 { "railgrip" }
                        form method="post" action="/login" {
                            @if let Some(wrong) = wrong { p role="alert" #wrong { (t(wrong)) } }
                            label for="token" { (t("Token")) }
                            input #token name="token" type="password" required autocomplete="current-password" autofocus
                                spellcheck="false" aria-describedby=[wrong.map(|_| "wrong")];
                            input type="hidden" name="next" value=(next);
                            button type="submit" { (t("Log in")) }
                        }
                        p.small { (t("A token comes from whoever operates this train:")) " " code { "railgrip token add" } }
                    }
                }
            }
        }
    });
    let kind = [(header::CONTENT_TYPE, HeaderValue::from_static("text/html; charset=utf-8"))];
    (status, kind, page.into_string()).into_response()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_login_leads_nowhere_else() {
        for (next, path) in [
            (Some("/"), "/"),
            (Some("/wagons/3?range=30d"), "/wagons/3?range=30d"),
            (None, "/"),
            (Some("//evil.example/"), "/"),
            (Some("/\\evil.example"), "/"),
            (Some("https://evil.example"), "/"),
            (Some("/\t/evil.example"), "/"),
            (Some("/login?next=/"), "/"),
        ] {
            assert_eq!(own_path(next), path, "{next:?}");
        }
    }
}
