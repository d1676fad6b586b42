//! Where the errors of all libraries turn into exit codes.

use std::io::ErrorKind;
use std::process::ExitCode;

use railgrip_bus::BusError;
use railgrip_settings::SettingsError;

/// Why a command ended without success.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// The command could not do its work (exit code 1).
    #[error("{0}")]
    Failed(String),
    /// Input, config or arguments are wrong (exit code 2).
    #[error("{0}")]
    BadInput(String),
}

impl CliError {
    /// The command could not do its work.
    pub fn failed(reason: impl std::fmt::Display) -> Self {
        Self::Failed(reason.to_string())
    }

    /// Input, config or arguments are wrong.
    pub fn bad_input(reason: impl std::fmt::Display) -> Self {
        Self::BadInput(reason.to_string())
    }

    /// The number that the shell sees.
    #[must_use]
    pub fn code(&self) -> u8 {
        match self {
            Self::Failed(_) => 1,
            Self::BadInput(_) => 2,
        }
    }

    /// The same for `main`.
    #[must_use]
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(self.code())
    }
}

impl From<SettingsError> for CliError {
    fn from(error: SettingsError) -> Self {
        Self::bad_input(error)
    }
}

impl From<railgrip_ingest::IngestError> for CliError {
    fn from(error: railgrip_ingest::IngestError) -> Self {
        match error {
            railgrip_ingest::IngestError::Input(error) => Self::bad_input(error),
            railgrip_ingest::IngestError::Bus(error) => error.into(),
        }
    }
}

impl From<railgrip_estimator::EstimatorError> for CliError {
    fn from(error: railgrip_estimator::EstimatorError) -> Self {
        match error {
            railgrip_estimator::EstimatorError::Filter(error) => Self::bad_input(error),
            railgrip_estimator::EstimatorError::Bus(error) => error.into(),
        }
    }
}

impl From<railgrip_listener::ListenerError> for CliError {
    fn from(error: railgrip_listener::ListenerError) -> Self {
        use railgrip_listener::ListenerError;
        match error {
            ListenerError::Bus(error) => error.into(),
            ListenerError::NoMicrophone { .. } | ListenerError::Model(_) => Self::bad_input(error),
            ListenerError::Audio(_) => Self::failed(error),
        }
    }
}

impl From<railgrip_health::HealthError> for CliError {
    fn from(error: railgrip_health::HealthError) -> Self {
        match error {
            railgrip_health::HealthError::Bus(error) => error.into(),
            railgrip_health::HealthError::Access(error) => Self::failed(error),
            railgrip_health::HealthError::Serve { ref source, .. }
                if source.kind() == ErrorKind::AddrInUse =>
            {
                Self::failed(format!(
                    "{error}; choose another with --listen ADDRESS:PORT, port 0 for any free one"
                ))
            }
            railgrip_health::HealthError::Serve { .. } | railgrip_health::HealthError::CollectorPanicked => {
                Self::failed(error)
            }
        }
    }
}

impl From<railgrip_health::access::AccessError> for CliError {
    fn from(error: railgrip_health::access::AccessError) -> Self {
        match error {
            railgrip_health::access::AccessError::File { .. } => Self::failed(error),
            _ => Self::bad_input(error),
        }
    }
}

impl From<BusError> for CliError {
    fn from(error: BusError) -> Self {
        match error {
            BusError::Limit { .. }
            | BusError::PrefixTooLong { .. }
            | BusError::PrefixTaken { .. }
            | BusError::SharedMemoryFull { .. } => Self::bad_input(error),
            _ => Self::failed(error),
        }
    }
}
