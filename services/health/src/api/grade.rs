//! The words that everything in the API shares: how an indicator is judged, whether news arrive, how the rail is.

use railgrip_messages as messages;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// How an indicator is judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Grade {
    /// Not enough (fresh) data to judge.
    Unknown,
    /// As it should be.
    Ok,
    /// Worth a look at the next occasion.
    Watch,
    /// Needs action.
    Act,
}

impl From<messages::Grade> for Grade {
    fn from(grade: messages::Grade) -> Self {
        match grade {
            messages::Grade::Unknown => Self::Unknown,
            messages::Grade::Ok => Self::Ok,
            messages::Grade::Watch => Self::Watch,
            messages::Grade::Act => Self::Act,
        }
    }
}

impl Grade {
    /// The word in JSON.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::Ok => "ok",
            Self::Watch => "watch",
            Self::Act => "act",
        }
    }
}

/// Whether news of a wagon arrive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum DataState {
    /// News arrive.
    Live,
    /// News arrived, but the last are old; see the age.
    Stale,
    /// Nothing has arrived since the service started.
    Silent,
}

impl DataState {
    /// The word in JSON.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Live => "live",
            Self::Stale => "stale",
            Self::Silent => "silent",
        }
    }
}

/// Condition of the rail.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Condition {
    /// Dry.
    Dry,
    /// Wet.
    Wet,
    /// Low adhesion.
    Low,
    /// Very low adhesion.
    VeryLow,
}

impl From<messages::Condition> for Condition {
    fn from(condition: messages::Condition) -> Self {
        match condition {
            messages::Condition::Dry => Self::Dry,
            messages::Condition::Wet => Self::Wet,
            messages::Condition::Low => Self::Low,
            messages::Condition::VeryLow => Self::VeryLow,
        }
    }
}

impl Condition {
    /// The word for people.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Dry => "dry",
            Self::Wet => "wet",
            Self::Low => "low",
            Self::VeryLow => "very low",
        }
    }
}
