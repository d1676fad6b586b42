//! What a diagnosis of a law-level case is told, and what it gives.

use super::write::vehicle::Applied;
use crate::answer::schema::Report;
use crate::answer::supplement::Detail;
use railgrip_recording::Table;

/// What a diagnosis of a bench is told beside its case.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Candidates to leave out.
    pub without: Vec<String>,
    /// Seed of the bootstraps.
    pub seed: u64,
    /// Program and version, for the report's settings.
    pub version: String,
    /// The command line, for the report's settings.
    pub command: String,
}

/// What a diagnosis gives.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// `report.json`.
    pub report: Report,
    /// What the HTML report shows beside it.
    pub detail: Detail,
    /// The prediction file of each holdout file: name without ending, and table. See [`super::write_predictions`].
    pub predictions: Vec<(String, Table)>,
    /// What was found, for a vehicle.
    pub applied: Applied,
}
