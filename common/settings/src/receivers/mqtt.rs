//! A receiver by an MQTT broker, plain or by TLS.

use super::grade::Least;
use super::host::is_this_machine;
use crate::SettingsError;
use crate::place::ConfigText;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

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

/// Why a secret of a broker is refused.
pub(crate) const BROKER_IN_THE_CLEAR: &str = "nothing without TLS beyond this machine, because it would travel in the clear: \
     tls = true, or allow_insecure = true where the network is trusted";

/// `kind = "mqtt"`.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MqttTable {
    pub(super) name: Option<String>,
    pub(super) host: String,
    pub(super) port: Option<u16>,
    #[serde(default = "topic")]
    pub(super) topic: String,
    pub(super) client_id: Option<String>,
    pub(super) user: Option<String>,
    pub(super) password_file: Option<String>,
    #[serde(default)]
    pub(super) tls: bool,
    pub(super) ca_file: Option<String>,
    #[serde(default)]
    pub(super) retain: bool,
    #[serde(default)]
    pub(super) allow_insecure: bool,
    #[serde(default)]
    pub(super) grade: Least,
}

/// The topic where none is given.
pub(super) fn topic() -> String {
    "railgrip/{train}/alerts/{id}".to_owned()
}

impl MqttTable {
    pub(super) fn check(self, at: &ConfigText<'_>, key: &str, train: &str) -> MqttSettings {
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
        MqttSettings {
            host: self.host,
            port,
            topic: self.topic,
            client_id: self.client_id.unwrap_or_else(|| format!("railgrip-{train}")),
            user: self.user,
            password_file: self.password_file.map(|file| at.beside(&file)),
            tls,
            retain: self.retain,
        }
    }
}
