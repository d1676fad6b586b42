//! What the API says, as types: JSON and OpenAPI come from them.
//!
//! Every figure carries its interval, its grade and the reason in words. What is not known is `null`. What is stale says so
//! with its age; its grades are `unknown` then, and nothing that describes the present is given.

pub use crate::alerts::model::{Alert, AlertList};
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

/// What the microphone of a wagon hears, window by window of one second. Advice only: nothing drives a brake.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct AcousticView {
    /// `heard`, or why there is no probability: `starting`, `no_audio`, `silent_microphone`, `clipped`,
    /// `wrong_sample_rate`, `not_finite`, `too_short`, `standstill`, `unfamiliar`; `silent` if its listener is.
    pub state: String,
    /// Age of the last window, s; `null` before the first.
    pub age_s: Option<f64>,
    /// When its last sample was taken, RFC 3339.
    pub acquired_at: Option<String>,
    /// Probability that the rail is wet; `null` unless `heard`.
    pub wet_probability: Option<f64>,
    /// Condition assigned; `null` unless `heard`.
    pub condition: Option<Condition>,
    /// Level under full scale, dB.
    pub level_db: Option<f64>,
    /// Blocks of audio that never arrived.
    pub missed: u64,
    /// What the decision-maker makes of it with slip and adhesion as measured; `null` while they say nothing.
    pub decision: Option<DecisionView>,
}

/// Heard condition set beside measured slip and adhesion (Shrestha et al., section 3.3).
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct DecisionView {
    /// Condition to go by.
    pub condition: Option<Condition>,
    /// True if curve and measurement differ by more than 0.2, so that the decision before stands.
    pub kept: bool,
    /// Adhesion to go by.
    pub adhesion: f64,
    /// Slip at which the curve of that condition peaks at this speed.
    pub optimum_slip: f64,
    /// Adhesion there.
    pub optimum_adhesion: f64,
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

/// One judged figure.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct Figure {
    /// The figure; `null` if unknown.
    pub value: Option<f64>,
    /// Lower end of its 95 % interval.
    pub low: Option<f64>,
    /// Upper end of its 95 % interval.
    pub high: Option<f64>,
    /// How it is judged.
    pub grade: Grade,
    /// Why, in words.
    pub reason: String,
}

/// One line about a wagon.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WagonRow {
    /// Number in the train, 1 first.
    pub id: u32,
    /// Name.
    pub name: String,
    /// Whether news arrive.
    pub state: DataState,
    /// Age of the last sample behind all this, s; `null` before the first.
    pub age_s: Option<f64>,
    /// Worst grade of all its indicators.
    pub grade: Grade,
    /// Which indicator has that grade, and why.
    pub reason: String,
    /// Speed now, m/s.
    pub v_m_s: Option<f64>,
    /// Adhesion utilised now, magnitude.
    pub adhesion_utilised: Option<f64>,
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
    pub v_m_s: f64,
    /// Position along the track, m; 0 if unknown.
    pub position_m: f64,
    /// Adhesion utilised, signed: braking negative.
    pub adhesion: f64,
    /// Its 1 σ.
    pub adhesion_sigma: f64,
    /// Pad friction as estimated now, mean of the wheelsets.
    pub brake_friction: f64,
    /// Its 1 σ.
    pub brake_friction_sigma: f64,
}

/// Condition of the rail, with the probability of each.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct RailView {
    /// The most probable condition; `null` if unknown.
    pub condition: Option<Condition>,
    /// Probability of dry rail.
    pub dry: f64,
    /// Probability of wet rail.
    pub wet: f64,
    /// Probability of low adhesion.
    pub low: f64,
    /// Probability of very low adhesion.
    pub very_low: f64,
    /// How it is judged.
    pub grade: Grade,
    /// Why, in words.
    pub reason: String,
}

