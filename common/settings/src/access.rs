//! Access to the HTTP service: who may come in from where, and how much one client may ask for.
//!
//! Loopback needs nothing. An address that other machines can reach needs TLS and tokens, or the word of the operator
//! (`allow_insecure`) that the network is as trusted as this machine.

use crate::SettingsError;
use crate::place::ConfigText;
use serde::{Deserialize, Serialize};
use std::net::{IpAddr, SocketAddr};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// What an address beyond this machine asks for.
const WANTED: &str = "a loopback address such as 127.0.0.1:8080, or with [http.tls] `certificate` and `key` and \
                      [http] `token_file`: other machines reach this one, and without TLS and tokens everybody there \
                      reads the train and acknowledges its alerts; where that is meant, say [http] `allow_insecure = true`";
/// Longest host name.
const MAX_HOST: usize = 255;

/// Access to the HTTP service.
#[derive(Debug, Clone, PartialEq)]
pub struct AccessSettings {
    /// Certificate and key, where HTTPS is spoken.
    pub tls: Option<TlsFiles>,
    /// Who may come in; without it everybody who reaches the address.
    pub token_file: Option<PathBuf>,
    /// The operator takes an open address without TLS or tokens upon themselves.
    pub allow_insecure: bool,
    /// Names under which browsers reach the service, besides addresses and `localhost`.
    pub hosts: Vec<String>,
    /// A login on the page ends after this time.
    pub session: Duration,
    /// Limits that keep the service usable while somebody misbehaves.
    pub limits: AccessLimits,
    /// Addresses of proxies, which are believed who they ask for (`X-Forwarded-For`).
    pub proxies: Vec<IpAddr>,
    /// Where it is written who did what.
    pub audit: AuditSettings,
}

/// PEM files, read again when they change.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TlsFiles {
    /// The certificate of this service first, then those that lead to a root.
    pub certificate: PathBuf,
    /// Its private key: PKCS#8, PKCS#1 or SEC1.
    pub key: PathBuf,
}

/// Limits that keep the service usable while somebody misbehaves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AccessLimits {
    /// Connections at a time, all clients together.
    pub connections: usize,
    /// Connections at a time of one client.
    pub connections_per_client: usize,
    /// Requests a second of one client in the long run; 0 sets no limit.
    pub requests_per_s: f64,
    /// Requests of one client at once.
    pub burst: f64,
    /// Clients on this machine keep to these limits, too.
    pub on_loopback: bool,
    /// Largest body of a request, bytes.
    pub body_bytes: usize,
    /// Time for the handshake, for the head of a request, and between two requests.
    pub head: Duration,
    /// Time for the body of a request.
    pub body: Duration,
    /// Time until an answer begins.
    pub answer: Duration,
    /// A reader who takes nothing for this long is cut off.
    pub stall: Duration,
}

/// Where it is written who did what.
#[derive(Debug, Clone, PartialEq)]
pub struct AuditSettings {
    /// JSON lines.
    pub file: PathBuf,
    /// The file is put aside when it is so large, bytes.
    pub max_bytes: u64,
    /// So many files are kept, the current one included.
    pub keep: usize,
}

#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct HttpTable {
    /// ADDRESS:PORT of the HTTP service; port 0 takes any free one.
    pub listen: String,
    /// What is served is at most so old, ms.
    pub refresh_ms: f64,
    /// A wagon without news for so long is stale, s.
    pub stale_after_s: f64,
    /// Other origins whose pages may read the interface.
    pub cors_origins: Vec<String>,
    pub tls: Option<TlsTable>,
    /// Who may come in: see `railgrip token`; without it everybody who reaches the address.
    pub token_file: Option<String>,
    /// An address beyond loopback without TLS and tokens: everybody there reads and acknowledges.
    pub allow_insecure: bool,
    /// Names under which browsers reach the service, besides addresses and localhost.
    pub hosts: Vec<String>,
    /// A login on the page ends after so long, h.
    pub session_hours: f64,
    pub limits: LimitsTable,
    pub audit: AuditTable,
}

impl Default for HttpTable {
    fn default() -> Self {
        Self {
            listen: "127.0.0.1:8080".to_owned(),
            refresh_ms: 150.0,
            stale_after_s: 2.0,
            cors_origins: Vec::new(),
            tls: None,
            token_file: None,
            allow_insecure: false,
            hosts: Vec::new(),
            session_hours: 12.0,
            limits: LimitsTable::default(),
            audit: AuditTable::default(),
        }
    }
}

#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TlsTable {
    /// Certificate of the service and those that lead to a root (PEM); required in this table.
    pub certificate: String,
    /// Its private key (PEM); required in this table.
    pub key: String,
}

