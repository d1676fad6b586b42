//! Requests about single alerts: look, acknowledge, shelve, take back.

use super::Refusal;
use super::model::{AcknowledgeRequest, Alert, AlertList, ShelveRequest};
use crate::problem::Problem;
use crate::shared::Shared;
use crate::store::Snapshot;
use axum::Json;
use axum::body::Bytes;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use serde::de::DeserializeOwned;
use std::sync::Arc;

impl From<Refusal> for Problem {
    fn from(refusal: Refusal) -> Self {
        let status = match refusal {
            Refusal::Unknown(_) => StatusCode::NOT_FOUND,
            Refusal::Over(_) | Refusal::NotShelved(_) => StatusCode::CONFLICT,
            Refusal::Invalid(_) => StatusCode::BAD_REQUEST,
        };
        Self::new(status, refusal.to_string())
    }
}

/// One alert with its whole history.
#[utoipa::path(get, path = "/api/v1/alerts/{id}", tag = "alerts",
    params(("id" = u64, Path, minimum = 1, description = "Number of the alert")),
    responses(
        (status = 200, body = Alert),
        (status = 404, description = "There is no such alert", body = Problem, content_type = "application/problem+json"),
    ))]
pub(crate) async fn alert(
    State(shared): State<Shared>,
    Path(id): Path<String>,
) -> Result<Json<Alert>, Problem> {
    let (book, id) = (shared.latest().book.clone(), number(&id)?);
    let alert = book.lock().get(id);
    alert.map(Json).ok_or_else(|| Refusal::Unknown(id).into())
}

/// Takes notice of an alert: it stays in the list, and asks for nobody's attention until it becomes worse.
#[utoipa::path(post, path = "/api/v1/alerts/{id}/acknowledge", tag = "alerts",
    params(("id" = u64, Path, minimum = 1, description = "Number of the alert")),
    request_body = AcknowledgeRequest,
    responses(
        (status = 200, body = Alert),
        (status = 400, description = "The request makes no sense", body = Problem,
            content_type = "application/problem+json"),
        (status = 404, description = "There is no such alert", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "It is over", body = Problem, content_type = "application/problem+json"),
    ))]
pub(crate) async fn acknowledge(
    State(shared): State<Shared>,
    Path(id): Path<String>,
    body: Bytes,
) -> Result<Json<Alert>, Problem> {
    let (id, request) = (number(&id)?, parse::<AcknowledgeRequest>(&body)?);
    let now = shared.now();
    change(&shared, move |snapshot| snapshot.book.lock().acknowledge(id, request, now)).await
}

/// Puts an alert aside for a time; it comes back when the time is over or when it becomes worse.
#[utoipa::path(post, path = "/api/v1/alerts/{id}/shelve", tag = "alerts",
    params(("id" = u64, Path, minimum = 1, description = "Number of the alert")),
    request_body = ShelveRequest,
    responses(
        (status = 200, body = Alert),
        (status = 400, description = "The request makes no sense", body = Problem,
            content_type = "application/problem+json"),
        (status = 404, description = "There is no such alert", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "It is over", body = Problem, content_type = "application/problem+json"),
    ))]
pub(crate) async fn shelve(
    State(shared): State<Shared>,
    Path(id): Path<String>,
    body: Bytes,
) -> Result<Json<Alert>, Problem> {
    let (id, request) = (number(&id)?, parse::<ShelveRequest>(&body)?);
    let now = shared.now();
    change(&shared, move |snapshot| snapshot.book.lock().shelve(id, request, now)).await
}

/// Takes an alert back that was put aside.
#[utoipa::path(post, path = "/api/v1/alerts/{id}/unshelve", tag = "alerts",
    params(("id" = u64, Path, minimum = 1, description = "Number of the alert")),
    request_body = AcknowledgeRequest,
    responses(
        (status = 200, body = Alert),
        (status = 400, description = "The request makes no sense", body = Problem,
            content_type = "application/problem+json"),
        (status = 404, description = "There is no such alert", body = Problem, content_type = "application/problem+json"),
        (status = 409, description = "It is over or not shelved", body = Problem,
            content_type = "application/problem+json"),
    ))]
pub(crate) async fn unshelve(
    State(shared): State<Shared>,
    Path(id): Path<String>,
    body: Bytes,
) -> Result<Json<Alert>, Problem> {
    let (id, request) = (number(&id)?, parse::<AcknowledgeRequest>(&body)?);
    let now = shared.now();
    change(&shared, move |snapshot| snapshot.book.lock().unshelve(id, request, now)).await
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
    let latest = shared.latest();
    let book = latest.book.lock();
    let renewed = Snapshot {
        alerts: AlertList { alerts: book.list() },
        alert_version: book.version(),
        ..Snapshot::clone(&latest)
    };
    shared.replace(Arc::new(renewed));
}

fn number(id: &str) -> Result<u64, Problem> {
    let detail = || format!("there is no alert \"{id}\"; see /api/v1/alerts");
    id.parse().map_err(|_| Problem::new(StatusCode::NOT_FOUND, detail()))
}

fn parse<T: DeserializeOwned>(body: &[u8]) -> Result<T, Problem> {
    serde_json::from_slice(body).map_err(|error| {
        Problem::new(StatusCode::BAD_REQUEST, format!("the body is not the JSON that is expected: {error}"))
    })
}
