//! The HTTP interface: one handler a route, the router, and its OpenAPI description.

use crate::history::query::{parameters, refuse, value};
use crate::model::{Check, DataState, Grade, TrainView, WagonList, WagonRow, WagonView};
use crate::problem::Problem;
use crate::shared::Shared;
use crate::store::Snapshot;
use crate::web::pages::{MOST, Page, link};
use crate::{docs, history, metrics, page, stream, web};
use axum::Json;
use axum::body::Bytes;
use axum::extract::{Path, RawQuery, State};
use axum::http::{HeaderValue, Method, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

/// A snapshot older than this means that the feeding thread is stuck, s.
const STUCK_S: f64 = 5.0;

#[derive(OpenApi)]
#[openapi(
    info(
        title = "railgrip",
        description = "Brake friction and adhesion of every wagon of a train. Figures carry a 95 % interval, a grade and the \
                   reason in words; what is unknown is null; what is stale says so with its age."
    ),
    paths(crate::doors::records::records),
    components(schemas(Problem))
)]
struct Api;

/// All routes of the service.
pub fn router(shared: Shared) -> axum::Router {
    let (router, api) = OpenApiRouter::with_openapi(Api::openapi())
        .routes(routes!(live))
        .routes(routes!(ready))
        .routes(routes!(train))
        .routes(routes!(crate::train::capability))
        .routes(routes!(crate::train::adhesion_map))
        .routes(routes!(wagons))
        .routes(routes!(wagon))
        .routes(routes!(history::routes::history))
        .routes(routes!(crate::trends::trends))
        .routes(routes!(history::routes::overview))
        .routes(routes!(history::export::route::export))
        .routes(routes!(history::events::events))
        .routes(routes!(crate::alerts::routes::alerts))
        .routes(routes!(crate::alerts::routes::alert))
        .routes(routes!(crate::alerts::routes::acknowledge))
        .routes(routes!(crate::alerts::routes::shelve))
        .routes(routes!(crate::alerts::routes::unshelve))
        .routes(routes!(crate::delivery::deliveries))
        .routes(routes!(stream::stream))
        .routes(routes!(metrics::metrics))
        .routes(routes!(openapi))
        .split_for_parts();
    let _ = shared.openapi().set(docs::describe(&api, &shared.fields()).into());
    let router = router
        .merge(page::routes())
        .route("/docs", axum::routing::get(docs::page))
        .route("/docs.css", axum::routing::get(docs::style))
        .method_not_allowed_fallback(wrong_method)
        .fallback(nowhere)
        .with_state(shared);
    web::around(router)
}

fn as_json(body: Bytes) -> Response {
    ([(header::CONTENT_TYPE, HeaderValue::from_static("application/json"))], body).into_response()
}

/// What is the same in every answer from one snapshot has a tag that costs nothing to make.
fn of_snapshot(snapshot: &Snapshot, body: Bytes) -> Response {
    let tag = format!("W/\"{:x}-{:x}\"", snapshot.taken.unix_ns, snapshot.alert_version);
    let mut response = as_json(body);
    if let Ok(tag) = HeaderValue::from_str(&tag) {
        response.headers_mut().insert(header::ETAG, tag);
    }
    response
}

/// Whether the service itself works: for a supervisor that restarts it.
#[utoipa::path(get, path = "/health/live", tag = "health", responses(
    (status = 200, description = "The service works", body = Check),
    (status = 503, description = "It is stuck and should be restarted", body = Check),
))]
async fn live(State(shared): State<Shared>) -> (StatusCode, Json<Check>) {
    let age_s = shared.latest().taken.age_s(shared.now().monotonic_ns);
    if age_s <= STUCK_S {
        return (StatusCode::OK, Json(Check { status: "ok".to_owned(), reasons: Vec::new() }));
    }
    let reasons = vec![format!("the data of this service have not been renewed for {age_s:.0} s")];
    (StatusCode::SERVICE_UNAVAILABLE, Json(Check { status: "stuck".to_owned(), reasons }))
}

/// Whether every wagon is live: for whoever relies on the figures.
#[utoipa::path(get, path = "/health/ready", tag = "health", responses(
    (status = 200, description = "Every wagon is live", body = Check),
    (status = 503, description = "Some wagon is not; the reasons name it", body = Check),
))]
async fn ready(State(shared): State<Shared>) -> (StatusCode, Json<Check>) {
    let reasons = shared.latest().not_ready.clone();
    if reasons.is_empty() {
        return (StatusCode::OK, Json(Check { status: "ok".to_owned(), reasons }));
    }
    (StatusCode::SERVICE_UNAVAILABLE, Json(Check { status: "not ready".to_owned(), reasons }))
}

