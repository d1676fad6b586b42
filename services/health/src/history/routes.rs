//! Requests for what is remembered.

use super::query::{self, Span};
use super::{History, HistoryStatus, HistoryView};
use crate::api::problem::Problem;
use crate::shared::Shared;
use crate::web::json::json;
use crate::web::query::{parameters, refuse, value};
use axum::Json;
use axum::body::Bytes;
use axum::extract::{Path, RawQuery, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use railgrip_history::HistoryError;
use serde::Serialize;
use std::sync::Arc;
use utoipa::ToSchema;

/// About so many bytes of an answer belong to a step, and to the figures of one indicator in it.
const STEP_BYTES: usize = 40;
const FIGURES_BYTES: usize = 45;

/// How the history is, and which indicators it holds.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct HistoryOverview {
    /// How it is.
    pub status: HistoryStatus,
    /// What it holds of each wagon.
    pub indicators: Vec<IndicatorView>,
}

/// One remembered figure.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct IndicatorView {
    /// Its name, as in `fields`.
    pub name: String,
    /// Its unit; empty for a ratio, a number or a code.
    pub unit: &'static str,
    /// Whether an interval is remembered with it.
    pub interval: bool,
}

/// How the history is, and which indicators it holds.
#[utoipa::path(get, path = "/api/v1/history", tag = "history", responses(
    (status = 200, description = "Its state and what it holds", body = HistoryOverview),
    (status = 404, description = "There is no history"),
))]
pub(crate) async fn overview(State(shared): State<Shared>) -> Result<Json<HistoryOverview>, Problem> {
    let history = available(&shared)?;
    let indicator = |column: &super::columns::Column| IndicatorView {
        name: column.name.clone(),
        unit: column.unit,
        interval: column.interval,
    };
    let indicators = history.columns().iter().map(indicator).collect();
    Ok(Json(HistoryOverview { status: history.status(), indicators }))
}

/// Stored indicators of a wagon.
///
/// Arrays on a regular grid of steps with the mean, the extremes and the interval of each indicator; `null` in gaps.
/// A step of 60 s and more is answered from the minute tier, one of 3600 s and more from the hour tier.
#[utoipa::path(get, path = "/api/v1/wagons/{id}/history", tag = "history",
    params(
        ("id" = u32, Path, minimum = 1, description = "Number of the wagon, 1 first"),
        ("from" = Option<String>, Query, pattern = "instant",
            description = "Begin: RFC 3339, Unix seconds, or an age such as `7d`; default: an hour before `to`"),
        ("to" = Option<String>, Query, pattern = "instant", 
            description = "End, exclusive: RFC 3339, Unix seconds, an age such as `7d`, or `now`, the default"),
        ("step" = Option<String>, Query, pattern = "step",
            description = "Width of a step: seconds, or a number with s, m, h or d; default: one that gives up to 500 steps"),
        ("fields" = Option<String>, Query, pattern = "fields", description = "Indicators, separated by commas; default: all"),
    ),
    responses(
        (status = 200, description = "The steps", body = HistoryView),
        (status = 400, description = "A query parameter is wrong; the detail names it and what is allowed"),
        (status = 404, description = "There is no such wagon, or no history"),
        (status = 409, description = "`from`, `to` and `step` contradict each other"),
        (status = 503, description = "The database refuses, or too many long answers wait for their readers"),
    ))]
pub(crate) async fn history(
    State(shared): State<Shared>,
    Path(id): Path<String>,
    RawQuery(query): RawQuery,
) -> Result<Response, Problem> {
    let wagon = wagon(&shared, &id)?;
    let history = available(&shared)?;
    let pairs = parameters(query.as_deref(), &["from", "to", "step", "fields"])?;
    let span = query::span(&pairs, shared.now().unix_ns.div_euclid(1_000_000_000))?;
    let fields = value(&pairs, "fields").map(|text| fields(&history, text)).transpose()?;
    let columns = fields.as_ref().map_or(history.columns().len(), Vec::len);
    let room = history.room.take(span.steps() * (STEP_BYTES + columns * FIGURES_BYTES)).await?;
    let body = read(history, move |history| view(history, wagon, span, fields.as_deref())).await?;
    let headers = [(header::CONTENT_TYPE, HeaderValue::from_static("application/json"))];
    let mut response = (headers, body).into_response();
    response.extensions_mut().insert(room);
    Ok(response)
}

fn view(history: &History, wagon: u32, span: Span, fields: Option<&[String]>) -> Result<Bytes, HistoryError> {
    history.view(wagon, span, fields).map(|view| json(&view))
}

/// The number of a wagon that there is.
pub(crate) fn wagon(shared: &Shared, id: &str) -> Result<u32, Problem> {
    let snapshot = shared.latest();
    let plain = id.bytes().all(|byte| byte.is_ascii_digit()) && !id.starts_with('0');
    let known = |id: &u32| plain && snapshot.wagons.iter().any(|wagon| wagon.id == *id);
    let number = id.parse().ok().filter(known);
    number.ok_or_else(|| {
        let detail = format!("there is no wagon \"{id}\"; allowed is 1 to {}", snapshot.wagons.len());
        Problem::new(StatusCode::NOT_FOUND, detail)
    })
}

pub(super) fn available(shared: &Shared) -> Result<Arc<History>, Problem> {
    shared.history().cloned().ok_or_else(|| {
        Problem::new(StatusCode::NOT_FOUND, "this train keeps no history: [history] enabled is false")
    })
}

fn fields(history: &History, text: &str) -> Result<Vec<String>, Problem> {
    let fields: Vec<String> = text.split(',').map(str::to_owned).collect();
    check_fields(history, &fields)?;
    Ok(fields)
}

/// Refuses names that no indicator has.
pub(super) fn check_fields(history: &History, fields: &[String]) -> Result<(), Problem> {
    let known = || history.columns().iter().map(|column| column.name.as_str());
    match fields.iter().find(|field| !known().any(|name| name == field.as_str())) {
        None => Ok(()),
        Some(unknown) => {
            let listed = known().collect::<Vec<_>>().join(", ");
            Err(refuse("fields", unknown, &format!("of these, separated by commas: {listed}")))
        }
    }
}

/// Reads on a thread that may block, when it is this request's turn.
pub(super) async fn read<T: Send + 'static>(
    history: Arc<History>,
    read: impl FnOnce(&History) -> Result<T, HistoryError> + Send + 'static,
) -> Result<T, Problem> {
    let refused = |detail: String| Problem::new(StatusCode::SERVICE_UNAVAILABLE, detail);
    let turn =
        Arc::clone(&history.turns).acquire_owned().await.map_err(|error| refused(error.to_string()))?;
    let reading = tokio::task::spawn_blocking(move || {
        let result = read(&history);
        drop(turn);
        result
    });
    match reading.await {
        Ok(Ok(answer)) => Ok(answer),
        Ok(Err(error)) => Err(refused(error.to_string())),
        Err(_) => Err(refused("reading the history failed".to_owned())),
    }
}