#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct LimitsTable {
    /// Connections at a time, all clients together.
    pub connections: u32,
    /// Connections at a time of one client.
    pub connections_per_client: u32,
    /// Requests of one client in the long run, 1/s; 0: no limit.
    pub requests_per_s: f64,
    /// Requests of one client at once.
    pub burst: f64,
    /// Clients on this machine keep to the limits of one client, too.
    pub on_loopback: bool,
    /// Addresses of proxies, whose X-Forwarded-For says whose limits hold.
    pub proxies: Vec<String>,
    /// Largest body of a request, kB.
    pub body_kb: f64,
    /// Time for a handshake, for the head of a request, and between two requests, s.
    pub head_s: f64,
    /// Time for the body of a request, s.
    pub body_s: f64,
    /// Time until an answer begins, s.
    pub answer_s: f64,
    /// Who takes nothing for so long is cut off, s.
    pub stall_s: f64,
}

impl Default for LimitsTable {
    fn default() -> Self {
        Self {
            connections: 512,
            connections_per_client: 32,
            requests_per_s: 50.0,
            burst: 200.0,
            on_loopback: false,
            proxies: Vec::new(),
            body_kb: 64.0,
            head_s: 15.0,
            body_s: 10.0,
            answer_s: 30.0,
            stall_s: 20.0,
        }
    }
}

#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct AuditTable {
    /// Who did what, from where (JSON lines); without it `audit.jsonl` in the folder of what lasts.
    pub file: Option<String>,
    /// Then a new file is begun, MB.
    pub max_mb: f64,
    /// So many files are kept, the current one included.
    pub keep: u32,
}

impl Default for AuditTable {
    fn default() -> Self {
        Self { file: None, max_mb: 5.0, keep: 5 }
    }
}

impl AccessSettings {
    /// Checks what `[http]` says about access. `listen` comes from the file, or from the command line when `overridden`.
    pub(crate) fn of(
        at: &ConfigText<'_>,
        http: &HttpTable,
        listen: SocketAddr,
        overridden: bool,
        lasting_dir: &Path,
    ) -> Self {
        let base = at.file.parent().unwrap_or(Path::new(""));
        let tls = http.tls.as_ref().map(|table| TlsFiles {
            certificate: base.join(path(at, "http.tls.certificate", &table.certificate)),
            key: base.join(path(at, "http.tls.key", &table.key)),
        });
        let token_file = http.token_file.as_ref().map(|file| base.join(path(at, "http.token_file", file)));
        let shut = tls.is_some() && token_file.is_some();
        if !is_loopback(listen.ip()) && !shut && !http.allow_insecure {
            let problem = || format!("allowed is {WANTED}");
            // Without sound tables it is not known what the operator meant.
            match overridden {
                _ if at.doubts("http.tls") || at.doubts("http.token_file") => {}
                _ if at.doubts("http.allow_insecure") => {}
                true => {
                    let value = listen.to_string();
                    at.note(SettingsError::Option { option: "--listen", value, problem: problem() });
                }
                false => at.note(at.refuse("http.listen", listen, WANTED)),
            }
        }
        for (index, host) in http.hosts.iter().enumerate() {
            at.or(check_host(at, index, host), ());
        }
        let audit = &http.audit;
        let audit_file = match &audit.file {
            Some(file) => base.join(path(at, "http.audit.file", file)),
            None => lasting_dir.join("audit.jsonl"),
        };
        Self {
            tls,
            token_file,
            allow_insecure: http.allow_insecure,
            hosts: http.hosts.iter().map(|host| host.to_ascii_lowercase()).collect(),
            session: hours(at.number("http.session_hours", http.session_hours, 0.01..=720.0)),
            limits: http.limits.check(at),
            proxies: http.limits.proxies(at),
            audit: AuditSettings {
                file: audit_file,
                max_bytes: (at.number("http.audit.max_mb", audit.max_mb, 0.01..=1000.0) * 1e6) as u64,
                keep: whole(at, "http.audit.keep", audit.keep, 1..=100),
            },
        }
    }
}

impl LimitsTable {
    fn proxies(&self, at: &ConfigText<'_>) -> Vec<IpAddr> {
        let address = |(index, text): (usize, &String)| {
            let key = format!("http.limits.proxies[{index}]");
            let parsed = text.parse();
            if parsed.is_err() {
                at.note(at.refuse(&key, format!("{text:?}"), "an IP address, such as 127.0.0.1"));
            }
            parsed.ok()
        };
        self.proxies.iter().enumerate().filter_map(address).collect()
    }

    fn check(&self, at: &ConfigText<'_>) -> AccessLimits {
        let seconds = |key: &str, value: f64| {
            Duration::from_secs_f64(at.number(&format!("http.limits.{key}"), value, 0.1..=3600.0))
        };
        AccessLimits {
            connections: whole(at, "http.limits.connections", self.connections, 4..=100_000),
            connections_per_client: whole(
                at,
                "http.limits.connections_per_client",
                self.connections_per_client,
                1..=100_000,
            ),
            requests_per_s: at.number("http.limits.requests_per_s", self.requests_per_s, 0.0..=1e6),
            burst: at.number("http.limits.burst", self.burst, 1.0..=1e6),
            on_loopback: self.on_loopback,
            body_bytes: (at.number("http.limits.body_kb", self.body_kb, 1.0..=10_000.0) * 1e3) as usize,
            head: seconds("head_s", self.head_s),
            body: seconds("body_s", self.body_s),
            answer: seconds("answer_s", self.answer_s),
            stall: seconds("stall_s", self.stall_s),
        }
    }
}

