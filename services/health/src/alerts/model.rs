//! An alert as the API gives it, as the journal keeps it and as receivers get it.
//!
//! Journals of earlier versions call a silence a shelf; they stay readable.

use super::diagnosis::Diagnosis;
use crate::api::grade::Grade;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// How far an alert reaches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Scope {
    /// One cause for the whole train, for example the rail: one alert that lists the wagons.
    Train,
    /// One wagon.
    Wagon,
}

/// What has become of an alert.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum AlertState {
    /// Somebody should look at it.
    Active,
    /// Somebody has acknowledged it; the cause is still there.
    Acknowledged,
    /// Silenced for a time.
    #[serde(alias = "shelved")]
    Silenced,
    /// The cause is gone.
    Cleared,
}

impl AlertState {
    /// The word in JSON.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Active => "active",
            Self::Acknowledged => "acknowledged",
            Self::Silenced => "silenced",
            Self::Cleared => "cleared",
        }
    }
}

/// One place at which the cause shows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct AlertPlace {
    /// The wagon.
    pub wagon: u32,
    /// The number of its vehicle; `null` where none is known.
    #[serde(default)]
    pub vehicle_number: Option<String>,
    /// The wheelset, 1 leading; `null` for the whole wagon.
    pub wheelset: Option<u32>,
    /// The indicator that shows it.
    pub indicator: String,
    /// How bad it is there now. What is well again, but not yet for long enough, is worth a look and needs no action.
    pub grade: Grade,
    /// Since when it is well there, RFC 3339; `null` while it is not.
    #[serde(default)]
    pub well_since: Option<String>,
    /// What happens there, in words.
    pub reason: String,
}

/// Where to see for oneself.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Evidence {
    /// The indicators of the worst wagon around the time of the alert: a path of this API.
    pub history: String,
    /// Folder with the latest minutes of samples, ready for `railgrip gap diagnose`, where one was kept.
    pub recording: Option<String>,
    /// What the diagnosis of that recording found; `null` until it is done.
    #[serde(default)]
    pub diagnosis: Option<Diagnosis>,
}

/// Who took notice.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Acknowledgement {
    /// Who.
    pub by: String,
    /// When, RFC 3339.
    pub at: String,
    /// What they said.
    pub note: Option<String>,
}

/// Silenced until a time, by whom and why.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Silence {
    /// Who.
    pub by: String,
    /// When, RFC 3339.
    pub at: String,
    /// Why.
    pub why: String,
    /// Until when, RFC 3339.
    pub until: String,
    /// The same, Unix ns.
    pub until_unix_ns: i64,
}

/// What happened to an alert.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Change {
    /// Raised.
    Raised,
    /// Became worse.
    Worse,
    /// Became less bad, but is not gone.
    Better,
    /// More wagons show the same cause.
    Spread,
    /// The cause came back soon after it had gone.
    Returned,
    /// Somebody took notice.
    Acknowledged,
    /// Somebody took the acknowledgement back.
    Unacknowledged,
    /// Silenced for a time.
    #[serde(alias = "shelved")]
    Silenced,
    /// No longer silenced.
    #[serde(alias = "unshelved")]
    Unsilenced,
    /// The cause is gone.
    Cleared,
    /// Became part of an alert of the whole train.
    Merged,
}

impl Change {
    /// The word in JSON.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Raised => "raised",
            Self::Worse => "worse",
            Self::Better => "better",
            Self::Spread => "spread",
            Self::Returned => "returned",
            Self::Acknowledged => "acknowledged",
            Self::Unacknowledged => "unacknowledged",
            Self::Silenced => "silenced",
            Self::Unsilenced => "unsilenced",
            Self::Cleared => "cleared",
            Self::Merged => "merged",
        }
    }

    /// Whether receivers are notified.
    #[must_use]
    pub const fn is_notified(self) -> bool {
        matches!(self, Self::Raised | Self::Worse | Self::Returned | Self::Cleared)
    }
}

