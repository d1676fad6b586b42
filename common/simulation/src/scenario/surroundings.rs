//! The track and what changes slowly and unseen.

use railgrip_vehicle::RailClass;
use serde::{Deserialize, Serialize};

/// The track as a whole.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TrackTable {
    /// Length over which one rail condition or grade turns into the next.
    pub transition_m: f64,
    /// One-sigma relative unevenness of the adhesion along the track.
    pub adhesion_variation: f64,
    /// Length over which the adhesion varies.
    pub variation_length_m: f64,
    /// Relative gain of adhesion under full sanding.
    pub sanding_gain: f64,
    /// Time constant of that gain.
    pub sanding_time_s: f64,
    /// Headwind.
    pub headwind_m_s: f64,
    /// Ratio A of the friction at infinite slip velocity to its maximum, where the rail's film makes it another than the vehicle
    /// file's.
    pub friction_ratio: Option<f64>,
    /// Decay B of friction with slip velocity, likewise.
    pub friction_decay_s_per_m: Option<f64>,
}

impl Default for TrackTable {
    fn default() -> Self {
        Self {
            transition_m: 10.0,
            adhesion_variation: 0.0,
            variation_length_m: 15.0,
            sanding_gain: 0.8,
            sanding_time_s: 0.5,
            headwind_m_s: 0.0,
            friction_ratio: None,
            friction_decay_s_per_m: None,
        }
    }
}

/// Rail condition from a position on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RailTable {
    /// Start of the stretch.
    pub from_m: f64,
    /// Rail class; its adhesion stands in the vehicle file.
    pub condition: RailClass,
    /// Adhesion available, where it differs from the vehicle file's.
    pub adhesion: Option<f64>,
}

/// Grade from a position on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GradeTable {
    /// Start of the stretch.
    pub from_m: f64,
    /// Slope, uphill positive.
    pub grade_rad: f64,
}

/// Slow random walks around the nominal values; first-order with the given standard deviation and correlation time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DisturbanceTable {
    /// Relative standard deviation of the pad friction over time, each wheelset for itself.
    pub pad_friction_sigma: f64,
    /// Correlation time of the pad friction.
    pub pad_friction_time_s: f64,
    /// Standard deviation of the pad friction's level from wheelset to wheelset.
    pub pad_friction_spread: f64,
    /// Standard deviation of gusts.
    pub gust_sigma_m_s: f64,
    /// Correlation time of gusts.
    pub gust_time_s: f64,
}

impl Default for DisturbanceTable {
    fn default() -> Self {
        Self {
            pad_friction_sigma: 0.006,
            pad_friction_time_s: 8.0,
            pad_friction_spread: 0.03,
            gust_sigma_m_s: 0.5,
            gust_time_s: 4.0,
        }
    }
}
