//! Where the health service remembers indicators, and for how long.

use crate::instance::systemd_state;
use crate::place::ConfigText;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// The history of a train.
#[derive(Debug, Clone, PartialEq)]
pub struct HistorySettings {
    /// Whether there is one at all.
    pub enabled: bool,
    /// Folder of its database.
    pub dir: PathBuf,
    /// Time between two writes, s: what a power cut may take.
    pub flush_s: f64,
    /// What is kept of each tier: buckets of a second, a minute and an hour.
    pub tiers: [TierLimits; 3],
    /// Age at which events go, days.
    pub event_days: f64,
}

/// What is kept of one tier; whichever limit is reached first counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TierLimits {
    /// Age at which data go, days.
    pub days: f64,
    /// Size above which the oldest data go, MB.
    pub megabytes: f64,
}

/// The table `[history]`.
#[derive(Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct HistoryTable {
    /// Whether the train remembers what it was like.
    enabled: bool,
    /// Folder of its database; without it the state folder of systemd, of the instance or of the user.
    dir: Option<String>,
    /// Time between two writes, s: what a power cut may take.
    flush_s: f64,
    /// Age at which buckets of a second go, days.
    second_days: f64,
    /// Size above which the oldest buckets of a second go, MB.
    second_mb: f64,
    /// Age at which buckets of a minute go, days.
    minute_days: f64,
    /// Size above which the oldest buckets of a minute go, MB.
    minute_mb: f64,
    /// Age at which buckets of an hour go, days.
    hour_days: f64,
    /// Size above which the oldest buckets of an hour go, MB.
    hour_mb: f64,
    /// Age at which events go, days.
    event_days: f64,
}

impl Default for HistoryTable {
    fn default() -> Self {
        Self {
            enabled: true,
            dir: None,
            flush_s: 30.0,
            second_days: 7.0,
            second_mb: 2000.0,
            minute_days: 92.0,
            minute_mb: 1000.0,
            hour_days: 3653.0,
            hour_mb: 500.0,
            event_days: 3653.0,
        }
    }
}

impl HistorySettings {
    /// The database file.
    #[must_use]
    pub fn database(&self) -> PathBuf {
        self.dir.join("history.db")
    }

    pub(crate) fn of(
        at: &ConfigText<'_>,
        table: &HistoryTable,
        train: &str,
        instance_override: Option<&Path>,
    ) -> Self {
        let days = |key: &str, value| at.number(&format!("history.{key}"), value, 0.01..=36_525.0);
        let size = |key: &str, value| at.number(&format!("history.{key}"), value, 1.0..=1e6);
        let dir = match &table.dir {
            Some(given) => at.file.parent().unwrap_or(Path::new("")).join(given),
            None => state_folder(train, instance_override),
        };
        let absolute = std::path::absolute(&dir)
            .map_err(|error| at.refuse("history.dir", dir.display(), format!("a folder ({error})")));
        Self {
            enabled: table.enabled,
            dir: at.or(absolute, dir),
            flush_s: at.number("history.flush_s", table.flush_s, 0.1..=600.0),
            tiers: [
                TierLimits {
                    days: days("second_days", table.second_days),
                    megabytes: size("second_mb", table.second_mb),
                },
                TierLimits {
                    days: days("minute_days", table.minute_days),
                    megabytes: size("minute_mb", table.minute_mb),
                },
                TierLimits {
                    days: days("hour_days", table.hour_days),
                    megabytes: size("hour_mb", table.hour_mb),
                },
            ],
            event_days: days("event_days", table.event_days),
        }
    }
}

/// A folder that survives a power cut: systemd's state folder, a folder in the given instance, or the user's.
fn state_folder(train: &str, instance_override: Option<&Path>) -> PathBuf {
    let variable = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let of_instance = || instance_override.map(|dir| dir.join("history"));
    let of_user = || {
        variable("XDG_STATE_HOME")
            .or_else(|| variable("HOME").map(|home| home.join(".local/state")))
            .map(|dir| dir.join("railgrip").join(train))
    };
    systemd_state(train)
        .or_else(of_instance)
        .or_else(of_user)
        .unwrap_or_else(|| std::env::temp_dir().join("railgrip").join(train))
}
