//! All routes of the service, and their description.

use crate::api::answer::as_json;
use crate::api::figure::Figure;
use crate::api::problem::Problem;
use crate::api::{adhesion_map, capability, checks, docs, docs_page, metrics, stream, train, trends, wagons};
use crate::shared::Shared;
use crate::{alerts, history, notes, page, settings, web};
use axum::extract::State;
use axum::http::{Method, StatusCode, Uri};
use axum::response::Response;
use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

#[derive(OpenApi)]
#[openapi(
    info(
        title = "railgrip",
        description = "Brake friction and adhesion of every wagon of a train. Figures carry a 95 % interval, a grade and the \
                   reason in words; what is unknown is null; what is stale says so with its age."
    ),
    paths(crate::access::records::records),
    components(schemas(Figure, Problem))
)]
struct Api;

/// All routes of the service.
pub fn router(shared: Shared) -> axum::Router {
    let (router, api) = OpenApiRouter::with_openapi(Api::openapi())
        .routes(routes!(checks::live))
        .routes(routes!(checks::ready))
        .routes(routes!(train::routes::train))
        .routes(routes!(capability::routes::capability))
        .routes(routes!(adhesion_map::routes::adhesion_map))
        .routes(routes!(wagons::routes::wagons))
        .routes(routes!(wagons::routes::wagon))
        .routes(routes!(notes::routes::notes, notes::routes::add_note))
        .routes(routes!(settings::routes::settings, settings::routes::change_setting))
        .routes(routes!(settings::receiver_routes::receivers, settings::receiver_routes::change))
        .routes(routes!(crate::access::whoami::identity))
        .routes(routes!(history::routes::history))
        .routes(routes!(trends::routes::trends))
        .routes(routes!(history::routes::overview))
        .routes(routes!(history::export::route::export))
        .routes(routes!(history::events::events))
        .routes(routes!(alerts::routes::alerts))
        .routes(routes!(alerts::routes::alert))
        .routes(routes!(alerts::routes::report))
        .routes(routes!(alerts::routes::acknowledge))
        .routes(routes!(alerts::routes::unacknowledge))
        .routes(routes!(alerts::routes::silence))
        .routes(routes!(alerts::routes::unsilence))
        .routes(routes!(alerts::routes::shelve))
        .routes(routes!(alerts::routes::unshelve))
        .routes(routes!(alerts::notify::routes::receivers))
        .routes(routes!(alerts::notify::routes::delivery))
        .routes(routes!(stream::stream))
        .routes(routes!(metrics::metrics))
        .routes(routes!(openapi))
        .split_for_parts();
    let _ = shared.openapi().set(docs::describe(&api, &shared.fields(), shared.table()).into());
    let router = router
        .merge(page::routes())
        .route("/docs", axum::routing::get(docs_page::page))
        .route("/docs.css", axum::routing::get(docs_page::style))
        .method_not_allowed_fallback(wrong_method)
        .fallback(nowhere)
        .with_state(shared);
    web::around(router)
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
