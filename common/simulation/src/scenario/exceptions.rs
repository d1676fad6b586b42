//! Sensors, and what is out of the ordinary: single wagons, faults.

use railgrip_vehicle::RailClass;
use serde::{Deserialize, Serialize};

/// Sensors beyond the sigmas of the vehicle file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorTable {
    /// Factor on all sigmas of the vehicle file; 0 = noiseless.
    pub noise_factor: f64,
    /// Delay of the vehicle speed.
    pub speed_latency_s: f64,
    /// Delay of the wheel speeds.
    pub wheel_speed_latency_s: f64,
    /// Delay of the pressing forces.
    pub pressing_force_latency_s: f64,
    /// Step of the vehicle speed's digits; 0 = none.
    pub speed_resolution_m_s: f64,
    /// Step of the wheel speeds' digits; 0 = none.
    pub wheel_speed_resolution_rad_s: f64,
    /// Step of the pressing forces' digits; 0 = none.
    pub pressing_force_resolution_n: f64,
    /// White noise of the satellite position.
    pub position_sigma_m: f64,
    /// Slow error of the satellite position.
    pub position_bias_sigma_m: f64,
    /// Correlation time of that slow error.
    pub position_bias_time_s: f64,
    /// Probability that a measured value is missing from a sample.
    pub missing_probability: f64,
    /// Probability that a measured value is a spike.
    pub spike_probability: f64,
    /// Height of such spikes in sigmas.
    pub spike_sigmas: f64,
}

impl Default for SensorTable {
    fn default() -> Self {
        Self {
            noise_factor: 1.0,
            speed_latency_s: 0.0,
            wheel_speed_latency_s: 0.0,
            pressing_force_latency_s: 0.0,
            speed_resolution_m_s: 1e-4,
            wheel_speed_resolution_rad_s: 1e-4,
            pressing_force_resolution_n: 1.0,
            position_sigma_m: 0.3,
            position_bias_sigma_m: 1.0,
            position_bias_time_s: 120.0,
            missing_probability: 0.0,
            spike_probability: 0.0,
            spike_sigmas: 30.0,
        }
    }
}

/// What differs on one wagon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WagonTable {
    /// Number of the wagon, 1 at the front.
    pub number: usize,
    /// Factor on the adhesion under its wheels, everywhere.
    #[serde(default = "one")]
    pub adhesion_factor: f64,
    /// Rail class that its recording is named after, where its adhesion is not that of the track.
    pub rail: Option<RailClass>,
    /// Factor on the pad friction of each wheelset, front first; missing entries are 1.
    #[serde(default)]
    pub pad_friction_factors: Vec<f64>,
    /// Factor on the mass.
    #[serde(default = "one")]
    pub mass_factor: f64,
    /// Whether its wheel-slide protection is out of order.
    #[serde(default)]
    pub wsp_isolated: bool,
    /// Wheelsets whose brake gets no air, counted from 1 at the front.
    #[serde(default)]
    pub isolated_wheelsets: Vec<usize>,
    /// Its brake acts so much later than its place in the train explains.
    #[serde(default)]
    pub brake_delay_s: f64,
    /// Factor on the time constant of filling.
    #[serde(default = "one")]
    pub fill_time_factor: f64,
    /// Pads that do not release: a pressing force on each wheelset that no pressure sensor sees.
    #[serde(default)]
    pub dragging_force_n: f64,
}

fn one() -> f64 {
    1.0
}

/// A sensor fault of one wagon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FaultTable {
    /// Number of the wagon, 1 at the front.
    pub wagon: usize,
    /// Column as in a recording, for example `omega_f_rad_s`; not for `silent`.
    pub signal: Option<String>,
    /// What happens.
    pub kind: FaultKind,
    /// Start, in the time of the programme.
    pub from_s: f64,
    /// End.
    pub until_s: f64,
    /// Size of an offset or spike in the unit of the signal.
    #[serde(default)]
    pub value: f64,
}

/// Kinds of sensor faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FaultKind {
    /// The last value before the fault is repeated.
    Stuck,
    /// The value is missing.
    Missing,
    /// `value` is added to every tenth sample.
    Spike,
    /// `value` is added.
    Offset,
    /// The wagon sends no sample at all.
    Silent,
}
