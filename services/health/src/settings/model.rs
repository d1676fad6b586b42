//! What the interface says of settings, as types.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// A threshold or another number by which indicators are computed and judged.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Setting {
    /// Dotted key below `[indicators]` in the config file.
    pub key: String,
    /// What it says, with its unit.
    pub words: String,
    /// What holds now.
    pub value: f64,
    /// What the file says for the next start; `null` where it cannot be read.
    pub next: Option<f64>,
    /// What holds where the file is silent.
    pub default: f64,
    /// Least and greatest value.
    pub range: [f64; 2],
}

/// All of them.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct SettingList {
    /// The config file; absent where the built-in config holds.
    pub file: Option<String>,
    /// Whether a start would change something.
    pub waits_for_start: bool,
    /// The settings.
    pub settings: Vec<Setting>,
}

/// A change of one setting.
#[derive(Debug, Clone, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct SettingRequest {
    /// Dotted key below `[indicators]`.
    pub key: String,
    /// The new value.
    pub value: f64,
    /// Who. Where the request comes with a token, the token's name stands in its place.
    #[schema(min_length = 1, max_length = 100)]
    #[serde(default)]
    pub by: Option<String>,
    /// Why.
    #[schema(min_length = 1, max_length = 500)]
    pub why: String,
}