/// True if only this machine reaches the address.
#[must_use]
pub fn is_loopback(address: IpAddr) -> bool {
    address.to_canonical().is_loopback()
}

fn path<'a>(at: &ConfigText<'_>, key: &str, given: &'a str) -> &'a str {
    if given.is_empty() || given.contains('\0') {
        at.note(at.refuse(key, format!("{given:?}"), "a file, relative to this one"));
    }
    given
}

fn check_host(at: &ConfigText<'_>, index: usize, host: &str) -> Result<(), SettingsError> {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '.' | '_');
    if (1..=MAX_HOST).contains(&host.len()) && host.chars().all(plain) {
        return Ok(());
    }
    Err(at.refuse("http.hosts", format!("{host:?} at place {}", index + 1), "names of hosts, without a port"))
}

fn hours(hours: f64) -> Duration {
    Duration::from_secs_f64(hours * 3600.0)
}

fn whole(at: &ConfigText<'_>, key: &str, value: u32, range: std::ops::RangeInclusive<u32>) -> usize {
    at.number(key, f64::from(value), f64::from(*range.start())..=f64::from(*range.end()));
    value as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Overrides, TrainSettings};

    fn parse(http: &str, listen: Option<&str>) -> Result<AccessSettings, String> {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/railgrip.toml");
        let text = format!(
            "schema = 1\n[train]\nname = \"demo\"\nwagons = 1\nvehicle = \"vehicle.toml\"\n[source]\nkind = \"stdin\"\n{http}"
        );
        let overrides = Overrides { listen: listen.map(|at| at.parse().unwrap()), ..Overrides::default() };
        TrainSettings::parse(&file, &text, &overrides)
            .map(|train| train.access)
            .map_err(|error| error.to_string())
    }

    #[test]
    fn only_loopback_is_open_without_tls_and_tokens() {
        for open in ["127.0.0.1:0", "127.8.9.1:80", "[::1]:8080", "[::ffff:127.0.0.1]:1"] {
            assert!(parse(&format!("[http]\nlisten = \"{open}\"\n"), None).is_ok(), "{open}");
        }
        for shut in ["0.0.0.0:8080", "[::]:8080", "192.0.2.7:80", "[::ffff:192.0.2.7]:80"] {
            let said = parse(&format!("[http]\nlisten = \"{shut}\"\n"), None).unwrap_err();
            assert!(said.contains(":9: `http.listen` is") && said.contains("allow_insecure"), "{said}");
            let said = parse("", Some(shut)).unwrap_err();
            assert!(said.starts_with("--listen ") && said.contains("token_file"), "{said}");
        }
        let tls = "[http.tls]\ncertificate = \"c.pem\"\nkey = \"k.pem\"\n";
        let tokens = "[http]\ntoken_file = \"tokens.toml\"\n";
        assert!(parse(tls, Some("0.0.0.0:1")).is_err(), "TLS alone is not enough");
        assert!(parse(tokens, Some("0.0.0.0:1")).is_err(), "tokens alone travel in the clear");
        let access = parse(&format!("{tokens}{tls}"), Some("0.0.0.0:1")).unwrap();
        assert!(access.tls.unwrap().key.ends_with("config/k.pem"));
        assert!(parse("[http]\nallow_insecure = true\n", Some("0.0.0.0:1")).unwrap().allow_insecure);
    }

    #[test]
    fn values_out_of_range_are_named() {
        for (http, words) in [
            ("[http.limits]\nbody_kb = 0\n", "`http.limits.body_kb` is 0, allowed is 1 to 10000"),
            ("[http.limits]\nconnections = 1\n", "`http.limits.connections` is 1, allowed is 4 to 100000"),
            ("[http.limits]\nstall_s = nan\n", "`http.limits.stall_s` is NaN"),
            ("[http.limits]\nstal_s = 1\n", "unknown field `stal_s`"),
            ("[http]\nhosts = [\"a b\"]\n", "`http.hosts` is \"a b\" at place 1"),
            ("[http.tls]\ncertificate = \"\"\nkey = \"k\"\n", "`http.tls.certificate`"),
            ("[http.tls]\ncertificate = \"c\"\n", "missing field `key`"),
            ("[http.limits]\nproxies = [\"depot\"]\n", "`http.limits.proxies[0]` is \"depot\""),
            ("[http.audit]\nkeep = 0\n", "`http.audit.keep` is 0"),
        ] {
            let said = parse(http, None).unwrap_err();
            assert!(said.contains(words), "{said}");
        }
    }
}