/// What a wheelset of a live wagon does now.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WheelsetPresent {
    /// Adhesion utilised, signed: braking negative.
    pub adhesion: f64,
    /// Its 1 σ.
    pub adhesion_sigma: f64,
    /// Pad friction as estimated now.
    pub brake_friction: f64,
    /// Its 1 σ.
    pub brake_friction_sigma: f64,
    /// The data determine the pad friction of this wheelset now.
    pub observable: bool,
    /// Creepage: negative sliding, positive spinning.
    pub creepage: f64,
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
    /// What it does now; `null` unless the wagon is live.
    pub now: Option<WheelsetPresent>,
    /// Pad friction, mean over braking.
    pub brake_friction: Figure,
    /// That over its nominal value.
    pub brake_friction_to_nominal: Option<f64>,
    /// Pad friction referred to standard conditions: speed, pressing force, disc temperature.
    pub brake_friction_standard: Figure,
    /// Share of the latest braking during which it had no brake while others had.
    pub isolated: Figure,
    /// Largest adhesion utilised of late.
    pub adhesion_utilised: Figure,
    /// Adhesion available.
    pub adhesion_available: Figure,
    /// True if that is only a lower bound.
    pub adhesion_available_is_lower_bound: bool,
    /// Slides counted.
    pub slides: Figure,
    /// Energy of all slides, J.
    pub slide_energy_j: f64,
    /// Time of all slides, s.
    pub slide_s: f64,
    /// Share of the latest braking with slide protection.
    pub wsp_share: Figure,
}

/// A process of the train.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct ProcessView {
    /// `ingest`, `estimator`, ...
    pub process: String,
    /// The wagon it serves.
    pub wagon: Option<u32>,
    /// Process id.
    pub pid: u32,
    /// Since its last sign of life, s.
    pub age_s: f64,
    /// Since it started, s.
    pub uptime_s: f64,
    /// Samples taken in.
    pub received: u64,
    /// Samples that never arrived.
    pub missed: u64,
    /// Samples or values refused.
    pub rejected: u64,
    /// Samples or estimates sent.
    pub published: u64,
    /// Median duration of one step of the filter, ns.
    pub step_p50_ns: u64,
    /// 99th percentile of the duration of one step of the filter, ns.
    pub step_p99_ns: u64,
    /// Median time from acquisition to publication, ns.
    pub latency_p50_ns: u64,
    /// 99th percentile of the time from acquisition to publication, ns.
    pub latency_p99_ns: u64,
}

/// Everything about one wagon.
#[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
pub struct WagonView {
    /// Number in the train, 1 first.
    pub id: u32,
    /// Name.
    pub name: String,
    /// Whether news arrive.
    pub state: DataState,
    /// Age of the last sample behind all this, s; `null` before the first.
    pub age_s: Option<f64>,
    /// When that sample was taken, RFC 3339.
    pub acquired_at: Option<String>,
    /// Worst grade of all its indicators.
    pub grade: Grade,
    /// Which indicator has that grade, and why.
    pub reason: String,
    /// What it does now; `null` unless live.
    pub now: Option<Present>,
    /// Pad friction, mean over braking.
    pub brake_friction: Figure,
    /// Pad friction front minus rear, over their mean.
    pub asymmetry: Figure,
    /// Largest adhesion utilised of late.
    pub adhesion_utilised: Figure,
    /// Adhesion available.
    pub adhesion_available: Figure,
    /// True if that is only a lower bound.
    pub adhesion_available_is_lower_bound: bool,
    /// Condition of the rail.
    pub rail: RailView,
    /// What its microphone hears; `null` without one.
    pub acoustic: Option<AcousticView>,
    /// Slides counted on all wheelsets.
    pub slides: Figure,
    /// Share of the latest braking with any slide protection.
    pub wsp_share: Figure,
    /// Share of sensor values missing or refused.
    pub sensors: Figure,
    /// Mean normalised innovation squared over its degrees of freedom; 1 is ideal.
    pub filter: Figure,
    /// Pad friction referred to standard conditions: speed, pressing force, disc temperature.
    pub brake_friction_standard: Figure,
    /// Time from the first pressing force to 90 % of its level, s: median of the latest brake applications.
    pub response: Figure,
    /// How much later than its place in the train explains it begins to brake, s: median of the latest applications.
    pub brake_delay: Figure,
    /// Retarding force while the brakes are released, beyond running resistance, N.
    pub dragging: Figure,
    /// Share of the latest braking during which the worst wheelset had no brake while others had.
    pub isolated: Figure,
    /// Adhesion in slides with sand over adhesion in slides without.
    pub sanding: Figure,
    /// Whether the model explains the data for long: as `filter`, over longer times.
    pub model: Figure,
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

/// Whether the service, or the train behind it, is as it should be.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
pub struct Check {
    /// `ok`, or what is not.
    pub status: String,
    /// What is missing, in words.
    pub reasons: Vec<String>,
}
