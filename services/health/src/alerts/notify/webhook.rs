//! Notifications by HTTP POST.

use super::notifier::{ANSWER, Notifier, Outcome};
use crate::alerts::nflog::Queued;
use railgrip_settings::WebhookSettings;
use ureq::Agent;

/// The way to one HTTP receiver.
pub(super) struct Webhook {
    settings: WebhookSettings,
    agent: Agent,
}

impl Webhook {
    pub fn new(settings: WebhookSettings) -> Self {
        let config = Agent::config_builder()
            .timeout_global(Some(ANSWER))
            .http_status_as_error(false)
            .max_redirects(0)
            .user_agent(concat!("railgrip/", env!("CARGO_PKG_VERSION")));
        Self { settings, agent: config.build().into() }
    }
}

impl Notifier for Webhook {
    fn notify(&mut self, notification: &Queued) -> Outcome {
        let mut request = self
            .agent
            .post(&self.settings.url)
            .header("content-type", "application/json")
            .header("idempotency-key", &notification.key);
        if let Some(file) = &self.settings.token_file {
            match std::fs::read_to_string(file) {
                Ok(token) => request = request.header("authorization", format!("Bearer {}", token.trim())),
                Err(error) => return Outcome::Later(format!("{}: {error}", file.display())),
            }
        }
        match request.send(notification.body.as_str()) {
            Ok(response) => judge(response.status().as_u16()),
            Err(error) => Outcome::Later(error.to_string()),
        }
    }
}

/// What a status means: what may pass by itself is tried again for ever, what is wrong with the notification only a few times.
fn judge(status: u16) -> Outcome {
    let said = format!("the receiver answered with status {status}");
    match status {
        200..=299 => Outcome::Confirmed,
        400 | 405 | 406 | 409..=411 | 413..=422 => Outcome::Refused(said),
        _ => Outcome::Later(said),
    }
}
