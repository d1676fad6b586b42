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
use serde::Deserialize;
use std::collections::BTreeMap;

/// The whole file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TrainFile {
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

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TrainTable {
    pub name: String,
    pub wagons: Option<u32>,
    pub vehicle: Option<String>,
    pub coupled: Option<bool>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct WagonTable {
    pub name: Option<String>,
    pub number: Option<String>,
    #[serde(default)]
    pub turned: bool,
    pub vehicle: Option<String>,
    pub simulated: Option<String>,
    pub filter: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct SamplesTable {
    pub batch_ms: f64,
}

impl Default for SamplesTable {
    fn default() -> Self {
        Self { batch_ms: 20.0 }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct ReportingTable {
    pub snapshot_period_s: f64,
    pub health_rate_hz: f64,
}

impl Default for ReportingTable {
    fn default() -> Self {
        Self { snapshot_period_s: 1.0, health_rate_hz: 5.0 }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct LoggingTable {
    pub level: String,
    pub format: LogFormat,
}

impl Default for LoggingTable {
    fn default() -> Self {
        Self { level: "info".to_owned(), format: LogFormat::Auto }
    }
}

/// How log lines look.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LogFormat {
    /// Text on a terminal, JSON otherwise.
    Auto,
    /// Text.
    Text,
    /// One JSON object a line.
    Json,
}
