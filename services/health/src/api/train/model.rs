//! What the API says of the train, as types.

use crate::api::grade::Grade;
use crate::api::processes::ProcessView;
use crate::api::wagons::model::WagonRow;
use serde::Serialize;
use std::collections::BTreeMap;
use utoipa::ToSchema;

/// Alerts that are active now.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, ToSchema)]
pub struct AlertCounts {
    /// Worth a look.
    pub watch: u32,
    /// Needs action.
    pub act: u32,
}

/// Messages of processes that were refused, because something in them cannot be.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct RefusedView {
    /// What kind of message: `health`, `heard` or `heartbeat`.
    pub payload: String,
    /// Why: `future_stamp`, `no_stamp`, `not_finite`, `out_of_range`, `reversed_interval`, `unknown_code`,
    /// `wrong_count` or `wrong_wagon`.
    pub reason: String,
    /// How many since the service started.
    pub count: u64,
}

/// What the source of samples has counted, and how its clock runs: of a wagon, or of the source as a whole.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct SourceView {
    /// The wagon; `null` for the source as a whole.
    pub wagon: Option<u32>,
    /// The number of its vehicle, as it is written; `null` without one.
    pub vehicle_number: Option<String>,
    /// How much faster our clock runs than that of the source, parts in a million; `null` while that is not known.
    pub clock_drift_ppm: Option<f64>,
    /// How often each thing happened since ingest started; what never happened is left out.
    pub counts: BTreeMap<String, u64>,
}

/// The train at a glance.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct TrainView {
    /// Name.
    pub name: String,
    /// When this was put together, RFC 3339.
    pub generated_at: String,
    /// True if every wagon is live.
    pub ready: bool,
    /// Worst grade of all wagons.
    pub grade: Grade,
    /// Where that comes from.
    pub reason: String,
    /// Number of wagons.
    pub wagons: u32,
    /// Wagons that are live.
    pub live: u32,
    /// Wagons whose news are old.
    pub stale: u32,
    /// Wagons of which nothing has arrived.
    pub silent: u32,
    /// Wagons by grade: those that need action, then those worth a look.
    pub worst: Vec<WagonRow>,
    /// Alerts that are active now.
    pub alerts: AlertCounts,
    /// True if its wagons are judged together, because they are coupled.
    pub judged_together: bool,
    /// Brake applications that were seen so far by who judges them; `null` where nobody does.
    pub brakings_judged: Option<u32>,
    /// Messages that were refused since the service started, by kind and reason.
    pub refused: Vec<RefusedView>,
    /// What the source of samples has counted; empty where samples are simulated or recorded.
    pub sources: Vec<SourceView>,
    /// Its processes.
    pub processes: Vec<ProcessView>,
}
