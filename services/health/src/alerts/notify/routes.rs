//! Requests for how the receivers are.

use crate::alerts::notify::status::ReceiverList;
use crate::shared::Shared;
use axum::Json;
use axum::extract::State;

/// Receivers of notifications: what waits for them, what they have confirmed, why they cannot be reached.
#[utoipa::path(get, path = "/api/v1/receivers", tag = "alerts", responses(
    (status = 200, description = "Each receiver", body = ReceiverList),
))]
pub(crate) async fn receivers(State(shared): State<Shared>) -> Json<ReceiverList> {
    Json(shared.receiver_states().view())
}

/// The old path of `/api/v1/receivers`.
#[utoipa::path(get, path = "/api/v1/delivery", tag = "alerts", operation_id = "deliveries", responses(
    (status = 200, description = "Each receiver", body = ReceiverList),
))]
pub(crate) async fn delivery(State(shared): State<Shared>) -> Json<ReceiverList> {
    Json(shared.receiver_states().view())
}
