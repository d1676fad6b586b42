//! `[[receiver]]` and `[notify]`: who is notified of alerts, and by which way.
//!
//! Files of earlier versions say `[[delivery.webhook]]`, `[delivery.mqtt]` and `[delivery]` instead. They are read into the
//! same form, checked in the same place, and named in [`NotifySettings::deprecated`].

mod delivery;
mod grade;
mod host;
mod mqtt;
mod table;
mod webhook;

pub(crate) use delivery::DeliveryTable;
pub(crate) use host::is_this_machine;
pub(crate) use mqtt::BROKER_IN_THE_CLEAR;
pub use mqtt::{BrokerTls, MqttSettings};
pub(crate) use table::ReceiverTable;
pub use webhook::{WebhookSettings, has_login};

use crate::place::ConfigText;
use grade::Least;
use table::Kept;

use serde::{Deserialize, Serialize};

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

/// `[notify]`.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct NotifyTable {
    /// Longest pause between two attempts, s.
    longest_pause_s: f64,
    /// Notifications that wait for one receiver at most; beyond, the oldest are dropped and counted.
    most_waiting: u32,
}

impl Default for NotifyTable {
    fn default() -> Self {
        Self { longest_pause_s: 300.0, most_waiting: 10_000 }
    }
}

/// What a file says about receivers, in its new form and in its old one.
pub(crate) struct ReceiverTables {
    pub receiver: Vec<ReceiverTable>,
    pub notify: NotifyTable,
    pub delivery: DeliveryTable,
}

impl ReceiverTables {
    pub(crate) fn check(self, at: &ConfigText<'_>, train: &str) -> NotifySettings {
        let deprecated = self.delivery.deprecated();
        let (longest_key, longest_pause_s) = match self.delivery.longest_pause_s {
            Some(old) => ("delivery.longest_pause_s", old),
            None => ("notify.longest_pause_s", self.notify.longest_pause_s),
        };
        let (most_key, most_waiting) = match self.delivery.most_waiting {
            Some(old) => ("delivery.most_waiting", old),
            None => ("notify.most_waiting", self.notify.most_waiting),
        };
        at.number(most_key, f64::from(most_waiting), 10.0..=1e6);
        at.number(longest_key, longest_pause_s, 1.0..=86_400.0);
        let mut receivers: Vec<ReceiverSettings> = Vec::new();
        for (key, table) in keyed(at, self.receiver, self.delivery) {
            let of = |way: fn(&ReceiverWay) -> bool| receivers.iter().filter(|one| way(&one.way)).count();
            let receiver = match table {
                Kept::Webhook(mut table) => {
                    let number = of(|way| matches!(way, ReceiverWay::Webhook(_))) + 1;
                    let name = table.name.take().unwrap_or_else(|| format!("webhook-{number}"));
                    let act_only = table.grade == Least::Act;
                    ReceiverSettings { name, act_only, way: ReceiverWay::Webhook(table.check(at, &key)) }
                }
                Kept::Mqtt(mut table) => {
                    let name = table.name.take().unwrap_or_else(|| "mqtt".to_owned());
                    let act_only = table.grade == Least::Act;
                    ReceiverSettings { name, act_only, way: ReceiverWay::Mqtt(table.check(at, &key, train)) }
                }
            };
            if receiver.name.is_empty() || receivers.iter().any(|other| other.name == receiver.name) {
                let name = format!("{key}.name");
                at.note(at.refuse(&name, &receiver.name, "a name that no other receiver has"));
            }
            receivers.push(receiver);
        }
        NotifySettings { receivers, longest_pause_s, most_waiting, deprecated }
    }
}

