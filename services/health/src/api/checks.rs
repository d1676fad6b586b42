//! Whether the service works, and whether the train behind it does: for supervisors and load balancers.

use crate::shared::Shared;
use axum::Json;
use axum::extract::State;
use axum::http::StatusCode;
use serde::Serialize;
use utoipa::ToSchema;

/// A snapshot older than this means that the feeding thread is stuck, s.
const STUCK_S: f64 = 5.0;
/// Whether the service, or the train behind it, is as it should be.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct Check {
    /// `ok`, or what is not.
    pub status: String,
    /// What is missing, in words.
    pub reasons: Vec<String>,
}
/// Whether the service itself works: for a supervisor that restarts it.
#[utoipa::path(get, path = "/health/live", tag = "health", responses(
    (status = 200, description = "The service works", body = Check),
    (status = 503, description = "It is stuck and should be restarted", body = Check),
))]
pub(crate) async fn live(State(shared): State<Shared>) -> (StatusCode, Json<Check>) {
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
pub(crate) async fn ready(State(shared): State<Shared>) -> (StatusCode, Json<Check>) {
    let reasons = shared.latest().not_ready.clone();
    if reasons.is_empty() {
        return (StatusCode::OK, Json(Check { status: "ok".to_owned(), reasons }));
    }
    (StatusCode::SERVICE_UNAVAILABLE, Json(Check { status: "not ready".to_owned(), reasons }))
}
