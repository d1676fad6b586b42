//! The form of a train's config file, key by key, before its values are checked. Units stand in the keys.

use crate::access::HttpTable;
use crate::alerts::AlertTable;
use crate::capability::CapabilityTable;
use crate::diagnosis::DiagnosisTable;
use crate::history::HistoryTable;
use crate::instance::InstanceTable;
use crate::mapping::RuleTable;
use crate::microphones::{AcousticTable, MicrophoneTable};
use crate::receivers::{DeliveryTable, NotifyTable, ReceiverTable};
use crate::source::SourceTable;
use railgrip_filter::EstimatorConfig;
use railgrip_indicators::IndicatorSettings;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The whole file.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TrainFile {
    /// Version of the form of the file; required.
    pub schema: u32,
    pub train: TrainTable,
    #[serde(default)]
    pub wagon: Vec<WagonTable>,
    #[serde(default)]
    pub microphone: Vec<MicrophoneTable>,
    #[serde(default)]
    pub acoustics: AcousticTable,
    #[serde(default)]
    pub instance: InstanceTable,
    pub source: SourceTable,
    #[serde(default)]
    pub mapping: BTreeMap<String, RuleTable>,
    #[serde(default)]
    pub samples: SamplesTable,
    #[serde(default)]
    pub estimator: EstimatorConfig,
    #[serde(default)]
    pub reporting: ReportingTable,
    #[serde(default)]
    pub indicators: IndicatorSettings,
    #[serde(default)]
    pub http: HttpTable,
    #[serde(default)]
    pub alerts: AlertTable,
    #[serde(default)]
    pub history: HistoryTable,
    #[serde(default)]
    pub receiver: Vec<ReceiverTable>,
    #[serde(default)]
    pub notify: NotifyTable,
    #[serde(default)]
    pub delivery: DeliveryTable,
    #[serde(default)]
    pub capability: CapabilityTable,
    #[serde(default)]
    pub diagnosis: DiagnosisTable,
    #[serde(default)]
    pub logging: LoggingTable,
}

#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TrainTable {
    /// Name of the train: 1 to 32 letters, digits, `-`, `_`, `.`; required.
    pub name: String,
    /// Number of wagons, unless `[[wagon]]` tables or recordings say how many, 1 to 200.
    pub wagons: Option<u32>,
    /// Vehicle file of every wagon that names none of its own, relative to this file.
    pub vehicle: Option<String>,
    /// Whether the wagons are judged together, true or false; without it, where every vehicle file says that its wagon runs coupled.
    pub coupled: Option<bool>,
}

#[derive(Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct WagonTable {
    /// Name for people; without it that of its recording, or `wagon-N`.
    pub name: Option<String>,
    /// Vehicle number, to which what is remembered belongs; without one the wagon starts fresh with every start of the train.
    pub number: Option<String>,
    /// It runs with its other end first: its last wheelset leads.
    #[serde(default)]
    pub turned: bool,
    /// Its own vehicle file, relative to this file; without it that of the train.
    pub vehicle: Option<String>,
    /// Vehicle file that the simulation alone takes: what the estimator is not told.
    pub simulated: Option<String>,
    /// Its own filter; without it that of `[estimator]`.
    pub filter: Option<String>,
}

#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct SamplesTable {
    /// Samples of so many milliseconds travel together, ms.
    pub batch_ms: f64,
}

impl Default for SamplesTable {
    fn default() -> Self {
        Self { batch_ms: 20.0 }
    }
}

#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct ReportingTable {
    /// Time between two snapshots of an estimator, s.
    pub snapshot_period_s: f64,
    /// How often indicators are published, Hz.
    pub health_rate_hz: f64,
}

impl Default for ReportingTable {
    fn default() -> Self {
        Self { snapshot_period_s: 1.0, health_rate_hz: 5.0 }
    }
}

#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct LoggingTable {
    /// Level, or a filter such as `info,railgrip_bus=debug`.
    pub level: String,
    /// How log lines look; `auto` is text on a terminal and JSON otherwise.
    pub format: LogFormat,
}

impl Default for LoggingTable {
    fn default() -> Self {
        Self { level: "info".to_owned(), format: LogFormat::Auto }
    }
}

/// How log lines look.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LogFormat {
    /// Text on a terminal, JSON otherwise.
    Auto,
    /// Text.
    Text,
    /// One JSON object a line.
    Json,
}
