//! `[[receiver]]` as a file says it.

use super::grade::Least;
use super::mqtt::{self, MqttTable};
use super::webhook::WebhookTable;
use crate::place::ConfigText;
use serde::{Deserialize, Serialize};

/// `[[receiver]]`: the keys of both kinds, so that what is wrong with one is found at its place.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ReceiverTable {
    /// How notifications get there; required.
    kind: ReceiverKind,
    /// Name for people and for the outbox; without it `webhook-N` or `mqtt`.
    name: Option<String>,
    /// webhook: where notifications are posted, http:// or https://; required there.
    url: Option<String>,
    /// webhook: file with a bearer token, read before every attempt.
    token_file: Option<String>,
    /// mqtt: name or address of the broker; required there.
    host: Option<String>,
    /// mqtt: port of the broker; without it 1883, by TLS 8883.
    port: Option<u16>,
    /// mqtt: topic, in which {train} and {id} are replaced; without it `railgrip/{train}/alerts/{id}`.
    topic: Option<String>,
    /// mqtt: name under which the broker knows us; without it `railgrip-TRAIN`.
    client_id: Option<String>,
    /// mqtt: user, where the broker asks for one.
    user: Option<String>,
    /// mqtt: file with the password, read at every connection.
    password_file: Option<String>,
    /// mqtt: the broker is reached by TLS; without it false.
    tls: Option<bool>,
    /// mqtt: who may have signed the broker's certificate (PEM); without it the public authorities.
    ca_file: Option<String>,
    /// mqtt: the broker keeps the last message of a topic for those who come later; without it false.
    retain: Option<bool>,
    /// A secret may travel without TLS beyond this machine.
    #[serde(default)]
    allow_insecure: bool,
    /// The least grade of which is told.
    #[serde(default)]
    grade: Least,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
enum ReceiverKind {
    Webhook,
    Mqtt,
}

/// A receiver in the form of its kind.
pub(super) enum Kept {
    Webhook(WebhookTable),
    Mqtt(MqttTable),
}

impl ReceiverTable {
    /// The keys of its kind; those of the other are noted.
    pub(super) fn of_kind(self, at: &ConfigText<'_>, key: &str) -> Option<Kept> {
        if at.is_blamed(&format!("{key}.kind")) {
            return None;
        }
        let of_webhook = [("url", self.url.is_some()), ("token_file", self.token_file.is_some())];
        let of_mqtt = [
            ("host", self.host.is_some()),
            ("port", self.port.is_some()),
            ("topic", self.topic.is_some()),
            ("client_id", self.client_id.is_some()),
            ("user", self.user.is_some()),
            ("password_file", self.password_file.is_some()),
            ("tls", self.tls.is_some()),
            ("ca_file", self.ca_file.is_some()),
            ("retain", self.retain.is_some()),
        ];
        let webhook = self.kind == ReceiverKind::Webhook;
        let (needed, others): (_, &[(&str, bool)]) =
            if webhook { (("url", self.url), &of_mqtt) } else { (("host", self.host), &of_webhook) };
        for (name, _) in others.iter().filter(|(_, given)| *given) {
            let allowed = format!("nothing here for kind = \"{}\"", if webhook { "webhook" } else { "mqtt" });
            at.note(at.refuse(&format!("{key}.{name}"), "given", allowed));
        }
        let (name, needed) = needed;
        let Some(needed) = needed else {
            let allowed =
                if webhook { "http://HOST... or https://HOST..." } else { "a host name or address" };
            at.note(at.refuse(&format!("{key}.{name}"), "absent", allowed));
            return None;
        };
        let (allow_insecure, grade) = (self.allow_insecure, self.grade);
        Some(match self.kind {
            ReceiverKind::Webhook => Kept::Webhook(WebhookTable {
                name: self.name,
                url: needed,
                token_file: self.token_file,
                allow_insecure,
                grade,
            }),
            ReceiverKind::Mqtt => Kept::Mqtt(MqttTable {
                name: self.name,
                host: needed,
                port: self.port,
                topic: self.topic.unwrap_or_else(mqtt::topic),
                client_id: self.client_id,
                user: self.user,
                password_file: self.password_file,
                tls: self.tls.unwrap_or_default(),
                ca_file: self.ca_file,
                retain: self.retain.unwrap_or_default(),
                allow_insecure,
                grade,
            }),
        })
    }
}
