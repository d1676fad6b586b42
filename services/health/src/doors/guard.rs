//! What every request passes before a handler sees it, and every answer before it leaves.

use crate::doors::access::{self, Identity, Proof, Role};
use crate::doors::audit::Record;
use crate::doors::body::{self, Unread, Watched};
use crate::doors::limit::Client;
use crate::doors::{Doors, Peer, cors, headers, login, origin, unix_s};
use crate::problem::Problem;
use axum::Router;
use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Redirect, Response};
use std::time::{Duration, Instant};

/// What a wrong token costs of a client's bucket, in requests.
const WRONG_TOKEN_COST: f64 = 10.0;

/// Why a request was turned away.
pub(super) enum Refusal {
    TooMany(Duration),
    StrangeHost,
    NoToken { page: Option<String> },
    WrongToken { page: Option<String> },
    RoleTooLow { has: Role, needs: Role },
    NotMeant,
    TooLarge(usize),
    TooSlow(Duration),
    Broken,
}

/// Puts the doors around a router, and the routes of logging in and out beside it.
pub fn guard(router: Router, doors: &Doors) -> Router {
    router.merge(login::routes(doors)).layer(from_fn_with_state(doors.clone(), pass))
}

async fn pass(State(doors): State<Doors>, request: Request, next: Next) -> Response {
    let peer = request.extensions().get::<Peer>().cloned().unwrap_or_default();
    let (method, path) = (request.method().clone(), request.uri().path().to_owned());
    let asks_first = cors::is_question(&method, request.headers());
    let cors_origins = &doors.inner.cors_origins;
    let from = if cors_origins.is_empty() { None } else { cors::allowed(request.headers(), cors_origins) };
    let mut response = match doors.examine(&peer, request).await {
        Ok(_) if asks_first && from.is_some() => cors::answer(),
        Ok((request, identity)) => doors.answer(&peer, identity, request, next).await,
        Err(refused) => {
            let response = refused.refusal.response();
            let who = refused.identity.as_ref();
            let record = doors.record(&peer, who, &method, &path, &response, refused.refusal.word());
            // A browser that is shown the way to the login has been refused nothing yet.
            if !response.status().is_redirection() {
                doors.inner.audit.refusal(&record);
            }
            response
        }
    };
    cors::mark(response.headers_mut(), from, cors_origins);
    headers::secure(response.headers_mut(), peer.tls);
    response
}

struct Refused {
    refusal: Refusal,
    identity: Option<Identity>,
}

impl Doors {
    /// All questions to a request.
    async fn examine(&self, peer: &Peer, request: Request) -> Result<(Request, Option<Identity>), Refused> {
        let no = |refusal| Refused { refusal, identity: None };
        self.charge(peer, 1.0).map_err(no)?;
        let (mut parts, body) = request.into_parts();
        let inner = &self.inner;
        if inner.tokens.is_none()
            && peer.address.is_some()
            && !origin::host_is_known(&parts.uri, &parts.headers, &inner.settings.hosts)
        {
            return Err(no(Refusal::StrangeHost));
        }
        let needs = access::needed(&parts.method, parts.uri.path(), &parts.headers);
        let identity = match (self.identify(peer, &parts.headers), needs) {
            (Ok(identity), _) => Some(identity),
            (Err(_), None) => None,
            (Err(Stranger::Silent), Some(_)) => return Err(no(Refusal::NoToken { page: page(&parts) })),
            (Err(Stranger::Wrong), Some(_)) => {
                // The answer is a refusal whether or not the bucket held so much.
                let _ = self.charge(peer, WRONG_TOKEN_COST);
                return Err(no(Refusal::WrongToken { page: page(&parts) }));
            }
        };
        let no = |refusal| Refused { refusal, identity: identity.clone() };
        if let (Some(identity), Some(needs)) = (&identity, needs)
            && identity.role < needs
        {
            return Err(no(Refusal::RoleTooLow { has: identity.role, needs }));
        }
        let proof = identity.as_ref().map_or(Proof::None, |identity| identity.by);
        if !access::is_safe(&parts.method)
            && !origin::is_meant(&parts.uri, &parts.headers, proof, self.scheme(), &inner.cors_origins)
        {
            return Err(no(Refusal::NotMeant));
        }
        let limits = &inner.settings.limits;
        let body = body::read(&parts.headers, body, limits.body_bytes, limits.body).await;
        let body = body.map_err(|unread| {
            no(match unread {
                Unread::TooLarge => Refusal::TooLarge(limits.body_bytes),
                Unread::TooSlow => Refusal::TooSlow(limits.body),
                Unread::Broken => Refusal::Broken,
            })
        })?;
        if let Some(identity) = &identity {
            parts.extensions.insert(identity.clone());
        }
        Ok((Request::from_parts(parts, body), identity))
    }