/// The train at a glance.
#[utoipa::path(get, path = "/api/v1/train", tag = "train", responses(
    (status = 200, description = "The train now", body = TrainView),
))]
async fn train(State(shared): State<Shared>) -> Response {
    let snapshot = shared.latest();
    of_snapshot(&snapshot, snapshot.train_json.clone())
}

/// All wagons, one line each, front first.
#[utoipa::path(get, path = "/api/v1/wagons", tag = "wagons",
    params(
        ("grade" = Option<Grade>, Query, description = "Only of this grade"),
        ("state" = Option<DataState>, Query, description = "Only in this state"),
        ("limit" = Option<u32>, Query, minimum = 1, maximum = 1000, description = "At most so many; default 1000"),
        ("after" = Option<i64>, Query, minimum = 0, description = "Only behind the wagon with this number"),
    ),
    responses(
        (status = 200, description = "The wagons now", body = WagonList, headers(
            ("ETag" = String, description = "For If-None-Match"),
            ("Link" = String, description = "The next page, rel=\"next\""))),
        (status = 400, description = "A query parameter is wrong; the detail names it and what is allowed"),
    ))]
async fn wagons(State(shared): State<Shared>, RawQuery(query): RawQuery) -> Result<Response, Problem> {
    let snapshot = shared.latest();
    if query.as_deref().unwrap_or_default().is_empty() {
        return Ok(of_snapshot(&snapshot, snapshot.rows_json.clone()));
    }
    let pairs = parameters(query.as_deref(), &["grade", "state", "limit", "after"])?;
    let page = Page::of(&pairs, MOST)?;
    let one_of = |name: &str, words: &[&str]| match value(&pairs, name) {
        Some(text) if !words.contains(&text) => Err(refuse(name, text, &words.join(", "))),
        text => Ok(text.map(str::to_owned)),
    };
    let grade = one_of("grade", &["unknown", "ok", "watch", "act"])?;
    let state = one_of("state", &["live", "stale", "silent"])?;
    let wanted = |row: &&WagonRow| {
        grade.as_deref().is_none_or(|grade| row.grade.word() == grade)
            && state.as_deref().is_none_or(|state| row.state.word() == state)
            && page.after.is_none_or(|after| u64::from(row.id) > after)
    };
    let mut all = snapshot.rows.iter().filter(wanted).peekable();
    let wagons: Vec<WagonRow> = all.by_ref().take(page.limit).cloned().collect();
    let last = wagons.last().filter(|_| all.peek().is_some());
    let next = last.map(|last| page.next("/api/v1/wagons", &pairs, u64::from(last.id)));
    let train = &snapshot.train;
    let list = WagonList {
        train: train.name.clone(),
        generated_at: train.generated_at.clone(),
        wagons,
        next: next.clone(),
    };
    Ok(link(Json(list).into_response(), next.as_deref()))
}

/// Everything about one wagon.
#[utoipa::path(get, path = "/api/v1/wagons/{id}", tag = "wagons",
    params(("id" = u32, Path, minimum = 1, description = "Number of the wagon, 1 first")),
    responses(
        (status = 200, description = "The wagon now", body = WagonView),
        (status = 404, description = "There is no such wagon"),
    ))]
async fn wagon(State(shared): State<Shared>, Path(id): Path<String>) -> Result<Json<WagonView>, Problem> {
    let snapshot = shared.latest();
    let found = id.parse().ok().and_then(|id: u32| snapshot.wagons.iter().find(|wagon| wagon.id == id));
    found.cloned().map(Json).ok_or_else(|| {
        let detail = format!("there is no wagon \"{id}\"; allowed is 1 to {}", snapshot.wagons.len());
        Problem::new(StatusCode::NOT_FOUND, detail)
    })
}

/// This description.
#[utoipa::path(get, path = "/openapi.json", tag = "service", responses(
    (status = 200, description = "OpenAPI 3.1", body = serde_json::Value),
))]
async fn openapi(State(shared): State<Shared>) -> Response {
    as_json(shared.openapi().get().cloned().unwrap_or_default())
}

async fn nowhere(uri: Uri) -> Problem {
    let detail = format!("there is nothing at {}; see /openapi.json", uri.path());
    Problem::new(StatusCode::NOT_FOUND, detail)
}

async fn wrong_method(method: Method, uri: Uri) -> Problem {
    let detail = format!("{} does not take {method}; see /openapi.json", uri.path());
    Problem::new(StatusCode::METHOD_NOT_ALLOWED, detail)
}
