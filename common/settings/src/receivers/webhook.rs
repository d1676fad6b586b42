//! A receiver by HTTP POST.

use super::grade::Least;
use super::host::{authority, host, is_this_machine};
use crate::place::ConfigText;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

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

/// Why a secret of a webhook is refused.
const URL_IN_THE_CLEAR: &str = "nothing without TLS beyond this machine, because it would travel in the clear: https://, or \
     allow_insecure = true where the network is trusted";

/// `kind = "webhook"`.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct WebhookTable {
    pub(super) name: Option<String>,
    pub(super) url: String,
    pub(super) token_file: Option<String>,
    #[serde(default)]
    pub(super) allow_insecure: bool,
    #[serde(default)]
    pub(super) grade: Least,
}

impl WebhookTable {
    pub(super) fn check(self, at: &ConfigText<'_>, key: &str) -> WebhookSettings {
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
        WebhookSettings { url: self.url, token_file }
    }
}
