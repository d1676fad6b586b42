//! Requests about alerts: look, acknowledge, take that back, silence, end a silence.

use super::diagnosis;
use super::model::{AcknowledgeRequest, Alert, AlertList, AlertState, SilenceRequest};
use super::operator::Refusal;
use crate::access::Identity;
use crate::api::grade::Grade;
use crate::api::problem::Problem;
use crate::history::routes::wagon;
use crate::shared::Shared;
use crate::store::Snapshot;
use crate::web::pages::{MOST, Page, link};
use crate::web::query::{parameters, refuse, value};
use axum::body::Bytes;
use axum::extract::{Path, RawQuery, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::{Extension, Json};
use serde::de::DeserializeOwned;
use std::sync::Arc;

impl From<Refusal> for Problem {
    fn from(refusal: Refusal) -> Self {
        let status = match refusal {
            Refusal::Unknown(_) => StatusCode::NOT_FOUND,
            Refusal::Over(_) | Refusal::NotSilenced(_) | Refusal::NotAcknowledged(_) => StatusCode::CONFLICT,
            Refusal::Invalid(_) => StatusCode::UNPROCESSABLE_ENTITY,
        };
        Self::new(status, refusal.to_string())
    }
}

/// Alerts: active ones first, then the latest that are over.
#[utoipa::path(get, path = "/api/v1/alerts", tag = "alerts",
    params(
        ("state" = Option<AlertState>, Query, description = "Only in this state"),
        ("grade" = Option<Grade>, Query, description = "Only of this grade now"),
        ("wagon" = Option<u32>, Query, minimum = 1, description = "Only of this wagon"),
        ("limit" = Option<u32>, Query, minimum = 1, maximum = 1000, description = "At most so many; default 1000"),
        ("after" = Option<i64>, Query, minimum = 0, description = "Only behind the alert with this number"),
    ),
    responses(
        (status = 200, description = "The alerts", body = AlertList, headers(("Link" = String, description = "The next page, rel=\"next\""))),
        (status = 400, description = "A query parameter is wrong; the detail names it and what is allowed"),
        (status = 404, description = "There is no such wagon"),
    ))]
pub(crate) async fn alerts(
    State(shared): State<Shared>,
    RawQuery(query): RawQuery,
) -> Result<Response, Problem> {
    let pairs = parameters(query.as_deref(), &["state", "grade", "wagon", "limit", "after"])?;
    let page = Page::of(&pairs, MOST)?;
    let one_of = |name: &str, words: &[&str]| match value(&pairs, name) {
        Some(text) if !words.contains(&text) => Err(refuse(name, text, &words.join(", "))),
        text => Ok(text.map(str::to_owned)),
    };
    let state = one_of("state", &["active", "acknowledged", "silenced", "cleared", "shelved"])?
        .map(|state| if state == "shelved" { "silenced".to_owned() } else { state });
    let grade = one_of("grade", &["unknown", "ok", "watch", "act"])?;
    let wagon = value(&pairs, "wagon").map(|text| wagon(&shared, text)).transpose()?;
    let wanted = |alert: &&Alert| {
        state.as_deref().is_none_or(|state| alert.state.word() == state)
            && grade.as_deref().is_none_or(|grade| alert.grade_now.word() == grade)
            && wagon.is_none_or(|wagon| alert.wagons.contains(&wagon))
    };
    let snapshot = shared.latest();
    let mut all = snapshot.alerts.alerts.iter().filter(wanted).peekable();
    if let Some(after) = page.after {
        // Behind it in the order of the list; an alert that is gone meanwhile has nothing behind it.
        let _ = all.by_ref().find(|alert| alert.id == after);
    }
    let alerts: Vec<Alert> = all.by_ref().take(page.limit).cloned().collect();
    let last = alerts.last().filter(|_| all.peek().is_some());
    let next = last.map(|last| page.next("/api/v1/alerts", &pairs, last.id));
    let response = Json(AlertList { alerts, next: next.clone() }).into_response();
    Ok(link(response, next.as_deref()))
}

/// One alert with its whole history.
#[utoipa::path(get, path = "/api/v1/alerts/{id}", tag = "alerts",
    params(("id" = u64, Path, minimum = 1, description = "Number of the alert")),
    responses(
        (status = 200, description = "The alert now", body = Alert),
        (status = 404, description = "There is no such alert"),
    ))]
