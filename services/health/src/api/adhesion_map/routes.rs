//! Requests for adhesion along the track.

use crate::api::adhesion_map::model::MapView;
use crate::shared::Shared;
use axum::Json;
use axum::extract::State;

/// Adhesion by track position, from what every wagon saw that passed; it fades when nobody passes.
#[utoipa::path(get, path = "/api/v1/train/adhesion-map", tag = "train", responses(
    (status = 200, description = "The passed stretches", body = MapView),
))]
pub(crate) async fn adhesion_map(State(shared): State<Shared>) -> Json<MapView> {
    Json(shared.latest().whole.map.clone())
}
