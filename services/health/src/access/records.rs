//! Where an admin reads the audit log.

use crate::access::audit_file::{self, Shelf};
use crate::access::control::Access;
use crate::api::problem::Problem;
use crate::web::pages::Page;
use crate::web::query::parameters;
use axum::Json;
use axum::extract::{RawQuery, State};
use axum::http::StatusCode;
use serde::{Deserialize, Serialize};
use std::path::Path;
use utoipa::ToSchema;

/// Records that are served unless another number is asked for.
const USUAL: usize = 500;

/// Something that somebody did, or was not allowed to.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub(crate) struct AuditRecord {
    /// When, RFC 3339.
    at: String,
    /// The train.
    train: String,
    /// What kind: `change`, `read`, `login`, `logout`, `refused`, `start`, `stop`, `tls_reload`, `token_reload`.
    event: String,
    /// Name of the token; `local` for the user that runs the train, `anyone` where no tokens are asked for.
    #[serde(default)]
    who: Option<String>,
    /// Their role.
    #[serde(default)]
    role: Option<String>,
    /// Address and port of the client.
    #[serde(default)]
    from: Option<String>,
    /// Method of the request.
    #[serde(default)]
    method: Option<String>,
    /// Path of the request.
    #[serde(default)]
    path: Option<String>,
    /// Status of the answer.
    #[serde(default)]
    status: Option<u16>,
    /// What came of it, in words.
    #[serde(default)]
    result: Option<String>,
    /// Records that could not be written before this one.
    #[serde(default)]
    lost: u64,
}

/// The latest of the audit log, oldest first.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub(crate) struct AuditLog {
    records: Vec<AuditRecord>,
}

/// The latest of what people did whom we know and of what strangers did, by time.
fn latest(log: &Path, limit: usize) -> std::io::Result<Vec<AuditRecord>> {
    let mut records: Vec<AuditRecord> = audit_file::latest(log, limit)?;
    match audit_file::latest(&Shelf::Strangers.file(log), limit) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error),
        strangers => records.extend(strangers.unwrap_or_default()),
    }
    records.sort_by(|a, b| a.at.cmp(&b.at));
    Ok(records.split_off(records.len().saturating_sub(limit)))
}

/// Who did what: changes, logins, refusals, reads of this log; the latest last. For the role `admin`.
#[utoipa::path(get, path = "/api/v1/audit", tag = "service",
    params(("limit" = Option<u32>, Query, minimum = 1, maximum = 1000, description = "At most so many; default 500")),
    responses(
        (status = 200, description = "The latest records", body = AuditLog),
        (status = 400, description = "A query parameter is wrong; the detail names it and what is allowed"),
        (status = 503, description = "The log cannot be read"),
    ))]
pub(crate) async fn records(
    State(access): State<Access>,
    RawQuery(query): RawQuery,
) -> Result<Json<AuditLog>, Problem> {
    let limit = Page::of(&parameters(query.as_deref(), &["limit"])?, USUAL)?.limit;
    let file = access.inner.audit.file().to_owned();
    let refused = |error: &dyn std::fmt::Display| {
        Problem::new(StatusCode::SERVICE_UNAVAILABLE, format!("the audit log cannot be read: {error}"))
    };
    let read = tokio::task::spawn_blocking(move || latest(&file, limit)).await;
    let records = read.map_err(|error| refused(&error))?.map_err(|error| refused(&error))?;
    Ok(Json(AuditLog { records }))
}
