//! Requests about notes: look, write one down.

use super::Whose;
use super::model::{Note, NoteList, NoteRequest};
use crate::access::Identity;
use crate::api::problem::Problem;
use crate::history::routes::wagon;
use crate::shared::Shared;
use crate::time::rfc3339;
use axum::body::Bytes;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::{Extension, Json};

/// Longest name and longest note, characters.
const MOST_NAME: usize = 100;
const MOST_TEXT: usize = 500;

/// What people wrote down about a vehicle.
#[utoipa::path(get, path = "/api/v1/wagons/{id}/notes", tag = "wagons",
    params(("id" = u32, Path, minimum = 1, description = "Number of the wagon, 1 first")),
    responses(
        (status = 200, description = "The latest notes, the newest first", body = NoteList),
        (status = 404, description = "There is no such wagon"),
    ))]
pub(crate) async fn notes(
    State(shared): State<Shared>,
    Path(id): Path<String>,
) -> Result<Json<NoteList>, Problem> {
    let wagon = wagon(&shared, &id)?;
    Ok(Json(list(&shared, wagon)))
}

fn list(shared: &Shared, wagon: u32) -> NoteList {
    let whose = whose(shared, wagon);
    let book = shared.notes();
    NoteList {
        wagon,
        pads_changed_at: book.pads_changed(&whose),
        notes: book.of(&whose),
        vehicle: whose.vehicle,
    }
}

/// What the vehicle that runs at this place is remembered by: its number, or its name where it has none.
pub(crate) fn whose(shared: &Shared, wagon: u32) -> Whose {
    if let Some(known) = shared.limits().remembered(wagon) {
        return known.clone();
    }
    let snapshot = shared.latest();
    let row = snapshot.wagons.iter().find(|row| row.id == wagon);
    Whose { vehicle: row.map(|row| row.name.clone()).unwrap_or_default(), start: None }
}

/// Writes a note down. `pads_changed` lets the trends of pad friction begin anew.
#[utoipa::path(post, path = "/api/v1/wagons/{id}/notes", tag = "wagons",
    params(("id" = u32, Path, minimum = 1, description = "Number of the wagon, 1 first")),
    request_body = NoteRequest,
    responses(
        (status = 200, description = "The notes now", body = NoteList),
        (status = 400, description = "The body is no JSON"),
        (status = 404, description = "There is no such wagon"),
        (status = 413, description = "The body is too large"),
        (status = 415, description = "The body is not application/json"),
        (status = 422, description = "The body lacks something, or a value in it is not allowed"),
        (status = 503, description = "The disk refuses; nothing was written"),
    ))]
pub(crate) async fn add_note(
    State(shared): State<Shared>,
    Path(id): Path<String>,
    identity: Option<Extension<Identity>>,
    body: Bytes,
) -> Result<Json<NoteList>, Problem> {
    let wagon = wagon(&shared, &id)?;
    let request: NoteRequest = serde_json::from_slice(&body).map_err(|error| {
        let status = if error.is_data() { StatusCode::UNPROCESSABLE_ENTITY } else { StatusCode::BAD_REQUEST };
        Problem::new(status, format!("the body is not the JSON that is expected: {error}"))
    })?;
    let Whose { vehicle, start } = whose(&shared, wagon);
    let note = Note {
        vehicle,
        at: rfc3339(shared.now().unix_ns),
        by: by(&request, identity.as_ref().map(|Extension(identity)| identity))?,
        kind: request.kind,
        text: Some(sane("text", &request.text, MOST_TEXT)?),
    };
    let writer = shared.clone();
    let written = tokio::task::spawn_blocking(move || writer.notes().add(note, start)).await;
    let refused = |detail: String| Problem::new(StatusCode::SERVICE_UNAVAILABLE, detail);
    written
        .map_err(|error| refused(error.to_string()))?
        .map_err(|error| refused(format!("the note was not written: {error}")))?;
    Ok(Json(list(&shared, wagon)))
}

/// Who: whoever shows a token is called as it is first, so that nobody writes in another's name.
fn by(request: &NoteRequest, identity: Option<&Identity>) -> Result<String, Problem> {
    let said = request.by.as_deref();
    let said = match identity.and_then(Identity::vouched_name) {
        Some(_) if said.is_none_or(|said| said.trim().is_empty()) => None,
        _ => Some(sane("by", said.unwrap_or_default(), MOST_NAME)?),
    };
    let signed = identity.and_then(|identity| identity.signature(said.as_deref()));
    Ok(signed.or(said).unwrap_or_default())
}

fn sane(key: &str, text: &str, most: usize) -> Result<String, Problem> {
    let text = text.trim();
    let plain = !text.chars().any(|c| c.is_control() && c != '\n');
    if (1..=most).contains(&text.chars().count()) && plain {
        return Ok(text.to_owned());
    }
    let detail = format!("`{key}` must be a text of 1 to {most} characters");
    Err(Problem::new(StatusCode::UNPROCESSABLE_ENTITY, detail))
}
