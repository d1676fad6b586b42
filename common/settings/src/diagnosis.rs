//! `[diagnosis]`: whether the train diagnoses by itself what its model does not explain.

use crate::place::ConfigText;
use serde::{Deserialize, Serialize};

/// Whether and how long recordings of mismatches are diagnosed by the train itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DiagnosisSettings {
    /// Whether `railgrip up` starts a diagnoser.
    pub automatic: bool,
    /// A diagnosis that takes longer is given up, s.
    pub time_limit_s: f64,
}

#[derive(Debug, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct DiagnosisTable {
    /// Whether `railgrip up` starts a diagnoser of what the model does not explain.
    pub automatic: bool,
    /// A diagnosis that takes longer is given up, s.
    pub time_limit_s: f64,
}

impl Default for DiagnosisTable {
    fn default() -> Self {
        Self { automatic: true, time_limit_s: 1800.0 }
    }
}

impl DiagnosisTable {
    pub(crate) fn check(&self, at: &ConfigText) -> DiagnosisSettings {
        let time_limit_s = at.number("diagnosis.time_limit_s", self.time_limit_s, 10.0..=86_400.0);
        DiagnosisSettings { automatic: self.automatic, time_limit_s }
    }
}