/// One line of an alert's history.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct AlertEvent {
    /// When, RFC 3339.
    pub at: String,
    /// What happened.
    pub change: Change,
    /// How bad it was then.
    pub grade: Grade,
    /// Who did it; `null` if it came from the data.
    pub by: Option<String>,
    /// In words.
    pub note: Option<String>,
}

/// Something that asks for attention: one alert a cause.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Alert {
    /// Counts the alerts of this train.
    pub id: u64,
    /// What it is about, for example `brake_friction`.
    pub cause: String,
    /// How far it reaches.
    pub scope: Scope,
    /// The wagon; for an alert of the whole train the first that shows it.
    pub wagon: u32,
    /// The number of the vehicle that runs there; `null` where none is known.
    #[serde(default)]
    pub vehicle_number: Option<String>,
    /// The wheelset, 1 leading; `null` for the whole wagon.
    pub wheelset: Option<u32>,
    /// All wheelsets that it may be, where the wagons are judged together and no single one is told.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub wheelsets: Vec<u32>,
    /// All wagons that show it now, front first; when it is over, every wagon that did at some time.
    pub wagons: Vec<u32>,
    /// The vehicle numbers of `wagons`, one by one; `null` where none is known.
    #[serde(default)]
    pub vehicle_numbers: Vec<Option<String>>,
    /// Every wagon that has shown it since its cause last came, front first.
    #[serde(default)]
    pub affected: Vec<u32>,
    /// Each place that shows it now; when it is over, those that did last.
    pub places: Vec<AlertPlace>,
    /// How bad it was at its worst.
    pub grade: Grade,
    /// How bad it is now.
    pub grade_now: Grade,
    /// What happens, in words.
    pub reason: String,
    /// Probability of the cause, where the wagons are judged together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probability: Option<f64>,
    /// What it may be instead, likewise.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub instead: Vec<Instead>,
    /// Brake applications that had been seen when it was found, likewise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub brakings_seen: Option<u32>,
    /// What to do, in words.
    pub advice: String,
    /// Where to see for oneself.
    pub evidence: Evidence,
    /// False once the cause is gone.
    pub active: bool,
    /// What has become of it.
    pub state: AlertState,
    /// Who took notice.
    pub acknowledged: Option<Acknowledgement>,
    /// Silenced until a time.
    #[serde(alias = "shelved")]
    pub silenced: Option<Silence>,
    /// How often the cause came, this time included.
    pub times: u32,
    /// When it was raised, RFC 3339.
    pub raised_at: String,
    /// When it was cleared, RFC 3339.
    pub cleared_at: Option<String>,
    /// What happened to it, oldest first; at most 50 lines, the first of which stays.
    pub history: Vec<AlertEvent>,
    /// How often something happened to it.
    pub changes: u64,
    /// When its cause last came or went, Unix ns.
    pub unix_ns: i64,
}

/// Another cause that would explain the same.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Instead {
    /// The cause.
    pub cause: String,
    /// Its probability.
    pub probability: f64,
}

/// Alerts, active ones first, then the latest.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct AlertList {
    /// The alerts.
    pub alerts: Vec<Alert>,
    /// Where the next page is; absent on the last one.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub next: Option<String>,
}

/// Somebody acknowledges an alert, takes that back, or ends its silence.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct AcknowledgeRequest {
    /// Who, for example a name or a role. Where the request comes with a token, the token's name stands in its place.
    #[schema(min_length = 1, max_length = 100, pattern = "words")]
    pub by: String,
    /// What they say.
    #[schema(min_length = 1, max_length = 500, pattern = "words")]
    #[serde(default)]
    pub note: Option<String>,
}

/// Somebody silences an alert.
#[derive(Debug, Clone, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SilenceRequest {
    /// Who, for example a name or a role. Where the request comes with a token, the token's name stands in its place.
    #[schema(min_length = 1, max_length = 100, pattern = "words")]
    pub by: String,
    /// Why.
    #[schema(min_length = 1, max_length = 500, pattern = "words")]
    pub why: String,
    /// For so many seconds: a minute to 30 days.
    #[schema(minimum = 60, maximum = 2_592_000)]
    pub duration_s: f64,
}
