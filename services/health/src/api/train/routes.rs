//! Requests for the train at a glance.

use crate::api::answer::of_snapshot;
use crate::api::train::model::TrainView;
use crate::shared::Shared;
use axum::extract::State;
use axum::response::Response;

/// The train at a glance.
#[utoipa::path(get, path = "/api/v1/train", tag = "train", responses(
    (status = 200, description = "The train now", body = TrainView),
))]
pub(crate) async fn train(State(shared): State<Shared>) -> Response {
    let snapshot = shared.latest();
    of_snapshot(&snapshot, snapshot.train_json.clone())
}
