//! Requests about settings: look, change one.

use super::asked;
use super::change::change;
use super::file::CHANGED;
use super::model::{Setting, SettingList, SettingRequest};
use crate::access::Identity;
use crate::api::problem::Problem;
use crate::shared::Shared;
use axum::body::Bytes;
use axum::extract::State;
use axum::{Extension, Json};
use railgrip_indicators::IndicatorSettings;
use railgrip_settings::{Overrides, TrainSettings};
use std::path::Path;

/// The numbers by which indicators are computed and judged.
#[utoipa::path(get, path = "/api/v1/settings", tag = "service",
    responses((status = 200, description = "What holds, and what the file says for the next start", body = SettingList)))]
pub(crate) async fn settings(State(shared): State<Shared>) -> Json<SettingList> {
    Json(list(&shared))
}

/// What holds, and what the file says.
pub(crate) fn list(shared: &Shared) -> SettingList {
    let limits = shared.limits();
    let next = limits.file.as_deref().and_then(of_file);
    let next = next.map(|settings| settings.entries());
    let setting = |entry: railgrip_indicators::SettingEntry| Setting {
        next: next
            .as_ref()
            .and_then(|next| next.iter().find(|other| other.key == entry.key))
            .map(|n| n.value),
        key: entry.key,
        words: entry.words.to_owned(),
        value: entry.value,
        default: entry.default,
        range: entry.range,
    };
    let settings: Vec<Setting> = limits.settings.entries().into_iter().map(setting).collect();
    let waits_for_start = settings.iter().any(|s| s.next.is_some_and(|next| next != s.value));
    let file = limits.file.as_ref().map(|file| file.display().to_string());
    SettingList { file, waits_for_start, settings }
}

/// The settings that a file holds; nothing where it is refused.
fn of_file(file: &Path) -> Option<IndicatorSettings> {
    TrainSettings::load(Some(file), &Overrides::default()).ok().map(|settings| settings.indicators)
}

/// Changes a setting in the config file: checked as the whole file is at a start, written at once with a comment that says
/// who, when and why. It takes effect when the processes start again, or read their config again (SIGHUP).
#[utoipa::path(post, path = "/api/v1/settings", tag = "service",
    request_body = SettingRequest,
    responses(
        (status = 200, description = "The settings now", body = SettingList),
        (status = 400, description = "The body is no JSON"),
        (status = 404, description = "There is no such setting"),
        (status = 409, description = "There is no config file, or its check refuses the value"),
        (status = 413, description = "The body is too large"),
        (status = 415, description = "The body is not application/json"),
        (status = 422, description = "The body lacks something, or a value in it is not allowed"),
        (status = 503, description = "The file cannot be written; nothing was changed"),
    ))]
pub(crate) async fn change_setting(
    State(shared): State<Shared>,
    identity: Option<Extension<Identity>>,
    body: Bytes,
) -> Result<Json<SettingList>, Problem> {
    let request: SettingRequest = asked::parse(&body)?;
    let signed = asked::signed(&shared, identity.as_deref(), request.by.as_deref(), &request.why)?;
    asked::in_turn(&shared, move |file| {
        let before = of_file(file).unwrap_or_default().entries();
        let before = before.into_iter().find(|entry| entry.key == request.key).map_or(f64::NAN, |e| e.value);
        let note = format!("{CHANGED}{before} {signed}");
        change(file, &request.key, request.value, &note)?;
        tracing::info!("{}: {} is {}, {note}", file.display(), request.key, request.value);
        Ok(())
    })
    .await?;
    Ok(Json(list(&shared)))
}
