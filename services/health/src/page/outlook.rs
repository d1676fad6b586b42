//! Where the indicators of a wagon are going, in words: a table that the page's script fetches, so that a page itself
//! waits for no database.

use super::words::{NOTHING, Written, capital, plain};
use crate::api::problem::Problem;
use crate::api::trends::model::{TrendView, Verdict};
use crate::api::trends::routes as trends;
use crate::shared::Shared;
use axum::Extension;
use axum::extract::{Path, State};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use maud::{Markup, html};
use railgrip_indicators::{Form, INDICATORS, IndicatorSpec};
use railgrip_words::{Language, say, speak, t};

/// Beyond so many days nobody plans.
const FAR_DAYS: f64 = 730.0;

/// The table of a wagon as a part of its page.
pub(super) async fn outlook(
    State(shared): State<Shared>,
    Extension(language): Extension<Language>,
    Path(id): Path<String>,
) -> Result<Response, Problem> {
    let count = shared.latest().wagons.len();
    let wagon = id.parse().ok().filter(|id: &u32| (1..=count).contains(&(*id as usize)));
    let wagon =
        wagon.ok_or_else(|| Problem::new(StatusCode::NOT_FOUND, format!("there is no wagon \"{id}\"")))?;
    let trends = trends::of(&shared, wagon).await?;
    let headers = [
        (header::CONTENT_TYPE, HeaderValue::from_static("text/html; charset=utf-8")),
        (header::CACHE_CONTROL, HeaderValue::from_static("no-store")),
    ];
    Ok((headers, speak(language, || table(&trends).into_string())).into_response())
}

/// What stands there until the script has fetched it.
pub(super) fn placeholder() -> Markup {
    html! { div #outlook { p .calm { (t("Loading trends…")) } } }
}

fn table(trends: &[TrendView]) -> Markup {
    let known: Vec<&TrendView> = trends.iter().filter(|trend| trend.level.is_some()).collect();
    let moves = |trend: &&TrendView| matches!(trend.verdict, Verdict::Rising | Verdict::Falling);
    // What moves towards a limit comes first, the nearest first; what does not move is only named.
    let (mut moving, still): (Vec<&TrendView>, Vec<&TrendView>) =
        known.iter().partition(|trend| moves(trend));
    let days = |trend: &TrendView| trend.remaining_days.unwrap_or(f64::INFINITY);
    moving.sort_by(|a, b| days(a).total_cmp(&days(b)));
    html! {
        div #outlook {
            @if known.is_empty() {
                p .calm { (t("There is too little history for a trend yet: at least eight points over one hour are needed.")) }
            }
            @if !moving.is_empty() {
                table .outlook {
                    (head())
                    tbody { @for trend in moving { (line(trend)) } }
                }
            }
            @if !still.is_empty() {
                details #fold-still .fold {
                    summary {
                        b { (say("{count} with no trend", &[("count", &still.len())])) }
                        span .names { (still.iter().map(|trend| name(&trend.indicator)).collect::<Vec<_>>().join("; ")) }
                    }
                    table .outlook { (head()) tbody { @for trend in still { (line(trend)) } } }
                }
            }
        }
    }
}

fn head() -> Markup {
    html! {
        thead { tr {
            th scope="col" { (t("Indicator")) } th scope="col" { (t("Trend")) } th scope="col" .num { (t("Level")) }
            th scope="col" .num { (t("Change a day")) } th scope="col" { (t("95 % interval")) }
            th scope="col" .num { (t("Limit")) } th scope="col" { (t("Time left")) } th scope="col" { (t("Based on")) }
        } }
    }
}

fn line(trend: &TrendView) -> Markup {
    let form = form(trend);
    let per_day = Form { digits: form.digits + 1, ..form };
    let [slope, low, high] = trend.per_day.unwrap_or_default();
    let (verdict, arrow) = match trend.verdict {
        Verdict::Rising => (t("rising"), "↗"),
        Verdict::Falling => (t("falling"), "↘"),
        Verdict::NoTrend => (t("no trend"), "→"),
        Verdict::TooLittleData => (t("too little data"), "·"),
    };
    html! {
        tr {
            th scope="row" { (name(&trend.indicator)) }
            td data-label=(t("Trend")) { span aria-hidden="true" { (arrow) } " " (verdict) }
            td .num data-label=(t("Level")) { (form.value(trend.level)) }
            td .num data-label=(t("Change a day")) { (signed(per_day, slope)) }
            td .interval data-label=(t("95 % interval")) { (say("{low} to {high}", &[("low", &signed(per_day, low)), ("high", &signed(per_day, high))])) }
            td .num data-label=(t("Limit")) { (form.value(trend.limit)) }
            td .c-left data-label=(t("Time left")) .loud[trend.remaining_days.is_some_and(|days| days < 14.0)] { (time_left(trend)) }
            td .aside data-label=(t("Based on")) { (say("{count} points, {time}", &[("count", &trend.points), ("time", &span(trend.span_days))])) }
        }
    }
}

