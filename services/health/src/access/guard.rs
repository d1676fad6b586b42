//! What every request passes before a handler sees it, and every answer before it leaves.

use crate::access::audit::Record;
use crate::access::body::{self, Unread, Watched};
use crate::access::control::{Access, Stranger};
use crate::access::peer::Peer;
use crate::access::refusal::Refusal;
use crate::access::role::{self, Identity, Proof};
use crate::access::{cors, headers, login, origin};
use crate::api::problem::Problem;
use axum::Router;
use axum::body::Body;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use axum::middleware::{Next, from_fn_with_state};
use axum::response::{IntoResponse, Response};

/// Puts access control around a router, and the routes of logging in and out beside it.
pub fn guard(router: Router, access: &Access) -> Router {
    router.merge(login::routes(access)).layer(from_fn_with_state(access.clone(), pass))
}

async fn pass(State(access): State<Access>, request: Request, next: Next) -> Response {
    let mut request = request;
    let peer = request.extensions().get::<Peer>().cloned().unwrap_or_default();
    let peer = access.seen_through(peer, request.headers());
    request.extensions_mut().insert(peer.clone());
    let (method, path) = (request.method().clone(), request.uri().path().to_owned());
    let asks_first = cors::is_question(&method, request.headers());
    let cors_origins = &access.inner.cors_origins;
    let from = if cors_origins.is_empty() { None } else { cors::allowed(request.headers(), cors_origins) };
    let mut response = match access.examine(&peer, request).await {
        Ok(_) if asks_first && from.is_some() => cors::answer(),
        Ok((request, identity)) => access.answer(&peer, identity, request, next).await,
        Err(refused) => {
            let response = refused.refusal.response();
            let who = refused.identity.as_ref();
            let record = access.record(&peer, who, &method, &path, &response, refused.refusal.word());
            // A browser that is shown the way to the login has been refused nothing yet.
            if !response.status().is_redirection() {
                access.inner.audit.refusal(&record);
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

impl Access {
    /// All questions to a request.
    async fn examine(&self, peer: &Peer, request: Request) -> Result<(Request, Option<Identity>), Refused> {
        let no = |refusal| Refused { refusal, identity: None };
        self.charge(peer, 1.0).map_err(no)?;
        let (mut parts, body) = request.into_parts();
        let inner = &self.inner;
        if peer.address.is_some() && !origin::names_one_host(parts.version, &parts.headers) {
            return Err(no(Refusal::HostsDiffer));
        }
        if inner.tokens.is_none()
            && peer.address.is_some()
            && !origin::host_is_known(&parts.uri, &parts.headers, &inner.settings.hosts)
        {
            return Err(no(Refusal::StrangeHost));
        }
        let needs = role::needed(&parts.method, parts.uri.path(), &parts.headers);
        let identity = match (self.identify(peer, &parts.headers), needs) {
            (Ok(identity), _) => Some(identity),
            (Err(stranger), None) => {
                // What asks for no token must not tell cheaply whether one is right either.
                if matches!(stranger, Stranger::Wrong) {
                    self.fine(peer);
                }
                None
            }
            (Err(Stranger::Silent), Some(_)) => return Err(no(Refusal::NoToken { page: page(&parts) })),
            (Err(Stranger::Wrong), Some(_)) => {
                self.fine(peer);
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
        if !role::is_safe(&parts.method)
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
        if !own_record && (!role::is_safe(&method) || path == "/api/v1/audit") {
            let event = if role::is_safe(&method) { "read" } else { "change" };
            let record =
                Record { event, ..self.record(peer, identity.as_ref(), &method, &path, &response, "") };
            // Whoever shows nothing could write the log full, and with it what others did out of it.
            match identity.as_ref().is_some_and(|identity| identity.by != Proof::None) {
                true => self.inner.audit.request(&record),
                false => self.inner.audit.refusal(&record),
            }
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
        let (access, peer) = (self.clone(), peer.clone());
        let may_go_on = Box::new({
            let access = access.clone();
            move || access.identify(&peer, &credentials).is_ok()
        });
        let generation = move || access.inner.tokens.as_ref().map_or(0, super::tokens::TokenBook::generation);
        response.map(|body| Body::new(Watched::new(body, generation, may_go_on)))
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
