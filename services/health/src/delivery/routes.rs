//! Requests for how delivery is.

use crate::delivery::status::DeliveryView;
use crate::shared::Shared;
use axum::Json;
use axum::extract::State;

/// Receivers of alerts: what waits for them, what they have confirmed, why they cannot be reached.
#[utoipa::path(get, path = "/api/v1/delivery", tag = "alerts", responses(
    (status = 200, description = "Each receiver", body = DeliveryView),
))]
pub(crate) async fn deliveries(State(shared): State<Shared>) -> Json<DeliveryView> {
    Json(shared.mailbox().view())
}