/// The indicator and the wheelset of a field of the history.
fn indicator(field: &str) -> (Option<&'static IndicatorSpec>, Option<&str>) {
    let of_wheelset = field.strip_prefix("wheelset_").and_then(|rest| rest.split_once('.'));
    let (wheelset, field) = of_wheelset.map_or((None, field), |(number, field)| (Some(number), field));
    (INDICATORS.iter().find(|spec| spec.field() == field), wheelset)
}

fn form(trend: &TrendView) -> Form {
    let form = indicator(&trend.indicator).0.map_or(Form::COEFFICIENT, |spec| spec.form);
    // Shares move by little from day to day.
    if form == Form::PERCENT { Form { digits: 1, ..form } } else { form }
}

fn signed(form: Form, value: f64) -> String {
    let text = form.value(Some(value));
    if value > 0.0 { format!("+{text}") } else { text }
}

/// `wheelset_1.brake_friction` as `Pad friction, wheelset 1`.
fn name(field: &str) -> String {
    let (spec, wheelset) = indicator(field);
    let name = spec.map_or_else(|| capital(&plain(field)), |spec| t(spec.name()).to_owned());
    wheelset.map_or_else(
        || name.clone(),
        |number| format!("{name}, {}", say("wheelset {number}", &[("number", &number)])),
    )
}

/// The time until it needs action, with its interval: `about 40 days (30 to 55)`.
fn time_left(trend: &TrendView) -> String {
    let past = |limit: f64, level: f64| match trend.verdict {
        Verdict::Rising => level > limit,
        Verdict::Falling => level < limit,
        _ => false,
    };
    match (trend.verdict, trend.remaining_days) {
        (Verdict::TooLittleData, _) | (_, None) if trend.limit.is_none() => NOTHING.to_owned(),
        (Verdict::NoTrend | Verdict::TooLittleData, _) => t("no trend towards a limit").to_owned(),
        (_, None) => {
            let over = trend.limit.zip(trend.level).is_some_and(|(limit, level)| past(limit, level));
            if over { t("limit already passed") } else { t("moving away from the limit") }.to_owned()
        }
        (_, Some(days)) if days > FAR_DAYS => t("more than 2 years").to_owned(),
        (_, Some(days)) => {
            let low = trend.remaining_days_low.map_or_else(|| "?".to_owned(), span);
            let high = trend.remaining_days_high.filter(|high| *high <= FAR_DAYS);
            match high {
                Some(high) => say(
                    "about {time} ({low} to {high})",
                    &[("time", &span(days)), ("low", &low), ("high", &span(high))],
                ),
                None => say("about {time} (at least {low})", &[("time", &span(days)), ("low", &low)]),
            }
        }
    }
}

/// Days in the unit that reads best.
fn span(days: f64) -> String {
    match days {
        days if days * 24.0 < 2.0 => format!("{:.0} min", days * 1440.0),
        days if days < 2.0 => format!("{:.0} h", days * 24.0),
        days => say("{count} days", &[("count", &format!("{days:.0}"))]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trend(verdict: Verdict, left: [Option<f64>; 3]) -> TrendView {
        TrendView {
            indicator: "wheelset_2.brake_friction".to_owned(),
            unit: "",
            verdict,
            per_day: Some([-0.002, -0.003, -0.001]),
            level: Some(0.31),
            limit: Some(0.245),
            remaining_days: left[0],
            remaining_days_low: left[1],
            remaining_days_high: left[2],
            points: 240,
            span_days: 10.0,
        }
    }

    #[test]
    fn the_time_left_reads_well() {
        let said = |verdict, left| time_left(&trend(verdict, left));
        assert_eq!(
            said(Verdict::Falling, [Some(33.0), Some(21.7), Some(65.0)]),
            "about 33 days (22 days to 65 days)"
        );
        assert_eq!(said(Verdict::Falling, [Some(1.0), Some(0.5), None]), "about 24 h (at least 12 h)");
        assert_eq!(said(Verdict::NoTrend, [None; 3]), "no trend towards a limit");
        assert_eq!(said(Verdict::Rising, [None; 3]), "limit already passed");
        let mut away = trend(Verdict::Rising, [None; 3]);
        away.limit = Some(0.49);
        assert_eq!(time_left(&away), "moving away from the limit");
        assert_eq!(name("wheelset_2.brake_friction"), "Pad friction, wheelset 2");
    }
}
