//! Whom the service takes a client for.

use super::role::{Identity, Role};
use axum::{Extension, Json};
use serde::Serialize;
use utoipa::ToSchema;

/// Whom the service takes a client for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub(crate) struct WhoAmI {
    /// Name of the token, by which actions are signed; `null` where no tokens are asked for, so that people sign themselves.
    name: Option<String>,
    /// What they may do.
    #[schema(value_type = String)]
    role: Role,
}

/// Whom the service takes this client for: its name signs whatever it changes.
#[utoipa::path(get, path = "/api/v1/identity", tag = "service",
    responses((status = 200, description = "Name and role", body = WhoAmI)))]
pub(crate) async fn identity(identity: Option<Extension<Identity>>) -> Json<WhoAmI> {
    let name = identity.as_ref().and_then(|identity| identity.vouched_name().map(str::to_owned));
    Json(WhoAmI { name, role: identity.map_or(Role::Admin, |Extension(identity)| identity.role) })
}
