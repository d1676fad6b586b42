//! What the API says of wagons and wheelsets, as types: JSON and OpenAPI come from them.
//!
//! Every figure carries its interval, its grade and the reason in words. What is not known is `null`. What is stale says so
//! with its age; its grades are `unknown` then, and nothing that describes the present is given.

use crate::api::acoustic::AcousticView;
use crate::api::figures::Figures;
use crate::api::grade::{Condition, DataState, Grade};
use crate::api::processes::ProcessView;
use serde::Serialize;
use utoipa::ToSchema;

/// One line about a wagon.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WagonRow {
    /// Number in the train, 1 first.
    pub id: u32,
    /// Name.
    pub name: String,
    /// Number of the vehicle, wherever it runs; `null` where the config gives none.
    pub vehicle_number: Option<String>,
    /// Whether news arrive.
    pub state: DataState,
    /// Age of the last sample behind all this, s; `null` before the first.
    pub age_s: Option<f64>,
    /// Worst grade of all its indicators but those of the rail and the train.
    pub grade: Grade,
    /// Which indicator has that grade, and why.
    pub reason: String,
    /// Speed now, m/s.
    pub v_m_s: Option<f64>,
    /// Adhesion utilised now, signed: braking negative.
    pub adhesion: Option<f64>,
    /// Adhesion available.
    pub adhesion_available: Option<f64>,
    /// True if that is only a lower bound.
    pub adhesion_available_is_lower_bound: Option<bool>,
    /// Most probable condition of the rail.
    pub condition: Option<Condition>,
    /// Pad friction of the wagon, mean over braking.
    pub brake_friction: Option<f64>,
    /// Pad friction front minus rear, over their mean.
    pub asymmetry: Option<f64>,
    /// A wheelset slides or spins now.
    pub sliding: Option<bool>,
    /// A slide protection acts now.
    pub wsp_active: Option<bool>,
}

/// All wagons.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WagonList {
    /// Name of the train.
    pub train: String,
    /// When this was put together, RFC 3339.
    pub generated_at: String,
    /// One line a wagon, front first.
    pub wagons: Vec<WagonRow>,
    /// Where the next page is; absent on the last one.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    pub next: Option<String>,
}

/// What a live wagon does now.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Present {
    /// Speed, m/s.
    pub v_m_s: Option<f64>,
    /// Position along the track, m.
    pub position_m: Option<f64>,
    /// Adhesion utilised, signed: braking negative.
    pub adhesion: Option<f64>,
    /// Its 1 σ.
    pub adhesion_sigma: Option<f64>,
    /// Pad friction as estimated now, mean of the wheelsets.
    pub brake_friction_now: Option<f64>,
    /// Its 1 σ.
    pub brake_friction_now_sigma: Option<f64>,
    /// Pressing force of all wheelsets, N.
    pub pressing_force_n: Option<f64>,
    /// Sand on the rail, 0 to 1.
    pub sand: Option<f64>,
}

/// What a wheelset of a live wagon does now.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WheelsetPresent {
    /// Adhesion utilised, signed: braking negative.
    pub adhesion: Option<f64>,
    /// Its 1 σ.
    pub adhesion_sigma: Option<f64>,
    /// Pad friction as estimated now.
    pub brake_friction_now: Option<f64>,
    /// Its 1 σ.
    pub brake_friction_now_sigma: Option<f64>,
    /// The data determine the pad friction of this wheelset now.
    pub observable: bool,
    /// Creepage: negative sliding, positive spinning.
    pub creepage: Option<f64>,
    /// It slides or spins.
    pub sliding: bool,
    /// Its slide protection acts.
    pub wsp_active: bool,
}

/// One wheelset.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WheelsetView {
    /// Number in the wagon, 1 leading.
    pub id: u32,
    /// Worst grade of what is judged of it, alerts included.
    pub grade: Grade,
    /// What it does now; `null` unless the wagon is live.
    pub now: Option<WheelsetPresent>,
    /// Its indicators, each under the name of its field.
    #[serde(flatten)]
    #[schema(ignore)]
    pub indicators: Figures,
    /// Pad friction, mean over braking, over its nominal value.
    pub brake_friction_to_nominal: Option<f64>,
    /// True if the adhesion available is only a lower bound.
    pub adhesion_available_is_lower_bound: bool,
    /// Energy of all slides, J.
    pub slide_energy_j: f64,
    /// Time of all slides, s.
    pub slide_s: f64,
}

/// Everything about one wagon.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WagonView {
    /// Number in the train, 1 first.
    pub id: u32,
    /// Name.
    pub name: String,
    /// Number of the vehicle, wherever it runs; `null` where the config gives none.
    pub vehicle_number: Option<String>,
    /// Whether news arrive.
    pub state: DataState,
    /// Age of the last sample behind all this, s; `null` before the first.
    pub age_s: Option<f64>,
    /// When that sample was taken, RFC 3339.
    pub acquired_at: Option<String>,
    /// Worst grade of all its indicators but those of the rail and the train.
    pub grade: Grade,
    /// Which indicator has that grade, and why.
    pub reason: String,
    /// What it does now; `null` unless live.
    pub now: Option<Present>,
    /// Its indicators, each under the name of its field.
    #[serde(flatten)]
    #[schema(ignore)]
    pub indicators: Figures,
    /// True if the adhesion available is only a lower bound.
    pub adhesion_available_is_lower_bound: bool,
    /// The most probable condition of the rail; `null` if unknown.
    pub condition: Option<Condition>,
    /// Probability of dry rail; `null` if unknown, as all four.
    pub rail_dry: Option<f64>,
    /// Probability of wet rail.
    pub rail_wet: Option<f64>,
    /// Probability of low adhesion.
    pub rail_low: Option<f64>,
    /// Probability of very low adhesion.
    pub rail_very_low: Option<f64>,
    /// What its microphone hears; `null` without one.
    pub acoustic: Option<AcousticView>,
    /// Sensors that are missing, refused or dead now.
    pub faulty_sensors: Vec<String>,
    /// Brake applications so far.
    pub brake_applications: u64,
    /// When the latest of them began, RFC 3339.
    pub brake_applied_at: Option<String>,
    /// Braking so far, s.
    pub braking_s: f64,
    /// Samples taken in.
    pub samples: u64,
    /// Samples that never arrived.
    pub samples_missed: u64,
    /// Outputs refused by the gate of the filter.
    pub outputs_rejected: u64,
    /// Its wheelsets, leading first.
    pub wheelsets: Vec<WheelsetView>,
    /// Its estimator process.
    pub estimator: Option<ProcessView>,
}
