//! `[[receiver]]` and `[notify]`: who is notified of alerts, and by which way.
//!
//! Files of earlier versions say `[[delivery.webhook]]`, `[delivery.mqtt]` and `[delivery]` instead. They are read into the
//! same form, checked in the same place, and named in [`NotifySettings::deprecated`].

use crate::SettingsError;
use crate::access::is_loopback;
use crate::place::ConfigText;
use serde::Deserialize;
use std::path::PathBuf;

/// Who is notified of alerts, and how patiently.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct NotifySettings {
    /// Those who are notified.
    pub receivers: Vec<ReceiverSettings>,
    /// Longest pause between two attempts, s.
    pub longest_pause_s: f64,
    /// Notifications that wait for one receiver at most; beyond, the oldest are dropped and counted.
    pub most_waiting: u32,
    /// Old keys of the file, with those that replace them, for a warning.
    pub deprecated: Vec<String>,
}

/// One who is notified.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ReceiverSettings {
    /// Name for people and for the outbox.
    pub name: String,
    /// True if only alerts that need action are sent.
    pub act_only: bool,
    /// How notifications get there.
    pub way: ReceiverWay,
}

/// How notifications get to a receiver.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ReceiverWay {
    /// By HTTP POST.
    Webhook(WebhookSettings),
    /// By an MQTT broker.
    Mqtt(MqttSettings),
}

/// An HTTP receiver of alerts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WebhookSettings {
    /// Where notifications are posted, `http://` or `https://`.
    pub url: String,
    /// File with a bearer token, read before every attempt.
    pub token_file: Option<PathBuf>,
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
}

/// `[notify]`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct NotifyTable {
    longest_pause_s: f64,
    most_waiting: u32,
}

impl Default for NotifyTable {
    fn default() -> Self {
        Self { longest_pause_s: 300.0, most_waiting: 10_000 }
    }
}

/// `[[receiver]]`.
#[derive(Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "lowercase")]
pub(crate) enum ReceiverTable {
    Webhook(WebhookTable),
    Mqtt(MqttTable),
}