/// Every receiver with its key in the file.
fn keyed(at: &ConfigText<'_>, receivers: Vec<ReceiverTable>, old: DeliveryTable) -> Vec<(String, Kept)> {
    let new = receivers.into_iter().enumerate().filter_map(|(index, table)| {
        let key = format!("receiver.{}", index + 1);
        table.of_kind(at, &key).map(|table| (key, table))
    });
    let webhooks = old.webhook.into_iter().enumerate();
    let webhooks =
        webhooks.map(|(index, table)| (format!("delivery.webhook.{}", index + 1), Kept::Webhook(table)));
    let mqtt = old.mqtt.into_iter().map(|table| ("delivery.mqtt".to_owned(), Kept::Mqtt(table)));
    new.chain(webhooks).chain(mqtt).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::{Path, PathBuf};

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
        let at = ConfigText::new(Path::new("dir/x.toml"), text);
        let form: Form = at.parse().map_err(|error| error.to_string())?;
        let tables = ReceiverTables { receiver: form.receiver, notify: form.notify, delivery: form.delivery };
        let settings = tables.check(&at, "demo");
        at.into_found().first().map_or(Ok(settings), |error| Err(error.to_string()))
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
        let far = broker.replace("127.0.0.1", "10.0.0.7");
        assert!(parse(broker).is_ok() && parse(&far).is_err());
        assert!(
            parse(&format!("{far}tls = true\n")).is_ok() && parse(&format!("{far}tls = false\n")).is_err()
        );
        let login = "[[receiver]]\nkind = \"webhook\"\nurl = \"http://kim:word@localhost:9/a\"\n";
        assert!(
            parse(login).is_ok()
                && parse(&login.replace("http:", "https:").replace("localhost", "depot")).is_ok()
        );
        for far in ["depot", "localhost@depot", "127.0.0.1.depot", "[::1@depot"] {
            let far = login.replace("localhost", far);
            assert!(parse(&far).is_err() && parse(&format!("{far}allow_insecure = true\n")).is_ok(), "{far}");
        }
        assert!(
            parse(&login.replace("kim:word@", "").replace("localhost", "depot")).is_ok(),
            "no secret, no refusal"
        );
    }

    #[test]
    fn a_login_in_an_address_is_a_secret() {
        for (url, secret) in [
            ("http://kim:word@localhost/a", true),
            ("https://kim@depot", true),
            ("https://:word@depot?x", true),
            ("https://depot/a@b", false),
            ("https://depot?a=@b", false),
        ] {
            let webhook = |token: Option<&str>| WebhookSettings {
                url: url.to_owned(),
                token_file: token.map(PathBuf::from),
            };
            assert_eq!(webhook(None).carries_secret(), secret, "{url}");
            assert!(webhook(Some("t")).carries_secret());
        }
    }

    #[test]
    fn tls_has_a_port_of_its_own_and_an_authority_beside_the_config() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("x.toml");
        let parse = |text: &str| {
            let at = ConfigText::new(&file, text);
            let form: Form = at.parse().unwrap();
            let tables =
                ReceiverTables { receiver: form.receiver, notify: form.notify, delivery: form.delivery };
            let mut settings = tables.check(&at, "demo");
            at.into_found().pop().map_or_else(|| Ok(settings.receivers.remove(0).way), Err)
        };
        let mqtt = "[[receiver]]\nkind = \"mqtt\"\nhost = \"b\"\n";
        let Ok(ReceiverWay::Mqtt(plain)) = parse(mqtt) else { panic!("a broker") };
        assert_eq!((plain.port, plain.tls), (1883, None));
        let Ok(ReceiverWay::Mqtt(public)) = parse(&format!("{mqtt}tls = true\n")) else { panic!("a broker") };
        assert_eq!((public.port, public.tls), (8883, Some(BrokerTls { ca_file: None })));
        let own = format!("{mqtt}tls = true\nport = 1883\nca_file = \"ca.pem\"\n");
        std::fs::write(folder.path().join("ca.pem"), "no certificate").unwrap();
        let said = parse(&own).unwrap_err().to_string();
        assert!(said.contains("`receiver.1.ca_file`") && said.contains("which holds none"), "{said}");
        std::fs::write(folder.path().join("ca.pem"), "-----BEGIN CERTIFICATE-----\n").unwrap();
        let Ok(ReceiverWay::Mqtt(own)) = parse(&own) else { panic!("a broker") };
        assert_eq!(
            (own.port, own.tls),
            (1883, Some(BrokerTls { ca_file: Some(folder.path().join("ca.pem")) }))
        );
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
                "`receiver.1.password_file` is given, allowed is nothing without TLS beyond this machine, because it would travel in the clear: tls = true",
            ),
            (
                "[[receiver]]\nkind = \"webhook\"\nurl = \"http://kim:word@depot:9/a\"\n",
                "x.toml:3: `receiver.1.url` is given with a user or password, allowed is nothing without TLS",
            ),
            (
                "[[receiver]]\nkind = \"webhook\"\nurl = \"http://kim:word@\"\n",
                "`receiver.1.url` is , allowed is http://HOST",
            ),
            (
                "[[receiver]]\nkind = \"mqtt\"\nhost = \"b\"\nca_file = \"x.toml\"\n",
                "`receiver.1.ca_file` is given, allowed is nothing without tls = true",
            ),
            (
                "[[receiver]]\nkind = \"mqtt\"\nhost = \"b\"\ntls = true\nca_file = \"gone.pem\"\n",
                "x.toml:5: `receiver.1.ca_file` is dir/gone.pem: ",
            ),
        ] {
            let error = parse(text).unwrap_err();
            println!("{error}");
            assert!(error.contains(said) && !error.contains("word@"), "{error}");
        }
    }
}
