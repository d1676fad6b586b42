//! The pages for people: the train at `/`, a wagon at `/wagons/{id}`, the alerts at `/alerts`, and what
//! every figure means at `/indicators`, thresholds and receivers at `/settings`.
//!
//! # Terms
//! * **part** – a piece of a page that renews itself: an element with an `id`, rendered here and nowhere else.
//! * **page** – a frame around parts. The first answer holds all of them, so that a page reads without any script.
//! * **live** – `/live?page=…` sends, as server-sent events, the parts that changed since the last time; the script on the
//!   page puts them in place. No page knows how to render anything but charts.
//!
//! Nothing comes from elsewhere, nothing is inline: the pages work without internet and under a strict content policy.

mod alerts;
mod assets;
mod bar;
mod compose;
mod frame;
mod indicators;
mod kind;
mod live;
mod meaning;
mod notes;
mod outlook;
mod paper;
mod receivers;
mod settings;
mod stopping;
mod train;
mod trends;
mod wagon;
mod words;

use crate::shared::Shared;
use axum::Extension;
use axum::Router;
use axum::extract::{Path, State};
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use kind::Page;
use railgrip_words::{Language, speak};

/// Only what this service itself serves; nothing inline.
pub(crate) const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; \
                      manifest-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Where the style of all pages is, for pages that are made elsewhere.
pub(crate) fn style_sheet() -> String {
    assets::path("style.css")
}

/// The pages and what they load.
pub(crate) fn routes() -> Router<Shared> {
    Router::new()
        .route("/", get(train_page))
        .route("/alerts", get(alerts_page))
        .route("/indicators", get(meaning_page))
        .route("/settings", get(settings_page))
        .route("/wagons/{id}", get(wagon_page))
        .route("/wagons/{id}/outlook", get(outlook::outlook))
        .route("/live", get(live::live))
        .route("/assets/{name}", get(assets::asset))
        .route("/favicon.ico", get(assets::favicon))
}

async fn train_page(State(shared): State<Shared>, Extension(language): Extension<Language>) -> Response {
    answer(Page::Train, language, &shared)
}

async fn alerts_page(State(shared): State<Shared>, Extension(language): Extension<Language>) -> Response {
    answer(Page::Alerts, language, &shared)
}

async fn meaning_page(State(shared): State<Shared>, Extension(language): Extension<Language>) -> Response {
    answer(Page::Meaning, language, &shared)
}

async fn settings_page(State(shared): State<Shared>, Extension(language): Extension<Language>) -> Response {
    answer(Page::Settings, language, &shared)
}

async fn wagon_page(
    State(shared): State<Shared>,
    Extension(language): Extension<Language>,
    Path(id): Path<String>,
) -> Response {
    let snapshot = shared.latest();
    match id.parse().ok().filter(|id| snapshot.wagons.iter().any(|wagon| wagon.id == *id)) {
        Some(id) => answer(Page::Wagon(id), language, &shared),
        None => {
            let body = speak(language, || frame::nowhere(&shared, &snapshot, &id).into_string());
            (StatusCode::NOT_FOUND, headers(language), body).into_response()
        }
    }
}

fn answer(page: Page, language: Language, shared: &Shared) -> Response {
    let snapshot = shared.latest();
    let text = speak(language, || compose::document(page, shared, &snapshot).into_string());
    (headers(language), text).into_response()
}

fn headers(language: Language) -> [(HeaderName, HeaderValue); 6] {
    [
        (header::CONTENT_TYPE, HeaderValue::from_static("text/html; charset=utf-8")),
        (header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(POLICY)),
        (header::CACHE_CONTROL, HeaderValue::from_static("no-store")),
        (header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff")),
        (header::CONTENT_LANGUAGE, HeaderValue::from_static(language.tag())),
        (header::VARY, HeaderValue::from_static("Accept-Language, Cookie")),
    ]
}
