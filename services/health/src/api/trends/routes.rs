//! Where the indicators of a wagon are going: their slope over the stored past, and the time until they need action.

use crate::api::problem::Problem;
use crate::api::trends::model::{DAY_S, TrendList, TrendView, view};
use crate::history::History;
use crate::history::routes::wagon;
use crate::limits::Limits;
use crate::shared::Shared;
use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use railgrip_history::{HistoryError, Point};
use railgrip_indicators::trend::Trend;
use std::sync::Arc;

/// Fewer points than this are too few to rely on a coarse tier: a finer one is asked.
const ENOUGH_POINTS: usize = 24;

/// Spans with their steps, s: the longest that holds enough points is taken.
const SPANS: [(i64, i64); 2] = [(30 * DAY_S, 3600), (2 * DAY_S, 60)];

/// A shorter past shows no trend, s: the figures themselves are means over minutes of braking.
const LEAST_SPAN_S: f64 = 3600.0;

/// Indicators of a wagon that have a trend.
const OF_WAGON: [&str; 8] = [
    "brake_friction",
    "brake_friction_standard",
    "asymmetry",
    "response",
    "dragging",
    "wsp_share",
    "sensors",
    "filter",
];

/// Indicators of a wheelset that have one.
const OF_WHEELSET: [&str; 2] = ["brake_friction", "brake_friction_standard"];

/// Where the indicators of a wagon are going: the slope over the stored hours of 30 days (over minutes while there
/// are few of them), with its 95 % interval, and the time until they need action.
#[utoipa::path(get, path = "/api/v1/wagons/{id}/trends", tag = "history",
    params(("id" = u32, Path, minimum = 1, description = "Number of the wagon, 1 first")),
    responses(
        (status = 200, description = "One trend an indicator", body = TrendList),
        (status = 404, description = "There is no such wagon, or no history"),
        (status = 503, description = "The database refuses"),
    ))]
pub(crate) async fn trends(
    State(shared): State<Shared>,
    Path(id): Path<String>,
) -> Result<Json<TrendList>, Problem> {
    let wagon = wagon(&shared, &id)?;
    Ok(Json(TrendList { wagon, trends: of(&shared, wagon).await? }))
}

/// The trends of a wagon that there is.
pub(crate) async fn of(shared: &Shared, wagon: u32) -> Result<Vec<TrendView>, Problem> {
    let nothing =
        || Problem::new(StatusCode::NOT_FOUND, "this train keeps no history: [history] enabled is false");
    let refused = |detail: String| Problem::new(StatusCode::SERVICE_UNAVAILABLE, detail);
    let history = shared.history().cloned().ok_or_else(nothing)?;
    let turn =
        Arc::clone(&history.turns).acquire_owned().await.map_err(|error| refused(error.to_string()))?;
    let (limits, now_s) = (shared.limits().clone(), shared.now().unix_ns.div_euclid(1_000_000_000));
    let read = tokio::task::spawn_blocking(move || {
        let trends = of_wagon(&history, wagon, &limits, now_s);
        drop(turn);
        trends
    });
    let trends = read.await.map_err(|error| refused(error.to_string()))?;
    trends.map_err(|error| refused(error.to_string()))
}

fn of_wagon(
    history: &History,
    wagon: u32,
    limits: &Limits,
    now_s: i64,
) -> Result<Vec<TrendView>, HistoryError> {
    let wanted = |name: &str| match name.strip_prefix("wheelset_").and_then(|rest| rest.split_once('.')) {
        Some((_, field)) => OF_WHEELSET.contains(&field),
        None => OF_WAGON.contains(&name),
    };
    let columns: Vec<(&str, &'static str)> = history
        .columns()
        .iter()
        .filter(|column| wanted(&column.name))
        .map(|column| (column.name.as_str(), column.unit))
        .collect();
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let mut points: Vec<Point> = Vec::new();
    for (span_s, step_s) in SPANS {
        let found = history.read(|reader| reader.query(wagon, &names, now_s - span_s, now_s + 1, step_s))?;
        if found.len() > points.len() {
            points = found;
        }
        if points.len() >= ENOUGH_POINTS {
            break;
        }
    }
    let view = |(place, (name, unit)): (usize, &(&str, &'static str))| {
        let at = |point: &Point| ((point.unix_s - now_s) as f64, f64::from(point.cells[place].mean));
        let series: Vec<(f64, f64)> = points.iter().map(at).collect();
        view(
            name,
            unit,
            limits.of_field(wagon, name).map(|limit| (limit.act_low, limit.act_high)),
            Trend::of(&series).filter(|trend| trend.span_s >= LEAST_SPAN_S),
        )
    };
    Ok(columns.iter().enumerate().map(view).collect())
}
