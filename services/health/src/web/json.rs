//! JSON of what is served.

use axum::body::Bytes;
use serde::Serialize;

/// JSON of a view; views hold nothing that cannot be JSON.
pub(crate) fn json(view: &impl Serialize) -> Bytes {
    serde_json::to_vec(view).unwrap_or_default().into()
}