pub(crate) async fn alert(
    State(shared): State<Shared>,
    Path(id): Path<String>,
) -> Result<Json<Alert>, Problem> {
    let (book, id) = (shared.latest().book.clone(), number(&id)?);
    let alert = book.lock().get(id);
    alert.map(Json).ok_or_else(|| Refusal::Unknown(id).into())
}

/// The report of the diagnosis of an alert's recording, as a page of its own.
#[utoipa::path(get, path = "/api/v1/alerts/{id}/report", tag = "alerts",
    params(("id" = u64, Path, minimum = 1, description = "Number of the alert")),
    responses(
        (status = 200, description = "The report, a page for people", body = String, content_type = "text/html"),
        (status = 404, description = "There is no such alert, or no report of it (yet)"),
    ))]
pub(crate) async fn report(
    State(shared): State<Shared>,
    Path(id): Path<String>,
) -> Result<Response, Problem> {
    let (book, id) = (shared.latest().book.clone(), number(&id)?);
    let alert = book.lock().get(id).ok_or(Refusal::Unknown(id))?;
    let recording = alert.evidence.diagnosis.filter(|it| it.has_page).map(|it| it.recording);
    let missing = || Problem::new(StatusCode::NOT_FOUND, format!("alert {id} has no report of a diagnosis"));
    let recording = recording.ok_or_else(missing)?;
    let read = tokio::task::spawn_blocking(move || diagnosis::page(std::path::Path::new(&recording))).await;
    let page = read.ok().flatten().ok_or_else(missing)?;
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static("text/html; charset=utf-8")),
        (header::CONTENT_SECURITY_POLICY, OWN_STYLE),
    ];
    Ok((headers, page).into_response())
}

/// A report carries its style in itself, and needs nothing else.
const OWN_STYLE: HeaderValue = HeaderValue::from_static(
    "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; frame-ancestors 'none'",
);

/// What comes of a change.
#[derive(utoipa::IntoResponses)]
#[allow(dead_code, clippy::large_enum_variant, reason = "describes answers and is never made")]
enum Changed {
    /// The alert now
    #[response(status = 200)]
    Done(Alert),
    /// The body is no JSON
    #[response(status = 400)]
    NoJson,
    /// There is no such alert
    #[response(status = 404)]
    Unknown,
    /// It is over, or not silenced or acknowledged, where that is to be taken back
    #[response(status = 409)]
    Over,
    /// The body is too large
    #[response(status = 413)]
    TooLarge,
    /// The body is not application/json
    #[response(status = 415)]
    OtherKind,
    /// The body lacks something, or a value in it is not allowed
    #[response(status = 422)]
    NotAllowed,
}

/// Takes notice of an alert: it stays in the list, and asks for nobody's attention until it becomes worse.
#[utoipa::path(post, path = "/api/v1/alerts/{id}/acknowledge", tag = "alerts",
    params(("id" = u64, Path, minimum = 1, description = "Number of the alert")),
    request_body = AcknowledgeRequest,
    responses(Changed))]
pub(crate) async fn acknowledge(
    State(shared): State<Shared>,
    Path(id): Path<String>,
    identity: Option<Extension<Identity>>,
    body: Bytes,
) -> Result<Json<Alert>, Problem> {
    let (id, request) = (number(&id)?, signed::<AcknowledgeRequest>(&body, identity.as_deref())?);
    let now = shared.now();
    change(&shared, move |snapshot| snapshot.book.lock().acknowledge(id, request, now)).await
}

/// Takes an acknowledgement back: the alert asks for attention again.
#[utoipa::path(post, path = "/api/v1/alerts/{id}/unacknowledge", tag = "alerts",
    params(("id" = u64, Path, minimum = 1, description = "Number of the alert")),
    request_body = AcknowledgeRequest,
    responses(Changed))]
pub(crate) async fn unacknowledge(
    State(shared): State<Shared>,
    Path(id): Path<String>,
    identity: Option<Extension<Identity>>,
    body: Bytes,
) -> Result<Json<Alert>, Problem> {
    let (id, request) = (number(&id)?, signed::<AcknowledgeRequest>(&body, identity.as_deref())?);
    let now = shared.now();
    change(&shared, move |snapshot| snapshot.book.lock().unacknowledge(id, request, now)).await
}

/// Silences an alert for a time; it comes back when the time is over or when it becomes worse.
#[utoipa::path(post, path = "/api/v1/alerts/{id}/silence", tag = "alerts",
    params(("id" = u64, Path, minimum = 1, description = "Number of the alert")),
    request_body = SilenceRequest,
    responses(Changed))]
