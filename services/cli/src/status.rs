//! `railgrip status`: what the HTTP service of a running train says, as a table.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use serde_json::Value;
use ureq::tls::{Certificate, PemItem, RootCerts, TlsConfig, parse_pem};

use crate::output::say;
use crate::train::TrainArgs;
use crate::{CliError, local_http};

/// Holds the token to show, unless an option names a file.
const TOKEN_VARIABLE: &str = "RAILGRIP_TOKEN";
/// How long the service may take to answer.
const TIMEOUT: Duration = Duration::from_secs(5);

/// Show what the HTTP service of a running train says.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    train: TrainArgs,
    /// Ask this service instead of the one that runs here, for example http://192.0.2.7:8080
    #[arg(long, value_name = "URL")]
    url: Option<String>,
    /// Show the token in this file to a service elsewhere [default: the environment variable RAILGRIP_TOKEN]
    #[arg(long, value_name = "FILE")]
    token_file: Option<PathBuf>,
    /// Trust certificates that these lead to (PEM) [default: the usual authorities of the web]
    #[arg(long, value_name = "FILE")]
    ca_file: Option<PathBuf>,
    /// Print the service's answer as it is
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let service = match &args.url {
        Some(url) => Service::Remote(Remote::new(url, args)?),
        None => local_service(args)?,
    };
    let base = service.base();
    let train = service.get("/api/v1/train")?;
    let wagons = service.get("/api/v1/wagons")?;
    if args.json {
        let both = serde_json::json!({ "train": train, "wagons": wagons["wagons"] });
        say(&serde_json::to_string_pretty(&both).map_err(CliError::failed)?);
    } else {
        table(&base, &train, &wagons).iter().for_each(|line| say(line));
    }
    Ok(())
}

/// One line about the train, one a wagon.
fn table(base: &str, train: &Value, wagons: &Value) -> Vec<String> {
    let rows = wagons["wagons"].as_array().map(Vec::as_slice).unwrap_or_default();
    let name = wagons["train"].as_str().unwrap_or("?");
    let mut lines = vec![format!("train {name}: {}, {} wagons ({base})", word(&train["grade"]), rows.len())];
    lines.push(format!(
        "{:>3}  {:<20} {:<18} {:<6} {:>6}  {:<7} {:>7} {:>8} {:>9} {:<9} {:>8} {:>9}  {}",
        "no",
        "wagon",
        "vehicle",
        "news",
        "age s",
        "grade",
        "km/h",
        "adhesion",
        "available",
        "rail",
        "pad",
        "asym %",
        "why"
    ));
    lines.extend(rows.iter().map(row));
    lines.extend(train["sources"].as_array().into_iter().flatten().filter_map(source));
    lines
}

/// What did not become samples, of a source that has lost or dropped something.
fn source(source: &Value) -> Option<String> {
    let counts = source["counts"].as_object()?;
    let others = counts.iter().filter(|(name, _)| !["arrived", "samples"].contains(&name.as_str()));
    let told: Vec<String> =
        others.map(|(name, count)| format!("{count} {}", name.replace('_', " "))).collect();
    let vehicle = source["vehicle_number"].as_str().map_or_else(String::new, |number| format!(" ({number})"));
    let of = source["wagon"]
        .as_u64()
        .map_or("source".to_owned(), |wagon| format!("source of wagon {wagon}{vehicle}"));
    (!told.is_empty()).then(|| format!("{of}: {}", told.join(", ")))
}

fn row(wagon: &Value) -> String {
    let bound = if wagon["adhesion_available_is_lower_bound"] == true { "≥" } else { "" };
    let available = figure(&wagon["adhesion_available"], 1.0, 3);
    let available = if available == UNKNOWN { available } else { format!("{bound}{available}") };
    format!(
        "{:>3}  {:<20} {:<18} {:<6} {:>6}  {:<7} {:>7} {:>8} {:>9} {:<9} {:>8} {:>9}  {}",
        wagon["id"].as_u64().unwrap_or_default(),
        word(&wagon["name"]),
        word(&wagon["vehicle_number"]),
        word(&wagon["state"]),
        figure(&wagon["age_s"], 1.0, 1),
        word(&wagon["grade"]),
        figure(&wagon["v_m_s"], 3.6, 1),
        figure(&wagon["adhesion"].as_f64().map(f64::abs).into(), 1.0, 3),
        available,
        word(&wagon["condition"]).replace('_', " "),
        figure(&wagon["brake_friction"], 1.0, 3),
        figure(&wagon["asymmetry"], 100.0, 1),
        wagon["reason"].as_str().unwrap_or_default(),
    )
    .trim_end()
    .to_owned()
}

/// What stands in the table where nothing is known.
const UNKNOWN: &str = "-";

fn word(value: &Value) -> &str {
    value.as_str().unwrap_or(UNKNOWN)
}

fn figure(value: &Value, scale: f64, decimals: usize) -> String {
    value.as_f64().map_or_else(|| UNKNOWN.to_owned(), |value| format!("{:.decimals$}", value * scale))
}

/// Who is asked.
enum Service {
    /// The one that runs here, through its local socket.
    Here(PathBuf),
    /// One at an address.
    Remote(Remote),
}

struct Remote {
    base: String,
    agent: ureq::Agent,
    token: Option<String>,
}

/// The health service of the train on this machine.
fn local_service(args: &Args) -> Result<Service, CliError> {
    let train = args.train.load()?;
    let socket = train.settings.instance.http_socket();
    if socket.exists() {
        return Ok(Service::Here(socket));
    }
    let file = train.settings.instance.http_address_file();
    let text = std::fs::read_to_string(&file).map_err(|error| {
        let name = &train.settings.name;
        CliError::failed(format!(
            "train \"{name}\" serves no HTTP on this machine ({}: {error}); start it with `railgrip up`",
            file.display()
        ))
    })?;
    let address = text.trim();
    let url = if address.contains("://") { address.to_owned() } else { format!("http://{address}") };
    Ok(Service::Remote(Remote::new(&url, args)?))
}

