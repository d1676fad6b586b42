//! The pages for people: the train at `/`, a wagon at `/wagons/{id}`, the alerts at `/alerts`, and what
//! every figure means at `/indicators`.
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
mod frame;
mod live;
mod meaning;
mod outlook;
mod stopping;
mod train;
mod wagon;
mod words;

use crate::api::problem::Problem;
use crate::shared::Shared;
use crate::store::Snapshot;
use axum::Router;
use axum::extract::{Path, State};
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use maud::Markup;

/// Only what this service itself serves; nothing inline.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; connect-src 'self'; \
                      manifest-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// Which page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Page {
    Train,
    Wagon(u32),
    Alerts,
    Meaning,
}

/// A piece of a page that renews itself.
struct Part {
    /// `id` of its element.
    id: String,
    /// The element.
    html: Markup,
}

impl Part {
    fn new(id: impl Into<String>, html: Markup) -> Self {
        Self { id: id.into(), html }
    }
}

impl Page {
    /// As the query of `/live` names it.
    fn parse(text: &str) -> Option<Self> {
        match text {
            "train" => Some(Self::Train),
            "alerts" => Some(Self::Alerts),
            "indicators" => Some(Self::Meaning),
            _ => text.strip_prefix("wagon-")?.parse().ok().map(Self::Wagon),
        }
    }

    fn key(self) -> String {
        match self {
            Self::Train => "train".to_owned(),
            Self::Alerts => "alerts".to_owned(),
            Self::Meaning => "indicators".to_owned(),
            Self::Wagon(id) => format!("wagon-{id}"),
        }
    }

    /// Everything that renews itself on this page.
    fn parts(self, shared: &Shared, snapshot: &Snapshot) -> Vec<Part> {
        let mut parts = frame::parts(shared, snapshot);
        parts.extend(match self {
            Self::Train => train::parts(shared, snapshot),
            Self::Alerts => alerts::parts(shared, snapshot),
            Self::Meaning => Vec::new(),
            Self::Wagon(id) => wagon::parts(id, shared.limits(), snapshot),
        });
        parts
    }

    fn document(self, shared: &Shared, snapshot: &Snapshot) -> Markup {
        let (title, body) = match self {
            Self::Train => ("Train".to_owned(), train::body(shared, snapshot)),
            Self::Alerts => ("Alerts".to_owned(), alerts::body(shared, snapshot)),
            Self::Meaning => ("What the figures mean".to_owned(), meaning::body(shared.limits())),
            Self::Wagon(id) => (format!("Wagon {id}"), wagon::body(id, shared.limits(), snapshot)),
        };
        frame::document(self, &title, shared, snapshot, &body)
    }
}

/// The pages and what they load.
pub(crate) fn routes() -> Router<Shared> {
    Router::new()
        .route("/", get(train_page))
        .route("/alerts", get(alerts_page))
        .route("/indicators", get(meaning_page))
        .route("/wagons/{id}", get(wagon_page))
        .route("/wagons/{id}/outlook", get(outlook::outlook))
        .route("/live", get(live::live))
        .route("/assets/{name}", get(assets::asset))
        .route("/favicon.ico", get(assets::favicon))
}

async fn train_page(State(shared): State<Shared>) -> Response {
    answer(Page::Train, &shared)
}

async fn alerts_page(State(shared): State<Shared>) -> Response {
    answer(Page::Alerts, &shared)
}

async fn meaning_page(State(shared): State<Shared>) -> Response {
    answer(Page::Meaning, &shared)
}

async fn wagon_page(State(shared): State<Shared>, Path(id): Path<String>) -> Response {
    let snapshot = shared.latest();
    match id.parse().ok().filter(|id| snapshot.wagons.iter().any(|wagon| wagon.id == *id)) {
        Some(id) => answer(Page::Wagon(id), &shared),
        None => {
            let body = frame::nowhere(&shared, &snapshot, &id);
            (StatusCode::NOT_FOUND, headers(), body.into_string()).into_response()
        }
    }
}

fn answer(page: Page, shared: &Shared) -> Response {
    let snapshot = shared.latest();
    (headers(), page.document(shared, &snapshot).into_string()).into_response()
}

fn headers() -> [(HeaderName, HeaderValue); 4] {
    [
        (header::CONTENT_TYPE, HeaderValue::from_static("text/html; charset=utf-8")),
        (header::CONTENT_SECURITY_POLICY, HeaderValue::from_static(POLICY)),
        (header::CACHE_CONTROL, HeaderValue::from_static("no-store")),
        (header::X_CONTENT_TYPE_OPTIONS, HeaderValue::from_static("nosniff")),
    ]
}

fn not_a_page(text: &str) -> Problem {
    let detail = format!("page is \"{text}\"; allowed is train, alerts, indicators or wagon-NUMBER");
    Problem::new(StatusCode::BAD_REQUEST, detail)
}
