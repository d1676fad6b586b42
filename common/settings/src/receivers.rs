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

impl WebhookSettings {
    /// Whether notifications carry a secret: a token, or user and password in the address.
    #[must_use]
    pub fn carries_secret(&self) -> bool {
        self.token_file.is_some() || has_login(&self.url)
    }
}

/// Whether a URL has a user or a password in it, which is sent as a secret with every request.
#[must_use]
pub fn has_login(url: &str) -> bool {
    url.split_once("://").is_some_and(|(_, rest)| authority(rest).0.is_some())
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
    /// File with the user's password, read at every connection.
    pub password_file: Option<PathBuf>,
    /// TLS, where the broker is reached by it.
    pub tls: Option<BrokerTls>,
    /// Whether the broker keeps the last message of a topic for those who come later.
    pub retain: bool,
}

/// TLS to a broker, whose certificate must be for its host.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct BrokerTls {
    /// Authorities (PEM) of which one must have signed the certificate, read at every connection; without a file, the public ones
    /// that webhooks are checked by, too.
    pub ca_file: Option<PathBuf>,
}

impl BrokerTls {
    /// Port where nothing else is said: what IANA gives MQTT with TLS, and without it.
    pub(crate) fn port(tls: Option<&Self>) -> u16 {
        if tls.is_some() { 8883 } else { 1883 }
    }

    /// What the keys `tls` and `ca_file` of the table `key` say.
    pub(crate) fn of(
        at: &ConfigText<'_>,
        key: &str,
        tls: bool,
        ca_file: Option<&str>,
    ) -> Result<Option<Self>, SettingsError> {
        let key = format!("{key}.ca_file");
        let Some(given) = ca_file else { return Ok(tls.then(Self::default)) };
        if !tls {
            return Err(at.refuse(&key, "given", "nothing without tls = true"));
        }
        let file = at.beside(given);
        // Read again at every connection; whoever starts a train wants to know now that it would fail.
        let allowed = "a file with a certificate (PEM) of an authority";
        match std::fs::read(&file) {
            Ok(text) if text.windows(BEGIN.len()).any(|part| part == BEGIN) => {
                Ok(Some(Self { ca_file: Some(file) }))
            }
            Ok(_) => Err(at.refuse(&key, format!("{}, which holds none", file.display()), allowed)),
            Err(error) => Err(at.refuse(&key, format!("{}: {error}", file.display()), allowed)),
        }
    }
}

/// Where a certificate begins in a PEM file.
const BEGIN: &[u8] = b"-----BEGIN CERTIFICATE-----";

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

/// `[[receiver]]`: the keys of both kinds, so that what is wrong with one is found at its place.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ReceiverTable {
    kind: ReceiverKind,
    name: Option<String>,
    url: Option<String>,
    token_file: Option<String>,
    host: Option<String>,
    port: Option<u16>,
    topic: Option<String>,
    client_id: Option<String>,
    user: Option<String>,
    password_file: Option<String>,
    tls: Option<bool>,
    ca_file: Option<String>,
    retain: Option<bool>,
    #[serde(default)]
    allow_insecure: bool,
    #[serde(default)]
    grade: Least,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum ReceiverKind {
    Webhook,
    Mqtt,
}

/// A receiver in the form of its kind.
enum Kept {
    Webhook(WebhookTable),
    Mqtt(MqttTable),
}