impl Service {
    fn base(&self) -> String {
        match self {
            Self::Here(socket) => socket.display().to_string(),
            Self::Remote(remote) => remote.base.clone(),
        }
    }

    fn get(&self, path: &str) -> Result<Value, CliError> {
        match self {
            Self::Here(socket) => local_http::get(socket, path, TIMEOUT)
                .map_err(|error| CliError::failed(format!("{}: {path}: {error}", socket.display()))),
            Self::Remote(remote) => remote.get(path),
        }
    }
}

impl Remote {
    fn new(url: &str, args: &Args) -> Result<Self, CliError> {
        let mut config =
            ureq::Agent::config_builder().timeout_global(Some(TIMEOUT)).http_status_as_error(false);
        if let Some(file) = &args.ca_file {
            let roots = RootCerts::Specific(Arc::new(authorities(file)?));
            config = config.tls_config(TlsConfig::builder().root_certs(roots).build());
        }
        let base = url.trim_end_matches('/').to_owned();
        Ok(Self { base, agent: config.build().into(), token: token(args.token_file.as_deref())? })
    }

    fn get(&self, path: &str) -> Result<Value, CliError> {
        let url = format!("{}{path}", self.base);
        let failed = |error: ureq::Error| CliError::failed(format!("{url}: {error}"));
        let mut request = self.agent.get(&url);
        if let Some(token) = &self.token {
            request = request.header("Authorization", format!("Bearer {token}"));
        }
        let mut answer = request.call().map_err(failed)?;
        let status = answer.status();
        if status.is_success() {
            return answer.body_mut().read_json().map_err(failed);
        }
        let problem: Value = answer.body_mut().read_json().unwrap_or_default();
        let detail = problem["detail"].as_str().unwrap_or_default();
        let hint = if status == 401 { "; give one with --token-file or RAILGRIP_TOKEN" } else { "" };
        Err(CliError::failed(format!("{url}: {status}: {detail}{hint}")))
    }
}

/// The token to show: from a file, else from the environment.
fn token(file: Option<&Path>) -> Result<Option<String>, CliError> {
    let text = match file {
        None => std::env::var(TOKEN_VARIABLE).ok(),
        Some(file) => {
            let wrong = |error| CliError::bad_input(format!("--token-file {}: {error}", file.display()));
            Some(std::fs::read_to_string(file).map_err(wrong)?)
        }
    };
    let Some(token) = text.map(|text| text.trim().to_owned()) else { return Ok(None) };
    if token.is_empty() || !token.bytes().all(|byte| byte.is_ascii_graphic()) {
        let whence = file.map_or_else(|| TOKEN_VARIABLE.to_owned(), |file| file.display().to_string());
        return Err(CliError::bad_input(format!("{whence}: holds no token; allowed is one line railgrip_…")));
    }
    Ok(Some(token))
}

/// The certificates of a PEM file.
fn authorities(file: &Path) -> Result<Vec<Certificate<'static>>, CliError> {
    let wrong = |problem: String| CliError::bad_input(format!("--ca-file {}: {problem}", file.display()));
    let text = std::fs::read(file).map_err(|error| wrong(error.to_string()))?;
    let mut found = Vec::new();
    for item in parse_pem(&text) {
        if let PemItem::Certificate(certificate) = item.map_err(|error| wrong(error.to_string()))? {
            found.push(certificate);
        }
    }
    if found.is_empty() {
        return Err(wrong("holds no `BEGIN CERTIFICATE`".to_owned()));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_shows_known_figures_and_dashes() {
        let train = serde_json::json!({ "grade": "watch" });
        let wagons = serde_json::json!({ "train": "demo", "wagons": [
            { "id": 1, "name": "coach-1", "vehicle_number": "51 80 21-75 019-3", "state": "live", "age_s": 0.12, "grade": "watch", "v_m_s": 10.0,
              "adhesion": -0.0812, "adhesion_available": 0.1, "adhesion_available_is_lower_bound": true,
              "condition": "very_low", "brake_friction": 0.35, "asymmetry": -0.051, "reason": "asymmetry" },
            { "id": 2, "name": "coach-2", "state": "silent", "age_s": null, "grade": "unknown", "reason": "" },
        ]});
        let lines = table("http://x", &train, &wagons);
        assert_eq!(lines[0], "train demo: watch, 2 wagons (http://x)");
        for part in [
            "coach-1",
            "51 80 21-75 019-3",
            "36.0",
            "0.081",
            "≥0.100",
            "very low",
            "0.350",
            "-5.1",
            "asymmetry",
        ] {
            assert!(lines[2].contains(part), "{part}: {}", lines[2]);
        }
        assert!(lines[3].contains("silent") && !lines[3].contains("0.0"), "{}", lines[3]);
    }

    #[test]
    fn only_a_source_that_lost_something_has_a_line() {
        let whole =
            serde_json::json!({ "wagon": null, "counts": { "arrived": 9, "overrun": 2, "header_crc": 1 } });
        assert_eq!(source(&whole).as_deref(), Some("source: 1 header crc, 2 overrun"));
        let known = serde_json::json!({ "wagon": 3, "vehicle_number": "51 80 7", "counts": { "ahead": 1 } });
        assert_eq!(source(&known).as_deref(), Some("source of wagon 3 (51 80 7): 1 ahead"));
        let sound = serde_json::json!({ "wagon": 3, "counts": { "samples": 9 } });
        assert_eq!(source(&sound), None);
    }
}
