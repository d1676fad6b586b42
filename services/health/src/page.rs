//! The page at `/`: the wagons as a table that renews itself. Nothing on it comes from elsewhere.

use crate::model::{Alert, TrainView, WagonRow};
use crate::shared::Shared;
use axum::extract::State;
use axum::http::{HeaderName, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use maud::{DOCTYPE, Markup, html};

const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = include_str!("page.js");
/// Only what this service itself serves.
const POLICY: &str = "default-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

pub(crate) async fn index(State(shared): State<Shared>) -> Response {
    let snapshot = shared.latest();
    let active: Vec<&Alert> = snapshot.alerts.alerts.iter().filter(|alert| alert.active).collect();
    let body = document(&snapshot.train, &snapshot.rows, &active).into_string();
    let headers: [(HeaderName, HeaderValue); 3] = [
        (header::CONTENT_TYPE, HeaderValue::from_static("text/html; charset=utf-8")),
        (header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(POLICY)),
        (header::CACHE_CONTROL, HeaderValue::from_static("no-store")),
    ];
    (headers, body).into_response()
}

pub(crate) async fn style() -> impl IntoResponse {
    ([(header::CONTENT_TYPE, HeaderValue::from_static("text/css; charset=utf-8"))], STYLE)
}

pub(crate) async fn script() -> impl IntoResponse {
    ([(header::CONTENT_TYPE, HeaderValue::from_static("text/javascript; charset=utf-8"))], SCRIPT)
}

fn document(train: &TrainView, rows: &[WagonRow], alerts: &[&Alert]) -> Markup {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { "railgrip – " (train.name) }
                link rel="stylesheet" href="/app.css";
                link rel="icon" href="data:,";
                script src="/app.js" defer {}
            }
            body {
                header {
                    h1 { "Train " (train.name) }
                    p #verdict class={ "grade " (train.grade.word()) } { (train.grade.word()) ": " (train.reason) }
                    p #link role="status" { "as of " (train.generated_at) }
                }
                main {
                    (table(rows))
                    (alert_list(alerts))
                }
                footer {
                    a href="/api/v1/train" { "train" } " · "
                    a href="/api/v1/wagons" { "wagons" } " · "
                    a href="/api/v1/alerts" { "alerts" } " · "
                    a href="/metrics" { "metrics" } " · "
                    a href="/openapi.json" { "OpenAPI" }
                }
            }
        }
    }
}

fn table(rows: &[WagonRow]) -> Markup {
    html! {
        section {
            h2 { "Wagons" }
            table {
                thead { tr {
                    th scope="col" { "Wagon" }
                    th scope="col" { "Grade" }
                    th scope="col" { "Speed" small { " km/h" } }
                    th scope="col" { "Adhesion utilised" }
                    th scope="col" { "Adhesion available" }
                    th scope="col" { "Rail" }
                    th scope="col" { "Brake friction" }
                    th scope="col" { "Slides" }
                    th scope="col" { "Age" small { " s" } }
                    th scope="col" .wide { "Why" }
                } }
                tbody #wagons { @for row in rows { (line(row)) } }
            }
        }
    }
}

fn line(row: &WagonRow) -> Markup {
    let number = |value: Option<f64>, digits: usize| {
        value.map_or_else(|| "–".to_owned(), |value| format!("{value:.digits$}"))
    };
    let bound = if row.adhesion_available_is_lower_bound == Some(true) && row.adhesion_available.is_some() {
        "≥ "
    } else {
        ""
    };
    let slides = match (row.wsp_active, row.sliding) {
        (Some(true), _) => "WSP acts",
        (_, Some(true)) => "slides",
        (None, _) => "–",
        _ => "rolls",
    };
    html! {
        tr data-wagon=(row.id) class=(row.state.word()) {
            th scope="row" { a href={ "/api/v1/wagons/" (row.id) } { (row.id) } " " (row.name) }
            td class={ "grade " (row.grade.word()) } { (row.grade.word()) }
            td { (number(row.v_m_s.map(|v| 3.6 * v), 0)) }
            td { (number(row.adhesion_utilised, 3)) }
            td { (bound) (number(row.adhesion_available, 3)) }
            td { (row.condition.map_or("–", |condition| condition.word())) }
            td { (number(row.brake_friction, 3)) }
            td { (slides) }
            td { (number(row.age_s, 1)) }
            td .wide { (row.reason) }
        }
    }
}

fn alert_list(alerts: &[&Alert]) -> Markup {
    html! {
        section {
            h2 { "Alerts" }
            ul #alerts aria-live="polite" {
                @for alert in alerts {
                    li data-alert=(alert.id) {
                        span class={ "grade " (alert.grade.word()) } { (alert.grade.word()) }
                        " wagon " (alert.wagon)
                        @if let Some(wheelset) = alert.wheelset { ", wheelset " (wheelset) }
                        ": " (alert.cause.replace('_', " ")) " – " (alert.reason) ". " (alert.advice)
                    }
                }
            }
            p #calm { "No other alert is active." }
        }
    }
}
