//! Requests for the wagons.

use crate::api::answer::of_snapshot;
use crate::api::grade::{DataState, Grade};
use crate::api::problem::Problem;
use crate::api::wagons::model::{WagonList, WagonRow, WagonView};
use crate::shared::Shared;
use crate::web::pages::{MOST, Page, link};
use crate::web::query::{parameters, refuse, value};
use axum::Json;
use axum::extract::{Path, RawQuery, State};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};

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
pub(crate) async fn wagons(
    State(shared): State<Shared>,
    RawQuery(query): RawQuery,
) -> Result<Response, Problem> {
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
pub(crate) async fn wagon(
    State(shared): State<Shared>,
    Path(id): Path<String>,
) -> Result<Json<WagonView>, Problem> {
    let snapshot = shared.latest();
    let found = id.parse().ok().and_then(|id: u32| snapshot.wagons.iter().find(|wagon| wagon.id == id));
    found.cloned().map(Json).ok_or_else(|| {
        let detail = format!("there is no wagon \"{id}\"; allowed is 1 to {}", snapshot.wagons.len());
        Problem::new(StatusCode::NOT_FOUND, detail)
    })
}