impl ReceiverTable {
    /// The keys of its kind; those of the other are noted.
    fn of_kind(self, at: &ConfigText<'_>, key: &str) -> Option<Kept> {
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
                topic: self.topic.unwrap_or_else(mqtt_topic),
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
    port: Option<u16>,
    #[serde(default = "mqtt_topic")]
    topic: String,
    client_id: Option<String>,
    user: Option<String>,
    password_file: Option<String>,
    #[serde(default)]
    tls: bool,
    ca_file: Option<String>,
    #[serde(default)]
    retain: bool,
    #[serde(default)]
    allow_insecure: bool,
    #[serde(default)]
    grade: Least,
}

/// Why a secret of a webhook is refused.
const URL_IN_THE_CLEAR: &str = "nothing without TLS beyond this machine, because it would travel in the clear: https://, or \
     allow_insecure = true where the network is trusted";

/// Why a secret of a broker is refused.
pub(crate) const BROKER_IN_THE_CLEAR: &str = "nothing without TLS beyond this machine, because it would travel in the clear: \
     tls = true, or allow_insecure = true where the network is trusted";

/// What is before `@` and after it in a URL that follows its scheme: user and password, then host and port.
fn authority(rest: &str) -> (Option<&str>, &str) {
    let authority = rest.split(['/', '?', '#']).next().unwrap_or_default();
    authority.rsplit_once('@').map_or((None, authority), |(login, host)| (Some(login), host))
}

/// The host of what follows the scheme of a URL.
fn host(rest: &str) -> &str {
    let (_, host) = authority(rest);
    match host.strip_prefix('[') {
        Some(bracketed) => bracketed.split(']').next().unwrap_or_default(),
        None => host.split(':').next().unwrap_or_default(),
    }
}

/// True for names and addresses of loopback.
pub(crate) fn is_this_machine(host: &str) -> bool {
    host.eq_ignore_ascii_case("localhost") || host.parse().is_ok_and(is_loopback)
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
                Kept::Webhook(table) => {
                    let number = of(|way| matches!(way, ReceiverWay::Webhook(_))) + 1;
                    table.check(at, &key, number)
                }
                Kept::Mqtt(table) => table.check(at, &key, train),
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
    fn check(self, at: &ConfigText<'_>, key: &str, number: usize) -> ReceiverSettings {
        let rest = self.url.strip_prefix("http://").or_else(|| self.url.strip_prefix("https://"));
        if rest.is_none_or(|rest| host(rest).is_empty() || rest.contains(char::is_whitespace)) {
            let allowed = "http://HOST... or https://HOST...";
            // What is wrong may hide a password.
            let shown = self.url.rsplit_once('@').map_or(self.url.as_str(), |(_, host)| host);
            at.note(at.refuse(&format!("{key}.url"), shown, allowed));
        }
        let plain = self.url.strip_prefix("http://").is_some_and(|rest| !is_this_machine(host(rest)));
        if plain && !self.allow_insecure && !at.is_blamed(&format!("{key}.allow_insecure")) {
            if self.token_file.is_some() {
                at.note(at.refuse(&format!("{key}.token_file"), "given", URL_IN_THE_CLEAR));
            }
            if has_login(&self.url) {
                at.note(at.refuse(&format!("{key}.url"), "given with a user or password", URL_IN_THE_CLEAR));
            }
        }
        let token_file = self.token_file.map(|file| at.beside(&file));
        ReceiverSettings {
            name: self.name.unwrap_or_else(|| format!("webhook-{number}")),
            act_only: self.grade == Least::Act,
            way: ReceiverWay::Webhook(WebhookSettings { url: self.url, token_file }),
        }
    }
}

impl MqttTable {
    fn check(self, at: &ConfigText<'_>, key: &str, train: &str) -> ReceiverSettings {
        let tls =
            at.or(BrokerTls::of(at, key, self.tls, self.ca_file.as_deref()), Some(BrokerTls::default()));
        let key = |name: &str| format!("{key}.{name}");
        if self.host.is_empty() || self.host.contains(['/', ' ']) {
            at.note(at.refuse(&key("host"), format!("{:?}", self.host), "a host name or address"));
        }
        let port = self.port.unwrap_or_else(|| BrokerTls::port(tls.as_ref()));
        if port == 0 {
            at.note(at.refuse(&key("port"), 0, "1 to 65535"));
        }
        if self.topic.is_empty() || self.topic.contains(['+', '#', '\0']) {
            let allowed = "a topic without wildcards; {train} and {id} are replaced";
            at.note(at.refuse(&key("topic"), format!("{:?}", self.topic), allowed));
        }
        if self.user.is_none() && self.password_file.is_some() {
            at.note(at.refuse(&key("user"), "absent", "a user for the password"));
        }
        let clear = tls.is_none() && !is_this_machine(&self.host);
        let unsure = ["host", "tls", "allow_insecure"].iter().any(|name| at.is_blamed(&key(name)));
        if self.password_file.is_some() && clear && !unsure && !self.allow_insecure {
            at.note(at.refuse(&key("password_file"), "given", BROKER_IN_THE_CLEAR));
        }
        let settings = MqttSettings {
            host: self.host,
            port,
            topic: self.topic,
            client_id: self.client_id.unwrap_or_else(|| format!("railgrip-{train}")),
            user: self.user,
            password_file: self.password_file.map(|file| at.beside(&file)),
            tls,
            retain: self.retain,
        };
        ReceiverSettings {
            name: self.name.unwrap_or_else(|| "mqtt".to_owned()),
            act_only: self.grade == Least::Act,
            way: ReceiverWay::Mqtt(settings),
        }
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
        std::fs::write(folder.path().join("ca.pem"), [BEGIN, b"\n"].concat()).unwrap();
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
