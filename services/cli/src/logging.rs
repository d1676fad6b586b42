//! Log lines on the standard error: text on a terminal, JSON otherwise, unless the config says which.

use std::io::IsTerminal;
use std::sync::OnceLock;

use railgrip_settings::{LogFormat, LoggingSettings};
use tracing_subscriber::filter::{LevelFilter, ParseError, Targets};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{Registry, fmt, reload};

use crate::CliError;

/// The environment variable that overrides the level of the config.
const FILTER_VARIABLE: &str = "RAILGRIP_LOG";

/// Who logs: each crate of the program, and those that it is built on.
const TARGETS: [&str; 11] = [
    "railgrip",
    "railgrip_bus",
    "railgrip_cli",
    "railgrip_estimator",
    "railgrip_health",
    "railgrip_ingest",
    "railgrip_judge",
    "railgrip_listener",
    "hyper",
    "rumqttc",
    "rustls",
];

/// The filter of this process, to be changed while it runs.
static FILTER: OnceLock<reload::Handle<Targets, Registry>> = OnceLock::new();

/// The filter that a text such as `info` or `info,railgrip_bus=debug` names. A word alone is a level: taken as the name of
/// a target, as the filter itself would, a slip of the pen would silence everything.
fn filter(wanted: &str) -> Result<Targets, CliError> {
    let refuse = |problem: String| {
        let allowed =
            "allowed is off, error, warn, info, debug or trace, or a list such as `info,railgrip_bus=debug`";
        CliError::bad_input(format!("log level \"{wanted}\": {problem}; {allowed}"))
    };
    let targets = wanted.split(',').filter_map(|word| word.split_once('='));
    for target in targets.map(|(target, _)| target.trim()) {
        let whole = |known: &&str| {
            target.strip_prefix(*known).is_some_and(|rest| rest.is_empty() || rest.starts_with("::"))
        };
        if !TARGETS.iter().any(whole) {
            return Err(refuse(format!("nothing logs as \"{target}\"; known are {}", TARGETS.join(", "))));
        }
    }
    let words = wanted.split(',').map(str::trim).filter(|word| !word.contains('='));
    for word in words {
        let known: Result<LevelFilter, _> = word.parse();
        if word.is_empty() || known.is_err() || word.bytes().all(|byte| byte.is_ascii_digit()) {
            return Err(refuse(format!("\"{word}\" is no level")));
        }
    }
    wanted.parse().map_err(|error: ParseError| refuse(error.to_string()))
}

/// Whether a level can be used.
///
/// # Errors
/// What is wrong with it, and what is allowed.
pub(crate) fn check(level: &str) -> Result<(), CliError> {
    filter(level).map(|_| ())
}

/// Starts logging for this process. A second call changes nothing.
pub(crate) fn start(settings: &LoggingSettings) -> Result<(), CliError> {
    let wanted = std::env::var(FILTER_VARIABLE).unwrap_or_else(|_| settings.level.clone());
    let filter = filter(&wanted)?;
    let json = match settings.format {
        LogFormat::Auto => !std::io::stderr().is_terminal(),
        LogFormat::Text => false,
        LogFormat::Json => true,
    };
    let lines = fmt::layer().with_writer(std::io::stderr);
    let (filter, handle) = reload::Layer::new(filter);
    let result = if json {
        Registry::default().with(filter).with(lines.json().with_span_list(false)).try_init()
    } else {
        let lines = lines.with_target(false).with_ansi(std::io::stderr().is_terminal());
        Registry::default().with(filter).with(lines).try_init()
    };
    match result {
        Ok(()) => {
            let _ = FILTER.set(handle);
        }
        Err(_) => tracing::debug!("logging runs already"),
    }
    Ok(())
}

/// Logs at another level from now on, unless the environment says which.
pub(crate) fn set_level(level: &str) {
    if std::env::var_os(FILTER_VARIABLE).is_some() {
        return;
    }
    if let (Some(handle), Ok(filter)) = (FILTER.get(), filter(level)) {
        let _ = handle.reload(filter);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_level_is_an_error_and_never_silence() {
        for good in ["info", "WARN", "off", "info,railgrip_bus=debug", "railgrip_health=trace"] {
            assert!(filter(good).is_ok(), "{good}");
        }
        for bad in [
            "inof",
            "",
            "debug,infi",
            "railgrip_bus",
            "railgrip_bus=loud",
            "7",
            "helth=info",
            "info,railgrip_helth=debug",
        ] {
            let said = filter(bad).expect_err(bad);
            assert!(said.code() == 2 && said.to_string().contains("allowed is off"), "{bad}: {said}");
        }
        let said = filter("helth=info").expect_err("nobody").to_string();
        assert!(said.contains("railgrip_health") && said.contains("\"helth\""), "{said}");
        assert!(filter("info,railgrip_health::alerts=debug").is_ok());
    }

    #[test]
    fn every_crate_that_logs_is_a_known_target() {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let mut logging = 0;
        for place in ["common", "services"] {
            for entry in std::fs::read_dir(root.join(place)).expect(place) {
                let folder = entry.expect("entry").path();
                let Ok(manifest) = std::fs::read_to_string(folder.join("Cargo.toml")) else { continue };
                if manifest.lines().any(|line| line.starts_with("tracing")) {
                    let name = folder.file_name().expect("a name").to_string_lossy().into_owned();
                    assert!(filter(&format!("info,railgrip_{name}=debug")).is_ok(), "{name}");
                    logging += 1;
                }
            }
        }
        assert!(logging >= 7, "{logging}");
    }
}
