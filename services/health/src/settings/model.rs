//! What the interface says of settings, as types.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// A threshold or another number by which indicators are computed and judged.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Setting {
    /// Dotted key below `[indicators]` in the config file.
    pub key: String,
    /// What it says, with its unit.
    pub words: String,
    /// What holds now.
    pub value: f64,
    /// What the file says for the next start; `null` where it cannot be read.
    pub next: Option<f64>,
    /// What holds where the file is silent.
    pub default: f64,
    /// Least and greatest value.
    pub range: [f64; 2],
}

/// All of them.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct SettingList {
    /// The config file; absent where the built-in config holds.
    pub file: Option<String>,
    /// Whether a start would change something.
    pub waits_for_start: bool,
    /// The settings.
    pub settings: Vec<Setting>,
}

/// A change of one setting.
#[derive(Debug, Clone, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SettingRequest {
    /// Dotted key below `[indicators]`.
    pub key: String,
    /// The new value.
    pub value: f64,
    /// Who. Where the request comes with a token, the token's name stands in its place.
    #[schema(value_type = String, required = true, min_length = 1, max_length = 100, pattern = "line")]
    #[serde(default)]
    pub by: Option<String>,
    /// Why.
    #[schema(min_length = 1, max_length = 500, pattern = "line")]
    pub why: String,
}

/// How a receiver of alerts is reached.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum ReceiverKind {
    /// By HTTP POST.
    Webhook,
    /// By an MQTT broker.
    Mqtt,
}

impl ReceiverKind {
    /// As the config file says it.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Webhook => "webhook",
            Self::Mqtt => "mqtt",
        }
    }
}

/// The least grade of which a receiver is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum LeastGrade {
    /// All alerts.
    Watch,
    /// Only what needs action.
    Act,
}

impl LeastGrade {
    /// As the config file says it.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Watch => "watch",
            Self::Act => "act",
        }
    }
}

/// A receiver of alerts as the config says it. Paths of addresses are not told, because some carry a secret.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct ReceiverSetting {
    /// Its name.
    pub name: String,
    /// How it is reached.
    pub kind: ReceiverKind,
    /// Scheme, host and port.
    pub address: String,
    /// Topic of an MQTT broker; `{train}` and `{id}` are filled in.
    pub topic: Option<String>,
    /// Whether a broker is reached by TLS; `null` for a webhook, whose address says it.
    pub tls: Option<bool>,
    /// File with the authorities of a broker's certificate; `null` where the public ones hold.
    pub ca_file: Option<String>,
    /// The least grade of which it is told.
    pub grade: LeastGrade,
    /// Whether it is sent a secret, from a file or in its address; address and TLS change in the config file only then.
    pub secret: bool,
    /// Whether the running service knows it so.
    pub now: bool,
    /// Whether it is so from the next start on.
    pub next: bool,
}

/// All receivers.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct ReceiverSettingList {
    /// The config file; absent where the built-in config holds.
    pub file: Option<String>,
    /// Whether a start would change something.
    pub waits_for_start: bool,
    /// The receivers of now and of the next start.
    pub receivers: Vec<ReceiverSetting>,
}

/// A change of one receiver: of one that is there, what is given is changed and the rest stays; a new one is added.
#[derive(Debug, Clone, Default, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct ReceiverRequest {
    /// Which one.
    #[schema(min_length = 1, max_length = 64, pattern = "line")]
    pub name: String,
    /// Removes it.
    #[serde(default)]
    pub remove: bool,
    /// How a new one is reached.
    #[serde(default)]
    pub kind: Option<ReceiverKind>,
    /// Where a webhook takes notifications, `http://` or `https://`.
    #[schema(min_length = 1, max_length = 500)]
    #[serde(default)]
    pub url: Option<String>,
    /// Host of a broker.
    #[schema(min_length = 1, max_length = 255)]
    #[serde(default)]
    pub host: Option<String>,
    /// Its port; 1883 if nothing else is said, 8883 by TLS.
    #[schema(maximum = 65535)]
    #[serde(default)]
    pub port: Option<u16>,
    /// Whether it is reached by TLS.
    #[serde(default)]
    pub tls: Option<bool>,
    /// File with the authorities (PEM) of which one must have signed its certificate, beside the config file or with its whole
    /// path; empty for the public ones.
    #[schema(max_length = 500)]
    #[serde(default)]
    pub ca_file: Option<String>,
    /// Its topic.
    #[schema(min_length = 1, max_length = 200)]
    #[serde(default)]
    pub topic: Option<String>,
    /// The least grade of which it is told.
    #[serde(default)]
    pub grade: Option<LeastGrade>,
    /// Who. Where the request comes with a token, the token's name stands in its place.
    #[schema(value_type = String, required = true, min_length = 1, max_length = 100, pattern = "line")]
    #[serde(default)]
    pub by: Option<String>,
    /// Why.
    #[schema(min_length = 1, max_length = 500, pattern = "line")]
    pub why: String,
}