/// `[delivery]`, the old form of both.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct DeliveryTable {
    webhook: Vec<WebhookTable>,
    mqtt: Option<MqttTable>,
    longest_pause_s: Option<f64>,
    most_waiting: Option<u32>,
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
pub(crate) struct WebhookTable {
    name: Option<String>,
    url: String,
    token_file: Option<String>,
    #[serde(default)]
    allow_insecure: bool,
    #[serde(default)]
    grade: Least,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MqttTable {
    name: Option<String>,
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
    allow_insecure: bool,
    #[serde(default)]
    grade: Least,
}

/// Why a secret is refused.
pub(crate) const IN_THE_CLEAR: &str = "nothing without TLS beyond this machine, because it would travel in the clear: https://, a broker on this machine that \
     bridges by TLS, or allow_insecure = true where the network is trusted";

/// Host and port of what follows the scheme of a URL.
fn authority(rest: &str) -> &str {
    let authority = rest.split(['/', '?', '#']).next().unwrap_or_default();
    let host = authority.rsplit_once('@').map_or(authority, |(_, host)| host);
    match host.strip_prefix('[') {
        Some(bracketed) => bracketed.split(']').next().unwrap_or_default(),
        None => host.split(':').next().unwrap_or_default(),
    }
}

/// True for names and addresses of loopback.
pub(crate) fn is_this_machine(host: &str) -> bool {
    host.eq_ignore_ascii_case("localhost") || host.parse().is_ok_and(is_loopback)
}

fn mqtt_port() -> u16 {
    1883
}

fn mqtt_topic() -> String {
    "railgrip/{train}/alerts/{id}".to_owned()
}

/// What a file says about receivers, in its new form and in its old one.
pub(crate) struct ReceiverTables {
    pub receiver: Vec<ReceiverTable>,
    pub notify: NotifyTable,
    pub delivery: DeliveryTable,
}

impl ReceiverTables {
    pub(crate) fn check(self, at: &ConfigText<'_>, train: &str) -> Result<NotifySettings, SettingsError> {
        let deprecated = self.delivery.deprecated();
        let (longest_key, longest_pause_s) = match self.delivery.longest_pause_s {
            Some(old) => ("delivery.longest_pause_s", old),
            None => ("notify.longest_pause_s", self.notify.longest_pause_s),
        };
        let (most_key, most_waiting) = match self.delivery.most_waiting {
            Some(old) => ("delivery.most_waiting", old),
            None => ("notify.most_waiting", self.notify.most_waiting),
        };
        at.within(most_key, f64::from(most_waiting), 10.0..=1e6)?;
        at.within(longest_key, longest_pause_s, 1.0..=86_400.0)?;
        let mut receivers: Vec<ReceiverSettings> = Vec::new();
        for (key, table) in keyed(self.receiver, self.delivery) {
            let of = |way: fn(&ReceiverWay) -> bool| receivers.iter().filter(|one| way(&one.way)).count();
            let receiver = match table {
                ReceiverTable::Webhook(table) => {
                    let number = of(|way| matches!(way, ReceiverWay::Webhook(_))) + 1;
                    table.check(at, &key, number)?
                }
                ReceiverTable::Mqtt(table) => table.check(at, &key, train)?,
            };
            if receiver.name.is_empty() || receivers.iter().any(|other| other.name == receiver.name) {
                let name = format!("{key}.name");
                return Err(at.refuse(&name, receiver.name, "a name that no other receiver has"));
            }
            receivers.push(receiver);
        }
        Ok(NotifySettings { receivers, longest_pause_s, most_waiting, deprecated })
    }
}

/// Every receiver with its key in the file.
fn keyed(receivers: Vec<ReceiverTable>, old: DeliveryTable) -> Vec<(String, ReceiverTable)> {
    let new =
        receivers.into_iter().enumerate().map(|(index, table)| (format!("receiver.{}", index + 1), table));
    let webhooks = old.webhook.into_iter().enumerate();
    let webhooks = webhooks
        .map(|(index, table)| (format!("delivery.webhook.{}", index + 1), ReceiverTable::Webhook(table)));
    let mqtt = old.mqtt.into_iter().map(|table| ("delivery.mqtt".to_owned(), ReceiverTable::Mqtt(table)));
    new.chain(webhooks).chain(mqtt).collect()
}

impl DeliveryTable {
    /// The keys in use, with those that replace them.
    fn deprecated(&self) -> Vec<String> {
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

impl WebhookTable {
    fn check(self, at: &ConfigText<'_>, key: &str, number: usize) -> Result<ReceiverSettings, SettingsError> {
        let host = self.url.strip_prefix("http://").or_else(|| self.url.strip_prefix("https://"));
        if host.is_none_or(|host| host.is_empty() || host.contains(char::is_whitespace)) {
            let allowed = "http://HOST... or https://HOST...";
            return Err(at.refuse(&format!("{key}.url"), &self.url, allowed));
        }
        let plain = self.url.strip_prefix("http://").is_some_and(|rest| !is_this_machine(authority(rest)));
        if plain && self.token_file.is_some() && !self.allow_insecure {
            return Err(at.refuse(&format!("{key}.token_file"), "given", IN_THE_CLEAR));
        }
        let token_file = self.token_file.map(|file| at.beside(&file));
        Ok(ReceiverSettings {
            name: self.name.unwrap_or_else(|| format!("webhook-{number}")),
            act_only: self.grade == Least::Act,
            way: ReceiverWay::Webhook(WebhookSettings { url: self.url, token_file }),
        })
    }
}

impl MqttTable {
    fn check(self, at: &ConfigText<'_>, key: &str, train: &str) -> Result<ReceiverSettings, SettingsError> {
        let key = |name: &str| format!("{key}.{name}");
        if self.host.is_empty() || self.host.contains(['/', ' ']) {
            return Err(at.refuse(&key("host"), format!("{:?}", self.host), "a host name or address"));
        }
        if self.port == 0 {
            return Err(at.refuse(&key("port"), 0, "1 to 65535"));
        }
        if self.topic.is_empty() || self.topic.contains(['+', '#', '\0']) {
            let allowed = "a topic without wildcards; {train} and {id} are replaced";
            return Err(at.refuse(&key("topic"), format!("{:?}", self.topic), allowed));
        }
        if self.user.is_none() && self.password_file.is_some() {
            return Err(at.refuse(&key("user"), "absent", "a user for the password"));
        }
        if self.password_file.is_some() && !is_this_machine(&self.host) && !self.allow_insecure {
            return Err(at.refuse(&key("password_file"), "given", IN_THE_CLEAR));
        }
        let settings = MqttSettings {
            host: self.host,
            port: self.port,
            topic: self.topic,
            client_id: self.client_id.unwrap_or_else(|| format!("railgrip-{train}")),
            user: self.user,
            password_file: self.password_file.map(|file| at.beside(&file)),
            retain: self.retain,
        };
        Ok(ReceiverSettings {
            name: self.name.unwrap_or_else(|| "mqtt".to_owned()),
            act_only: self.grade == Least::Act,
            way: ReceiverWay::Mqtt(settings),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[derive(Deserialize)]
    struct Form {
        #[serde(default)]
        receiver: Vec<ReceiverTable>,
        #[serde(default)]
        notify: NotifyTable,
        #[serde(default)]
        delivery: DeliveryTable,
    }

    fn parse(text: &str) -> Result<NotifySettings, String> {
        let at = ConfigText { file: Path::new("dir/x.toml"), text };
        let form: Form = at.parse().map_err(|error| error.to_string())?;
        let tables = ReceiverTables { receiver: form.receiver, notify: form.notify, delivery: form.delivery };
        tables.check(&at, "demo").map_err(|error| error.to_string())
    }

    #[test]
    fn the_old_form_reads_as_the_new_one_and_is_named() {
        let new = parse(
            "[[receiver]]\nkind = \"webhook\"\nurl = \"http://depot:9/a\"\ntoken_file = \"t\"\nallow_insecure = true\ngrade = \"act\"\n\
             [[receiver]]\nkind = \"mqtt\"\nhost = \"broker\"\n[notify]\nmost_waiting = 50\n",
        )
        .unwrap();
        let old = parse(
            "[[delivery.webhook]]\nurl = \"http://depot:9/a\"\ntoken_file = \"t\"\nallow_insecure = true\ngrade = \"act\"\n\
             [delivery.mqtt]\nhost = \"broker\"\n[delivery]\nmost_waiting = 50\n",
        )
        .unwrap();
        assert_eq!(new.deprecated, Vec::<String>::new());
        println!("{:?}", old.deprecated);
        assert_eq!(old.deprecated.len(), 3);
        assert!(old.deprecated[0].starts_with("`[[delivery.webhook]]` is deprecated"));
        assert_eq!(NotifySettings { deprecated: Vec::new(), ..old }, new);
        assert_eq!((new.receivers[0].name.as_str(), new.receivers[0].act_only), ("webhook-1", true));
        let ReceiverWay::Webhook(webhook) = &new.receivers[0].way else { panic!("a webhook") };
        assert_eq!(webhook.token_file.as_deref(), Some(Path::new("dir/t")));
        let ReceiverWay::Mqtt(mqtt) = &new.receivers[1].way else { panic!("a broker") };
        assert_eq!((new.receivers[1].name.as_str(), new.receivers[1].act_only), ("mqtt", false));
        assert_eq!((mqtt.port, mqtt.client_id.as_str()), (1883, "railgrip-demo"));
        assert_eq!((new.most_waiting, new.longest_pause_s), (50, 300.0));
    }

    #[test]
    fn a_secret_travels_by_tls_or_stays_on_this_machine_unless_the_operator_says_otherwise() {
        for url in ["https://depot/a", "http://localhost:9/a", "http://127.0.0.1/a", "http://[::1]:9/a?b=@c"]
        {
            let text = format!("[[receiver]]\nkind = \"webhook\"\nurl = \"{url}\"\ntoken_file = \"t\"\n");
            assert!(parse(&text).is_ok(), "{url}");
        }
        let insecure = "[[receiver]]\nkind = \"webhook\"\nurl = \"http://depot/a\"\ntoken_file = \"t\"\nallow_insecure = true\n";
        assert!(parse(insecure).is_ok() && parse(&insecure.replace("depot", "localhost@depot")).is_ok());
        assert!(parse(&insecure.replace("true", "false").replace("depot", "localhost@depot")).is_err());
        let broker =
            "[[receiver]]\nkind = \"mqtt\"\nhost = \"127.0.0.1\"\nuser = \"u\"\npassword_file = \"p\"\n";
        assert!(parse(broker).is_ok() && parse(&broker.replace("127.0.0.1", "10.0.0.7")).is_err());
    }

    #[test]
    fn wrong_receivers_are_named() {
        for (text, said) in [
            ("[[receiver]]\nkind = \"webhook\"\nurl = \"depot\"\n", "x.toml:3: `receiver.1.url`"),
            ("[[receiver]]\nkind = \"pigeon\"\n", "unknown variant `pigeon`, expected `webhook` or `mqtt`"),
            ("[[receiver]]\nkind = \"mqtt\"\nhost = \"b\"\nhots = 1\n", "unknown field `hots`"),
            (
                "[[receiver]]\nkind = \"mqtt\"\nhost = \"b\"\n[[receiver]]\nkind = \"mqtt\"\nhost = \"c\"\n",
                "`receiver.2.name` is mqtt, allowed is a name that no other receiver has",
            ),
            ("[[delivery.webhook]]\nurl = \"depot\"\n", "delivery.webhook.1.url"),
            ("[delivery.mqtt]\nhost = \"b\"\ntopic = \"a/#\"\n", "delivery.mqtt.topic"),
            ("[delivery.mqtt]\nhost = \"b\"\npassword_file = \"p\"\n", "delivery.mqtt.user"),
            ("[delivery]\nlongest_pause_s = 0.0\n", "delivery.longest_pause_s"),
            ("[notify]\nmost_waiting = 1\n", "notify.most_waiting"),
            (
                "[[receiver]]\nkind = \"webhook\"\nurl = \"http://depot:9/a\"\ntoken_file = \"t\"\n",
                "`receiver.1.token_file` is given, allowed is nothing without TLS",
            ),
            (
                "[[receiver]]\nkind = \"mqtt\"\nhost = \"broker\"\nuser = \"u\"\npassword_file = \"p\"\n",
                "`receiver.1.password_file` is given, allowed is nothing without TLS",
            ),
        ] {
            let error = parse(text).unwrap_err();
            println!("{error}");
            assert!(error.contains(said), "{error}");
        }
    }
}
