//! Where the indicators of a wagon are going: their slope over the stored past, and the time until they need action.

use crate::history::History;
use crate::history::routes::wagon;
use crate::page::Limits;
use crate::problem::Problem;
use crate::shared::Shared;
use crate::view::rounded;
use axum::Json;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use railgrip_history::{HistoryError, Point};
use railgrip_indicators::trend::Trend;
use serde::Serialize;
use std::sync::Arc;
use utoipa::ToSchema;

const DAY_S: i64 = 86_400;
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

/// What the past of an indicator shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// It rises, with 97.5 % certainty.
    Rising,
    /// It falls, with 97.5 % certainty.
    Falling,
    /// Neither is certain.
    NoTrend,
    /// There are fewer than eight points, or less than an hour of them.
    TooLittleData,
}

/// Trend of one indicator.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct TrendView {
    /// The indicator, a field of the history.
    pub indicator: String,
    /// Its unit; empty for a ratio.
    pub unit: &'static str,
    /// What its past shows.
    pub verdict: Verdict,
    /// Change a day: slope, lower and upper end of its 95 % interval.
    pub per_day: Option<[f64; 3]>,
    /// Level now, on the line.
    pub level: Option<f64>,
    /// The limit beyond which it needs action, on the side to which it goes; `null` if there is none.
    pub limit: Option<f64>,
    /// Days until then; `null` without a trend towards it.
    pub remaining_days: Option<f64>,
    /// Not earlier than this, days; `null` if the data rule out that it comes.
    pub remaining_days_low: Option<f64>,
    /// Not later than this, days; `null` if it may never come.
    pub remaining_days_high: Option<f64>,
    /// Points behind it.
    pub points: u32,
    /// Days from the first to the last.
    pub span_days: f64,
}

/// Trends of a wagon.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct TrendList {
    /// The wagon.
    pub wagon: u32,
    /// One line an indicator.
    pub trends: Vec<TrendView>,
}

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

fn view(
    indicator: &str,
    unit: &'static str,
    limits: Option<(Option<f64>, Option<f64>)>,
    trend: Option<Trend>,
) -> TrendView {
    let days = |seconds: Option<f64>| seconds.map(|seconds| rounded(seconds / DAY_S as f64));
    let (low, high) = limits.unwrap_or_default();
    let limit = match trend {
        Some(trend) if trend.slope_per_s[0] < 0.0 => low.or(high),
        _ => high.or(low),
    };
    let left = trend.zip(limit).map(|(trend, limit)| trend.remaining(limit));
    let verdict = match trend {
        None => Verdict::TooLittleData,
        Some(trend) if !trend.certain => Verdict::NoTrend,
        Some(trend) if trend.slope_per_s[0] > 0.0 => Verdict::Rising,
        Some(_) => Verdict::Falling,
    };
    TrendView {
        indicator: indicator.to_owned(),
        unit,
        verdict,
        per_day: trend.map(|trend| trend.slope_per_s.map(|slope| rounded(DAY_S as f64 * slope))),
        level: trend.map(|trend| rounded(trend.level[0])),
        limit: limit.map(rounded),
        remaining_days: days(left.and_then(|left| left.value_s)),
        remaining_days_low: days(left.and_then(|left| left.low_s)),
        remaining_days_high: days(left.and_then(|left| left.high_s)),
        points: trend.map_or(0, |trend| trend.points as u32),
        span_days: rounded(trend.map_or(0.0, |trend| trend.span_s / DAY_S as f64)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_is_the_one_ahead() {
        let falling: Vec<(f64, f64)> = (0..240)
            .map(|hour| {
                (3600.0 * f64::from(hour), 0.35 - 1e-4 * f64::from(hour) + 1e-4 * f64::from(hour % 3))
            })
            .collect();
        let limits = Some((Some(0.245), Some(0.49)));
        let seen = view("brake_friction", "", limits, Trend::of(&falling));
        println!("{seen:?}");
        assert_eq!((seen.verdict, seen.limit), (Verdict::Falling, Some(0.245)));
        // From 0.326 by 0.0024 a day: 33.8 days.
        let (left, low, high) = (
            seen.remaining_days.unwrap(),
            seen.remaining_days_low.unwrap(),
            seen.remaining_days_high.unwrap(),
        );
        assert!(low <= left && left <= high && (left - 33.8).abs() < 1.0, "{left}");
        assert_eq!(view("x", "", None, Trend::of(&falling)).remaining_days, None);
        assert_eq!(view("x", "", limits, None).verdict, Verdict::TooLittleData);
    }
}
