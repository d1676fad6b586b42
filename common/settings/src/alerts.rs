//! `[alerts]`: when an alert is raised, grouped and cleared, and where alerts are kept.

use crate::place::ConfigText;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// When an alert is raised, grouped and cleared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlertSettings {
    /// A cause must last so many seconds before an alert is raised.
    pub raise_after_s: f64,
    /// A cause must be gone for so many seconds before its alert is cleared; doubled each time it comes back.
    pub clear_after_s: f64,
    /// A cause that comes back within so many seconds is the same alert.
    pub reopen_within_s: f64,
    /// One alert for the train when this share of its wagons has the cause, 0 to 1.
    pub group_share: f64,
    /// And at least so many wagons.
    pub group_least: u32,
}

impl Default for AlertSettings {
    fn default() -> Self {
        Self {
            raise_after_s: 2.0,
            clear_after_s: 10.0,
            reopen_within_s: 600.0,
            group_share: 0.5,
            group_least: 3,
        }
    }
}

#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct AlertTable {
    /// A cause must last so long before an alert is raised, s.
    raise_after_s: f64,
    /// A cause must be gone for so long before its alert is cleared, s; doubled each time it comes back.
    clear_after_s: f64,
    /// A cause that comes back within so long is the same alert, s.
    reopen_within_s: f64,
    /// One alert for the train when this share of its wagons has the cause, 0 to 1.
    group_share: f64,
    /// And at least so many wagons.
    group_least: u32,
    /// Database of alerts and of the notification log; without it `alerts.db` in the folder of the history.
    journal: Option<String>,
}

impl Default for AlertTable {
    fn default() -> Self {
        let settings = AlertSettings::default();
        Self {
            raise_after_s: settings.raise_after_s,
            clear_after_s: settings.clear_after_s,
            reopen_within_s: settings.reopen_within_s,
            group_share: settings.group_share,
            group_least: settings.group_least,
            journal: None,
        }
    }
}

impl AlertTable {
    pub(crate) fn check(&self, at: &ConfigText<'_>) -> AlertSettings {
        at.number("alerts.group_least", f64::from(self.group_least), 2.0..=1000.0);
        AlertSettings {
            raise_after_s: at.number("alerts.raise_after_s", self.raise_after_s, 0.0..=3600.0),
            clear_after_s: at.number("alerts.clear_after_s", self.clear_after_s, 0.0..=3600.0),
            reopen_within_s: at.number("alerts.reopen_within_s", self.reopen_within_s, 0.0..=86_400.0),
            group_share: at.number("alerts.group_share", self.group_share, 0.05..=1.0),
            group_least: self.group_least,
        }
    }

    /// Where alerts and the notification log are kept: as given, relative to the config, else in the folder of the history.
    pub(crate) fn journal(&self, at: &ConfigText<'_>, history_dir: &Path) -> PathBuf {
        match &self.journal {
            Some(given) => at.beside(given),
            None => history_dir.join("alerts.db"),
        }
    }
}
