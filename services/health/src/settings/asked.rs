//! What all requests that change the config file have in common: who signs, and that they come one after the other.

use super::file::ChangeError;
use crate::access::Identity;
use crate::api::problem::Problem;
use crate::shared::Shared;
use crate::time::rfc3339;
use axum::http::StatusCode;
use serde::de::DeserializeOwned;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// Changes come one after the other: each reads the file that the one before it wrote.
static CHANGING: Mutex<()> = Mutex::new(());

impl From<ChangeError> for Problem {
    fn from(error: ChangeError) -> Self {
        let status = match error {
            ChangeError::Unknown(_) | ChangeError::NoReceiver(_) => StatusCode::NOT_FOUND,
            // Each value may be right by itself: what is wrong is what they say together.
            ChangeError::Refused(_) | ChangeError::Form(_) => StatusCode::CONFLICT,
            ChangeError::Disk(_) => StatusCode::SERVICE_UNAVAILABLE,
        };
        Self::new(status, error.to_string())
    }
}

/// The body as a request.
pub(super) fn parse<T: DeserializeOwned>(body: &[u8]) -> Result<T, Problem> {
    serde_json::from_slice(body).map_err(|error| {
        let status = if error.is_data() { StatusCode::UNPROCESSABLE_ENTITY } else { StatusCode::BAD_REQUEST };
        Problem::new(status, format!("the body is not the JSON that is expected: {error}"))
    })
}

/// `by NAME at TIME: WHY`, where a token vouches for the name if there is one.
pub(super) fn signed(
    shared: &Shared,
    identity: Option<&Identity>,
    by: Option<&str>,
    why: &str,
) -> Result<String, Problem> {
    let signature = identity.and_then(|identity| identity.signature(by));
    let by = signature.as_deref().or(by).unwrap_or_default();
    let (by, why) = (line("by", by, 200)?, line("why", why, 500)?);
    Ok(format!("by {by} at {}: {why}", rfc3339(shared.now().unix_ns)))
}

/// Has `change` edit the config file while nobody else does.
pub(super) async fn in_turn(
    shared: &Shared,
    change: impl FnOnce(&Path) -> Result<(), ChangeError> + Send + 'static,
) -> Result<(), Problem> {
    let no_file = || Problem::new(StatusCode::CONFLICT, "there is no config file: the built-in config holds");
    let file = shared.limits().file.clone().filter(|file| file.is_file()).ok_or_else(no_file)?;
    let changed = tokio::task::spawn_blocking(move || {
        let _turn = CHANGING.lock().unwrap_or_else(PoisonError::into_inner);
        change(&file)
    });
    let failed = |detail: String| Problem::new(StatusCode::INTERNAL_SERVER_ERROR, detail);
    Ok(changed.await.map_err(|error| failed(error.to_string()))??)
}

/// One line of text: a comment must not end before its end.
pub(super) fn line(key: &str, text: &str, most: usize) -> Result<String, Problem> {
    let text = text.trim();
    if (1..=most).contains(&text.chars().count()) && !text.chars().any(char::is_control) {
        return Ok(text.to_owned());
    }
    let detail = format!("`{key}` must be one line of 1 to {most} characters");
    Err(Problem::new(StatusCode::UNPROCESSABLE_ENTITY, detail))
}
