//! Where the indicators of a wagon are going: their slope over the stored past, and the time until they need action.

use crate::api::problem::Problem;
use crate::api::trends::model::{DAY_S, TrendList, TrendView, view};
use crate::history::History;
use crate::history::columns::Column;
use crate::history::routes::wagon;
use crate::limits::Limits;
use crate::shared::Shared;
use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use railgrip_history::{HistoryError, Point};
use railgrip_indicators::IndicatorSpec;
use railgrip_indicators::indicator::{BRAKE_FRICTION, BRAKE_FRICTION_STANDARD};
use railgrip_indicators::trend::Trend;
use std::sync::Arc;

/// Fewer points than this are too few to rely on a coarse tier: a finer one is asked.
const ENOUGH_POINTS: usize = 24;

/// Spans with their steps, s: the longest that holds enough points is taken.
const SPANS: [(i64, i64); 2] = [(30 * DAY_S, 3600), (2 * DAY_S, 60)];

/// A shorter past shows no trend, s: the figures themselves are means over minutes of braking.
const LEAST_SPAN_S: f64 = 3600.0;

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
    let vehicle_number = shared.history().and_then(|history| history.vehicle_number(wagon));
    Ok(Json(TrendList { wagon, vehicle_number, trends: of(&shared, wagon).await? }))
}

/// The trends of a wagon that there is.
pub(crate) async fn of(shared: &Shared, wagon: u32) -> Result<Vec<TrendView>, Problem> {
    let nothing =
        || Problem::new(StatusCode::NOT_FOUND, "this train keeps no history: [history] enabled is false");
    let refused = |detail: String| Problem::new(StatusCode::SERVICE_UNAVAILABLE, detail);
    let history = shared.history().cloned().ok_or_else(nothing)?;
    let turn =
        Arc::clone(&history.turns).acquire_owned().await.map_err(|error| refused(error.to_string()))?;
    let pads_changed_s = shared.notes().pads_changed_unix_s(&crate::notes::routes::whose(shared, wagon));
    let (limits, now_s) = (shared.limits(), shared.now().unix_ns.div_euclid(1_000_000_000));
    let read = tokio::task::spawn_blocking(move || {
        let trends = of_wagon(&history, wagon, &limits, now_s, pads_changed_s);
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
    pads_changed_s: Option<i64>,
) -> Result<Vec<TrendView>, HistoryError> {
    let columns: Vec<(&Column, &IndicatorSpec)> = history
        .columns()
        .iter()
        .filter_map(|column| {
            let spec = column.spec?;
            let has = if column.wheelset.is_some() { spec.trend.wheelsets() } else { spec.trend.wagon() };
            has.then_some((column, spec))
        })
        .collect();
    let names: Vec<&str> = columns.iter().map(|(column, _)| column.name.as_str()).collect();
    let mut points: Vec<Point> = Vec::new();
    for (span_s, step_s) in SPANS {
        let found = history.read(|reader| {
            let consist = history.consist(reader)?;
            let id = consist.id(wagon);
            let mut points = reader.query(id, &names, now_s - span_s, now_s + 1, step_s)?;
            points.retain(|point| point.unix_s >= consist.known_from(id));
            Ok(points)
        })?;
        if found.len() > points.len() {
            points = found;
        }
        if points.len() >= ENOUGH_POINTS {
            break;
        }
    }
    let view = |(place, (column, spec)): (usize, &(&Column, &IndicatorSpec))| {
        let at = |point: &Point| ((point.unix_s - now_s) as f64, f64::from(point.cells[place].mean));
        // What the old pads did says nothing of the new ones.
        let since_s = if is_of_pads(spec) { pads_changed_s } else { None };
        let points = points.iter().filter(|point| since_s.is_none_or(|since_s| point.unix_s >= since_s));
        let series: Vec<(f64, f64)> = points.map(at).collect();
        view(
            &column.name,
            column.unit,
            limits.limit(spec, wagon).map(|limit| (limit.act_low, limit.act_high)),
            Trend::of(&series).filter(|trend| trend.span_s >= LEAST_SPAN_S),
        )
    };
    Ok(columns.iter().enumerate().map(view).collect())
}

/// Whether an indicator is one of the brake pads.
fn is_of_pads(spec: &IndicatorSpec) -> bool {
    [BRAKE_FRICTION.id, BRAKE_FRICTION_STANDARD.id].contains(&spec.id)
}
