//! `[delivery]`, in which files of earlier versions name receivers.

use super::mqtt::MqttTable;
use super::webhook::WebhookTable;
use serde::{Deserialize, Serialize};

/// `[delivery]`, the old form of both.
#[derive(Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct DeliveryTable {
    pub(super) webhook: Vec<WebhookTable>,
    pub(super) mqtt: Option<MqttTable>,
    pub(super) longest_pause_s: Option<f64>,
    pub(super) most_waiting: Option<u32>,
}

impl DeliveryTable {
    /// The keys in use, with those that replace them.
    pub(super) fn deprecated(&self) -> Vec<String> {
        let keys = [
            (!self.webhook.is_empty(), "[[delivery.webhook]]", "[[receiver]] with kind = \"webhook\""),
            (self.mqtt.is_some(), "[delivery.mqtt]", "[[receiver]] with kind = \"mqtt\""),
            (self.longest_pause_s.is_some(), "[delivery] longest_pause_s", "[notify] longest_pause_s"),
            (self.most_waiting.is_some(), "[delivery] most_waiting", "[notify] most_waiting"),
        ];
        let used = keys.into_iter().filter(|(used, ..)| *used);
        used.map(|(_, old, new)| format!("`{old}` is deprecated and still read; write `{new}`")).collect()
    }
}
