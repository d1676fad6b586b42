//! `[alerts]`, `[delivery]` and `[capability]`: when people are told, by which way, and what full braking is.

use crate::SettingsError;
use crate::place::ConfigText;
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// When an alert is raised, grouped and cleared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlertSettings {
    /// A cause must last so many seconds before an alert is raised.
    pub raise_after_s: f64,
    /// A cause must be gone for so many seconds before its alert is cleared; doubled each time it comes back.
    pub clear_after_s: f64,
    /// A cause that comes back within so many seconds is the same alert.
    pub reopen_within_s: f64,
    /// One alert for the train when this share of its wagons has the cause, 0 to 1.
    pub group_share: f64,
    /// And at least so many wagons.
    pub group_least: u32,
}

impl Default for AlertSettings {
    fn default() -> Self {
        Self {
            raise_after_s: 2.0,
            clear_after_s: 10.0,
            reopen_within_s: 600.0,
            group_share: 0.5,
            group_least: 3,
        }
    }
}

/// How people are told.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DeliverySettings {
    /// HTTP receivers.
    pub webhooks: Vec<WebhookSettings>,
    /// A broker.
    pub mqtt: Option<MqttSettings>,
    /// Longest pause between two attempts, s.
    pub longest_pause_s: f64,
    /// Messages that wait for one receiver at most; beyond, the oldest are dropped and counted.
    pub most_waiting: u32,
}

/// An HTTP receiver of alerts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WebhookSettings {
    /// Name for people and for the outbox.
    pub name: String,
    /// Where alerts are posted, `http://` or `https://`.
    pub url: String,
    /// File with a bearer token, read before every attempt.
    pub token_file: Option<PathBuf>,
    /// True if only alerts that need action are sent.
    pub act_only: bool,
}

/// An MQTT broker.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MqttSettings {
    /// Its host.
    pub host: String,
    /// Its port.
    pub port: u16,
    /// Topic; `{train}` stands for the train's name, `{id}` for the alert's number.
    pub topic: String,
    /// Identifier of this client.
    pub client_id: String,
    /// User, if the broker asks for one.
    pub user: Option<String>,
    /// File with the user's password.
    pub password_file: Option<PathBuf>,
    /// Whether the broker keeps the last message of a topic for those who come later.
    pub retain: bool,
    /// True if only alerts that need action are sent.
    pub act_only: bool,
}

/// What full braking of this train is, for the braking capability.
#[derive(Debug, Clone, PartialEq)]
pub struct CapabilitySettings {
    /// Deceleration that full braking would give with nominal pads on good rail, m/s².
    pub full_deceleration_m_s2: f64,
    /// From the driver's action until the brakes act in full, as a dead time, s.
    pub response_s: f64,
    /// Speeds for which stopping distances are given, km/h.
    pub speeds_km_h: Vec<f64>,
    /// Length of a cell of the adhesion map, m.
    pub cell_m: f64,
    /// What a cell of the map knows fades to nothing in about this time, s.
    pub map_memory_s: f64,
    /// The map is handed to the history so often, s.
    pub map_save_s: f64,
    /// Most cells that are kept.
    pub most_cells: u32,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct AlertTable {
    raise_after_s: f64,
    clear_after_s: f64,
    reopen_within_s: f64,
    group_share: f64,
    group_least: u32,
    journal: Option<String>,
}

impl Default for AlertTable {
    fn default() -> Self {
        let settings = AlertSettings::default();
        Self {
            raise_after_s: settings.raise_after_s,
            clear_after_s: settings.clear_after_s,
            reopen_within_s: settings.reopen_within_s,
            group_share: settings.group_share,
            group_least: settings.group_least,
            journal: None,
        }
    }
}

impl AlertTable {
    pub(crate) fn check(&self, at: &ConfigText<'_>) -> Result<AlertSettings, SettingsError> {
        at.within("alerts.group_least", f64::from(self.group_least), 2.0..=1000.0)?;
        Ok(AlertSettings {
            raise_after_s: at.within("alerts.raise_after_s", self.raise_after_s, 0.0..=3600.0)?,
            clear_after_s: at.within("alerts.clear_after_s", self.clear_after_s, 0.0..=3600.0)?,
            reopen_within_s: at.within("alerts.reopen_within_s", self.reopen_within_s, 0.0..=86_400.0)?,
            group_share: at.within("alerts.group_share", self.group_share, 0.05..=1.0)?,
            group_least: self.group_least,
        })
    }