    /// Has a request answered, and writes down what changed something.
    async fn answer(
        &self,
        peer: &Peer,
        identity: Option<Identity>,
        request: Request,
        next: Next,
    ) -> Response {
        let (method, path) = (request.method().clone(), request.uri().path().to_owned());
        let credentials = credentials(request.headers());
        let patience = self.inner.settings.limits.answer;
        let response = match tokio::time::timeout(patience, next.run(request)).await {
            Ok(response) => response,
            Err(_) => Problem::new(
                StatusCode::SERVICE_UNAVAILABLE,
                format!("there was no answer within {:.0} s", patience.as_secs_f64()),
            )
            .into_response(),
        };
        let own_record = matches!(path.as_str(), "/login" | "/logout");
        if !own_record && (!access::is_safe(&method) || path == "/api/v1/audit") {
            let event = if access::is_safe(&method) { "read" } else { "change" };
            self.inner.audit.request(&Record {
                event,
                ..self.record(peer, identity.as_ref(), &method, &path, &response, "")
            });
        }
        match identity {
            None if path.starts_with("/health/") => without_reasons(response),
            Some(identity) if matches!(identity.by, Proof::Token | Proof::Session) => {
                self.watch(peer, response, credentials)
            }
            _ => response,
        }
    }

    /// A stream ends with the token that it was opened with.
    fn watch(&self, peer: &Peer, response: Response, credentials: HeaderMap) -> Response {
        let kind = response.headers().get(header::CONTENT_TYPE);
        if !kind.is_some_and(|kind| kind.as_bytes().starts_with(b"text/event-stream")) {
            return response;
        }
        let (doors, peer) = (self.clone(), peer.clone());
        let may_go_on = Box::new({
            let doors = doors.clone();
            move || doors.identify(&peer, &credentials).is_ok()
        });
        let generation = move || doors.inner.tokens.as_ref().map_or(0, super::tokens::TokenBook::generation);
        response.map(|body| Body::new(Watched::new(body, generation, may_go_on)))
    }

    /// Takes from the bucket of a client.
    pub(super) fn charge(&self, peer: &Peer, cost: f64) -> Result<(), Refusal> {
        match peer.address {
            Some(address) if self.limited(peer) => {
                let client = Client::of(address.ip());
                self.inner.limiter.take(client, cost, Instant::now()).map_err(Refusal::TooMany)
            }
            _ => Ok(()),
        }
    }

    /// Who asks.
    pub(super) fn identify(&self, peer: &Peer, headers: &HeaderMap) -> Result<Identity, Stranger> {
        if peer.address.is_none() {
            return Ok(Identity { name: "local".into(), role: Role::Admin, by: Proof::Local });
        }
        let Some(tokens) = &self.inner.tokens else {
            return Ok(Identity { name: "anyone".into(), role: Role::Admin, by: Proof::None });
        };
        let now_s = unix_s();
        if let Some(value) = headers.get(header::AUTHORIZATION) {
            let text = value.to_str().map_err(|_| Stranger::Wrong)?;
            let (kind, secret) = text.split_once(' ').ok_or(Stranger::Wrong)?;
            let found =
                tokens.of_secret(secret.trim(), now_s).filter(|_| kind.eq_ignore_ascii_case("bearer"));
            let token = found.ok_or(Stranger::Wrong)?;
            return Ok(Identity { name: token.name.into(), role: token.role, by: Proof::Token });
        }
        let session = login::session(headers, self.scheme() == "https").ok_or(Stranger::Silent)?;
        let owner = self.inner.sessions.owner(&session, &tokens.all(), now_s).ok_or(Stranger::Silent)?;
        Ok(Identity { name: owner.name.into(), role: owner.role, by: Proof::Session })
    }

    fn record<'a>(
        &self,
        peer: &'a Peer,
        identity: Option<&'a Identity>,
        method: &'a Method,
        path: &'a str,
        response: &Response,
        result: &'a str,
    ) -> Record<'a> {
        Record {
            event: "refused",
            who: identity.map(|identity| &*identity.name),
            role: identity.map(|identity| identity.role.word()),
            peer,
            method: method.as_str(),
            path,
            status: response.status().as_u16(),
            result,
        }
    }
}

/// Somebody whom we do not know.
pub(super) enum Stranger {
    /// Shows nothing, or a session that is over.
    Silent,
    /// Shows a token that is none.
    Wrong,
}

/// What somebody showed, to be looked at again later.
fn credentials(headers: &HeaderMap) -> HeaderMap {
    let shown = [header::AUTHORIZATION, header::COOKIE];
    shown.into_iter().filter_map(|name| headers.get(&name).map(|value| (name, value.clone()))).collect()
}

/// The page that a browser wants to see, if it is one that asks.
fn page(parts: &axum::http::request::Parts) -> Option<String> {
    let wants_page = parts.method == Method::GET
        && parts
            .headers
            .get(header::ACCEPT)
            .is_some_and(|accept| accept.to_str().is_ok_and(|accept| accept.contains("text/html")));
    wants_page.then(|| parts.uri.path_and_query().map_or("/", |target| target.as_str()).to_owned())
}

/// The bare status of a health check: its reasons name wagons, which is for those who may read.
fn without_reasons(response: Response) -> Response {
    let ok = response.status().is_success();
    let text =
        if ok { "{\"status\":\"ok\",\"reasons\":[]}" } else { "{\"status\":\"not ok\",\"reasons\":[]}" };
    let kind = [(header::CONTENT_TYPE, HeaderValue::from_static("application/json"))];
    (response.status(), kind, text).into_response()
}

impl Refusal {
    /// For the audit log.
    fn word(&self) -> &'static str {
        match self {
            Self::TooMany(_) => "too many requests",
            Self::StrangeHost => "strange host",
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
                return Redirect::to(&format!("/login?next={}", login::encoded(page))).into_response();
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
