//! What the interface says of notes, as types.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What a note is about.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum NoteKind {
    /// Words.
    #[default]
    Note,
    /// The brake pads were changed: trends of pad friction begin anew.
    PadsChanged,
}

/// Something that somebody wrote down about a vehicle.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Note {
    /// Number of the vehicle, letters and digits alone; its name where it has no number.
    pub vehicle: String,
    /// When, RFC 3339.
    pub at: String,
    /// Who: the name of the token where there is one.
    pub by: String,
    /// What it is about.
    pub kind: NoteKind,
    /// The words; absent where the kind says all.
    #[serde(default)]
    pub text: Option<String>,
}

/// Notes of a vehicle.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct NoteList {
    /// Where in the train it runs.
    pub wagon: u32,
    /// Its number, letters and digits alone; its name where it has no number.
    pub vehicle: String,
    /// Since when trends of pad friction count; `null` where no change of pads is noted.
    pub pads_changed_at: Option<String>,
    /// The latest notes, the newest first.
    pub notes: Vec<Note>,
}

/// What somebody wants to have written down.
#[derive(Debug, Clone, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct NoteRequest {
    /// Who, for example a name or a role. Where the request comes with a token, the token's name stands in its place.
    #[schema(value_type = String, required = true, min_length = 1, max_length = 100, pattern = "words")]
    #[serde(default)]
    pub by: Option<String>,
    /// What it is about.
    #[serde(default)]
    pub kind: NoteKind,
    /// The words.
    #[schema(min_length = 1, max_length = 500, pattern = "words")]
    pub text: String,
}
