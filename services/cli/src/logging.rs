//! Log lines on the standard error: text on a terminal, JSON otherwise, unless the config says which.

use std::io::IsTerminal;

use railgrip_settings::{LogFormat, LoggingSettings};
use tracing_subscriber::filter::{ParseError, Targets};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;
use tracing_subscriber::{Registry, fmt};

use crate::CliError;

/// The environment variable that overrides the level of the config.
const FILTER_VARIABLE: &str = "RAILGRIP_LOG";

/// Starts logging for this process. A second call changes nothing.
pub(crate) fn start(settings: &LoggingSettings) -> Result<(), CliError> {
    let wanted = std::env::var(FILTER_VARIABLE).unwrap_or_else(|_| settings.level.clone());
    let filter: Targets = wanted.parse().map_err(|error: ParseError| {
        let allowed =
            "allowed is off, error, warn, info, debug or trace, or a list such as `info,railgrip_bus=debug`";
        CliError::bad_input(format!("log level \"{wanted}\": {error}; {allowed}"))
    })?;
    let json = match settings.format {
        LogFormat::Auto => !std::io::stderr().is_terminal(),
        LogFormat::Text => false,
        LogFormat::Json => true,
    };
    let lines = fmt::layer().with_writer(std::io::stderr);
    let result = if json {
        Registry::default().with(filter).with(lines.json().with_span_list(false)).try_init()
    } else {
        let lines = lines.with_target(false).with_ansi(std::io::stderr().is_terminal());
        Registry::default().with(filter).with(lines).try_init()
    };
    if result.is_err() {
        tracing::debug!("logging runs already");
    }
    Ok(())
}
