//! Requests for the braking capability.

use crate::api::capability::model::CapabilityView;
use crate::api::problem::Problem;
use crate::shared::Shared;
use crate::web::query;
use axum::Json;
use axum::extract::{RawQuery, State};
use railgrip_indicators::train::capability::Capability;

/// Stopping distances from the present friction and adhesion, against nominal.
#[utoipa::path(get, path = "/api/v1/train/capability", tag = "train",
    params(("speed_km_h" = Option<f64>, Query, minimum = 1, maximum = 500,
        description = "One speed, km/h, instead of those of the config")),
    responses(
        (status = 200, description = "Now against nominal", body = CapabilityView),
        (status = 400, description = "A query parameter is wrong; the detail names it and what is allowed"),
    ))]
pub(crate) async fn capability(
    State(shared): State<Shared>,
    RawQuery(query): RawQuery,
) -> Result<Json<CapabilityView>, Problem> {
    let snapshot = shared.latest();
    let pairs = query::parameters(query.as_deref(), &["speed_km_h"])?;
    let Some(text) = query::value(&pairs, "speed_km_h") else {
        return Ok(Json(snapshot.whole.capability.clone()));
    };
    let speed = text.parse().ok().filter(|speed: &f64| (1.0..=500.0).contains(speed));
    let speed = speed.ok_or_else(|| query::refuse("speed_km_h", text, "1 to 500"))?;
    let whole = &snapshot.whole;
    let full = whole.settings.full_braking();
    let found = Capability::of(&whole.braked, whole.found.known_wagons, &full, &[speed]);
    Ok(Json(CapabilityView::of(&found, &full, &whole.vehicles)))
}
