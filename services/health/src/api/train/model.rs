//! What the API says of the train, as types.

use crate::api::grade::Grade;
use crate::api::processes::ProcessView;
use crate::api::wagons::model::WagonRow;
use serde::Serialize;
use utoipa::ToSchema;

/// Alerts that are active now.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, ToSchema)]
pub struct AlertCounts {
    /// Worth a look.
    pub watch: u32,
    /// Needs action.
    pub act: u32,
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
    /// Its processes.
    pub processes: Vec<ProcessView>,
}