    /// Where alerts and their outbox are kept: as given, relative to the config, else in the folder of the history.
    pub(crate) fn journal(&self, at: &ConfigText<'_>, history_dir: &Path) -> PathBuf {
        match &self.journal {
            Some(given) => beside(at, given),
            None => history_dir.join("alerts.db"),
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct DeliveryTable {
    webhook: Vec<WebhookTable>,
    mqtt: Option<MqttTable>,
    longest_pause_s: f64,
    most_waiting: u32,
}

impl Default for DeliveryTable {
    fn default() -> Self {
        Self { webhook: Vec::new(), mqtt: None, longest_pause_s: 300.0, most_waiting: 10_000 }
    }
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Least {
    #[default]
    Watch,
    Act,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct WebhookTable {
    name: Option<String>,
    url: String,
    token_file: Option<String>,
    #[serde(default)]
    grade: Least,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MqttTable {
    host: String,
    #[serde(default = "mqtt_port")]
    port: u16,
    #[serde(default = "mqtt_topic")]
    topic: String,
    client_id: Option<String>,
    user: Option<String>,
    password_file: Option<String>,
    #[serde(default)]
    retain: bool,
    #[serde(default)]
    grade: Least,
}

fn mqtt_port() -> u16 {
    1883
}

fn mqtt_topic() -> String {
    "railgrip/{train}/alerts/{id}".to_owned()
}

impl DeliveryTable {
    pub(crate) fn check(self, at: &ConfigText<'_>, train: &str) -> Result<DeliverySettings, SettingsError> {
        let mut webhooks: Vec<WebhookSettings> = Vec::new();
        for (index, table) in self.webhook.into_iter().enumerate() {
            let key = |name: &str| format!("delivery.webhook.{}.{name}", index + 1);
            let host = table.url.strip_prefix("http://").or_else(|| table.url.strip_prefix("https://"));
            if host.is_none_or(|host| host.is_empty() || host.contains(char::is_whitespace)) {
                return Err(at.refuse(&key("url"), &table.url, "http://HOST... or https://HOST..."));
            }
            let name = table.name.unwrap_or_else(|| format!("webhook-{}", index + 1));
            if name.is_empty() || name == "mqtt" || webhooks.iter().any(|other| other.name == name) {
                return Err(at.refuse(&key("name"), name, "a name of its own, not `mqtt`"));
            }
            let token_file = table.token_file.map(|file| beside(at, &file));
            let act_only = table.grade == Least::Act;
            webhooks.push(WebhookSettings { name, url: table.url, token_file, act_only });
        }
        at.within("delivery.most_waiting", f64::from(self.most_waiting), 10.0..=1e6)?;
        Ok(DeliverySettings {
            webhooks,
            mqtt: self.mqtt.map(|table| table.check(at, train)).transpose()?,
            longest_pause_s: at.within("delivery.longest_pause_s", self.longest_pause_s, 1.0..=86_400.0)?,
            most_waiting: self.most_waiting,
        })
    }
}

impl MqttTable {
    fn check(self, at: &ConfigText<'_>, train: &str) -> Result<MqttSettings, SettingsError> {
        if self.host.is_empty() || self.host.contains(['/', ' ']) {
            return Err(at.refuse(
                "delivery.mqtt.host",
                format!("{:?}", self.host),
                "a host name or address",
            ));
        }
        if self.port == 0 {
            return Err(at.refuse("delivery.mqtt.port", 0, "1 to 65535"));
        }
        if self.topic.is_empty() || self.topic.contains(['+', '#', '\0']) {
            let allowed = "a topic without wildcards; {train} and {id} are replaced";
            return Err(at.refuse("delivery.mqtt.topic", format!("{:?}", self.topic), allowed));
        }
        if self.user.is_none() && self.password_file.is_some() {
            return Err(at.refuse("delivery.mqtt.user", "absent", "a user for the password"));
        }
        Ok(MqttSettings {
            host: self.host,
            port: self.port,
            topic: self.topic,
            client_id: self.client_id.unwrap_or_else(|| format!("railgrip-{train}")),
            user: self.user,
            password_file: self.password_file.map(|file| beside(at, &file)),
            retain: self.retain,
            act_only: self.grade == Least::Act,
        })
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct CapabilityTable {
    full_deceleration_m_s2: f64,
    response_s: f64,
    speeds_km_h: Vec<f64>,
    cell_m: f64,
    map_memory_s: f64,
    map_save_s: f64,
    most_cells: u32,
}

impl Default for CapabilityTable {
    fn default() -> Self {
        Self {
            full_deceleration_m_s2: 1.1,
            response_s: 2.0,
            speeds_km_h: vec![40.0, 80.0, 120.0, 160.0],
            cell_m: 50.0,
            map_memory_s: 1800.0,
            map_save_s: 30.0,
            most_cells: 4000,
        }
    }
}

impl CapabilityTable {
    pub(crate) fn check(self, at: &ConfigText<'_>) -> Result<CapabilitySettings, SettingsError> {
        let key = "capability.speeds_km_h";
        if !(1..=20).contains(&self.speeds_km_h.len()) {
            return Err(at.refuse(key, format!("{} speeds", self.speeds_km_h.len()), "1 to 20 speeds"));
        }
        for speed in &self.speeds_km_h {
            at.within(key, *speed, 1.0..=500.0)?;
        }
        at.within("capability.most_cells", f64::from(self.most_cells), 10.0..=100_000.0)?;
        Ok(CapabilitySettings {
            full_deceleration_m_s2: at.within(
                "capability.full_deceleration_m_s2",
                self.full_deceleration_m_s2,
                0.1..=5.0,
            )?,
            response_s: at.within("capability.response_s", self.response_s, 0.0..=60.0)?,
            speeds_km_h: self.speeds_km_h,
            cell_m: at.within("capability.cell_m", self.cell_m, 5.0..=1000.0)?,
            map_memory_s: at.within("capability.map_memory_s", self.map_memory_s, 10.0..=1e7)?,
            map_save_s: at.within("capability.map_save_s", self.map_save_s, 0.5..=3600.0)?,
            most_cells: self.most_cells,
        })
    }
}

fn beside(at: &ConfigText<'_>, path: &str) -> PathBuf {
    at.file.parent().unwrap_or(Path::new("")).join(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn delivery(text: &str) -> Result<DeliverySettings, SettingsError> {
        let at = ConfigText { file: Path::new("dir/x.toml"), text };
        #[derive(Deserialize)]
        struct Form {
            delivery: DeliveryTable,
        }
        at.parse::<Form>()?.delivery.check(&at, "demo")
    }

    #[test]
    fn receivers_are_read_and_wrong_ones_named() {
        let read = delivery(
            "[[delivery.webhook]]\nurl = \"http://depot:9/a\"\ntoken_file = \"t\"\ngrade = \"act\"\n[delivery.mqtt]\nhost = \"broker\"\n",
        )
        .unwrap();
        assert_eq!((read.webhooks[0].name.as_str(), read.webhooks[0].act_only), ("webhook-1", true));
        assert_eq!(read.webhooks[0].token_file.as_deref(), Some(Path::new("dir/t")));
        let mqtt = read.mqtt.unwrap();
        assert_eq!((mqtt.port, mqtt.client_id.as_str(), mqtt.act_only), (1883, "railgrip-demo", false));
        for (text, said) in [
            ("[[delivery.webhook]]\nurl = \"depot\"\n", "delivery.webhook.1.url"),
            ("[delivery.mqtt]\nhost = \"b\"\ntopic = \"a/#\"\n", "delivery.mqtt.topic"),
            ("[delivery.mqtt]\nhost = \"b\"\npassword_file = \"p\"\n", "delivery.mqtt.user"),
            ("[delivery]\nlongest_pause_s = 0.0\n", "delivery.longest_pause_s"),
        ] {
            let error = delivery(text).unwrap_err().to_string();
            println!("{error}");
            assert!(error.contains(said), "{error}");
        }
    }
}