pub(crate) async fn silence(
    State(shared): State<Shared>,
    Path(id): Path<String>,
    identity: Option<Extension<Identity>>,
    body: Bytes,
) -> Result<Json<Alert>, Problem> {
    let (id, request) = (number(&id)?, signed::<SilenceRequest>(&body, identity.as_deref())?);
    let now = shared.now();
    change(&shared, move |snapshot| snapshot.book.lock().silence(id, request, now)).await
}

/// Ends the silence of an alert before its time is over.
#[utoipa::path(post, path = "/api/v1/alerts/{id}/unsilence", tag = "alerts",
    params(("id" = u64, Path, minimum = 1, description = "Number of the alert")),
    request_body = AcknowledgeRequest,
    responses(Changed))]
pub(crate) async fn unsilence(
    State(shared): State<Shared>,
    Path(id): Path<String>,
    identity: Option<Extension<Identity>>,
    body: Bytes,
) -> Result<Json<Alert>, Problem> {
    let (id, request) = (number(&id)?, signed::<AcknowledgeRequest>(&body, identity.as_deref())?);
    let now = shared.now();
    change(&shared, move |snapshot| snapshot.book.lock().unsilence(id, request, now)).await
}

/// The old path of `/api/v1/alerts/{id}/silence`.
#[utoipa::path(post, path = "/api/v1/alerts/{id}/shelve", tag = "alerts",
    params(("id" = u64, Path, minimum = 1, description = "Number of the alert")),
    request_body = SilenceRequest,
    responses(Changed))]
pub(crate) async fn shelve(
    shared: State<Shared>,
    id: Path<String>,
    identity: Option<Extension<Identity>>,
    body: Bytes,
) -> Result<Json<Alert>, Problem> {
    silence(shared, id, identity, body).await
}

/// The old path of `/api/v1/alerts/{id}/unsilence`.
#[utoipa::path(post, path = "/api/v1/alerts/{id}/unshelve", tag = "alerts",
    params(("id" = u64, Path, minimum = 1, description = "Number of the alert")),
    request_body = AcknowledgeRequest,
    responses(Changed))]
pub(crate) async fn unshelve(
    shared: State<Shared>,
    id: Path<String>,
    identity: Option<Extension<Identity>>,
    body: Bytes,
) -> Result<Json<Alert>, Problem> {
    unsilence(shared, id, identity, body).await
}

/// Makes a change where waiting for the disk is allowed, then shows it to whoever asks next.
async fn change(
    shared: &Shared,
    make: impl FnOnce(&Snapshot) -> Result<Alert, Refusal> + Send + 'static,
) -> Result<Json<Alert>, Problem> {
    let snapshot = shared.latest();
    let made = tokio::task::spawn_blocking(move || make(&snapshot)).await;
    let alert = made.map_err(|_| {
        Problem::new(StatusCode::INTERNAL_SERVER_ERROR, "the change failed; see the log of the service")
    })??;
    show(shared);
    Ok(Json(alert))
}

/// Renews the alerts of the latest snapshot.
pub(crate) fn show(shared: &Shared) {
    shared.replace(Arc::new(shared.latest().with_present_alerts()));
}

fn number(id: &str) -> Result<u64, Problem> {
    let detail = || format!("there is no alert \"{id}\"; see /api/v1/alerts");
    id.parse().map_err(|_| Problem::new(StatusCode::NOT_FOUND, detail()))
}

/// The body as a request. Whoever shows a token is called as it is first, so that nobody acts in another's name.
fn signed<T: DeserializeOwned>(body: &[u8], identity: Option<&Identity>) -> Result<T, Problem> {
    let wrong = |error: serde_json::Error| {
        let status = if error.is_data() { StatusCode::UNPROCESSABLE_ENTITY } else { StatusCode::BAD_REQUEST };
        Problem::new(status, format!("the body is not the JSON that is expected: {error}"))
    };
    let mut body: serde_json::Value = serde_json::from_slice(body).map_err(wrong)?;
    if let (Some(fields), Some(identity)) = (body.as_object_mut(), identity) {
        let said = fields.get("by").and_then(serde_json::Value::as_str);
        if let Some(by) = identity.signature(said) {
            fields.insert("by".to_owned(), by.into());
        }
    }
    serde_json::from_value(body).map_err(wrong)
}
