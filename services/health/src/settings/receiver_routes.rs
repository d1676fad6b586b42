//! Requests about the receivers of the config file: look, add, change, remove.

use super::asked;
use super::model::{LeastGrade, ReceiverKind, ReceiverRequest, ReceiverSetting, ReceiverSettingList};
use super::receivers::change_receiver;
use crate::access::Identity;
use crate::api::problem::Problem;
use crate::shared::Shared;
use axum::body::Bytes;
use axum::extract::State;
use axum::{Extension, Json};
use railgrip_settings::{Overrides, ReceiverSettings, ReceiverWay, TrainSettings};

/// Receivers of alerts as the running service knows them, and as the config file names them for the next start. Paths of
/// addresses are not told, because some carry a secret.
#[utoipa::path(get, path = "/api/v1/settings/receivers", tag = "service", operation_id = "receiver_settings",
    responses((status = 200, description = "The receivers of now and of the next start", body = ReceiverSettingList)))]
pub(crate) async fn receivers(State(shared): State<Shared>) -> Json<ReceiverSettingList> {
    Json(list(&shared))
}

/// What holds, and what the file says.
pub(crate) fn list(shared: &Shared) -> ReceiverSettingList {
    let limits = shared.limits();
    let file = limits.file.as_deref();
    let of_file = file.and_then(|file| TrainSettings::load(Some(file), &Overrides::default()).ok());
    let now = limits.receivers.as_slice();
    let next = of_file.as_ref().map_or(now, |settings| settings.notify.receivers.as_slice());
    let mut receivers: Vec<ReceiverSetting> =
        next.iter().map(|one| view(one, now.contains(one), true)).collect();
    // One that is changed shows as it will be; one that is removed, as it is.
    let removed = now.iter().filter(|one| next.iter().all(|other| other.name != one.name));
    receivers.extend(removed.map(|one| view(one, true, false)));
    ReceiverSettingList {
        file: file.map(|file| file.display().to_string()),
        waits_for_start: receivers.iter().any(|one| !(one.now && one.next)),
        receivers,
    }
}

fn view(one: &ReceiverSettings, now: bool, next: bool) -> ReceiverSetting {
    let grade = if one.act_only { LeastGrade::Act } else { LeastGrade::Watch };
    let name = one.name.clone();
    match &one.way {
        ReceiverWay::Webhook(way) => ReceiverSetting {
            name,
            kind: ReceiverKind::Webhook,
            address: host_of(&way.url),
            topic: None,
            tls: None,
            ca_file: None,
            grade,
            secret: way.carries_secret(),
            now,
            next,
        },
        ReceiverWay::Mqtt(way) => ReceiverSetting {
            name,
            kind: ReceiverKind::Mqtt,
            address: format!("{}:{}", way.host, way.port),
            topic: Some(way.topic.clone()),
            tls: Some(way.tls.is_some()),
            ca_file: way
                .tls
                .as_ref()
                .and_then(|tls| tls.ca_file.as_ref())
                .map(|file| file.display().to_string()),
            grade,
            secret: way.password_file.is_some(),
            now,
            next,
        },
    }
}

/// Scheme, host and port of a URL, without user, path and query.
fn host_of(url: &str) -> String {
    let (scheme, rest) = url.split_once("://").unwrap_or(("", url));
    let authority = rest.split(['/', '?', '#']).next().unwrap_or_default();
    let host = authority.rsplit_once('@').map_or(authority, |(_, host)| host);
    format!("{scheme}://{host}")
}

/// Adds, changes or removes a receiver in the config file: checked as the whole file is at a start, written at once with a
/// comment that says who, when and why. It takes effect when the service starts again, or reads its config again (SIGHUP).
#[utoipa::path(post, path = "/api/v1/settings/receivers", tag = "service", operation_id = "change_receiver",
    request_body = ReceiverRequest,
    responses(
        (status = 200, description = "The receivers now", body = ReceiverSettingList),
        (status = 400, description = "The body is no JSON"),
        (status = 404, description = "There is no such receiver to remove"),
        (status = 409, description = "There is no config file, or its check refuses what is said of the receiver"),
        (status = 413, description = "The body is too large"),
        (status = 415, description = "The body is not application/json"),
        (status = 422, description = "The body lacks something, or a value in it is not allowed"),
        (status = 503, description = "The file cannot be written; nothing was changed"),
    ))]
pub(crate) async fn change(
    State(shared): State<Shared>,
    identity: Option<Extension<Identity>>,
    body: Bytes,
) -> Result<Json<ReceiverSettingList>, Problem> {
    let mut request: ReceiverRequest = asked::parse(&body)?;
    request.name = asked::line("name", &request.name, 64)?;
    let signed = asked::signed(&shared, identity.as_deref(), request.by.as_deref(), &request.why)?;
    asked::in_turn(&shared, move |file| {
        change_receiver(file, &request, &signed)?;
        tracing::info!("{}: receiver {} changed {signed}", file.display(), request.name);
        Ok(())
    })
    .await?;
    Ok(Json(list(&shared)))
}

#[cfg(test)]
mod tests {
    #[test]
    fn no_path_and_no_user_of_an_address_is_told() {
        for (url, told) in [
            ("https://hooks.example/T0/secret", "https://hooks.example"),
            ("http://kim:word@depot:9?token=x", "http://depot:9"),
            ("https://[::1]:9/a", "https://[::1]:9"),
        ] {
            assert_eq!(super::host_of(url), told);
        }
    }
}
