//! Scenario files: what a simulated train does, on which track, with which faults. Units stand in the keys.

pub(crate) use check::signal_of;
pub use file::BUILT_IN;

mod check;
mod file;

use railgrip_vehicle::RailClass;
use serde::{Deserialize, Serialize};

/// A scenario file, schema 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Layout of the file; only 1 is known.
    pub schema: u32,
    /// Name for people.
    pub name: String,
    /// Length of a recording.
    pub duration_s: f64,
    /// A live train begins its programme anew after this time, standing again at its start. Absent: it goes on.
    pub repeat_s: Option<f64>,
    /// Speed at the start.
    #[serde(default)]
    pub start_speed_m_s: f64,
    /// The wagons.
    pub train: TrainTable,
    /// What the driver asks for, in the order of time.
    pub demand: Vec<DemandTable>,
    /// Traction equipment.
    #[serde(default)]
    pub traction: TractionTable,
    /// Train brake and cylinders.
    #[serde(default)]
    pub brake: BrakeTable,
    /// Wheel-slide protection.
    #[serde(default)]
    pub wsp: WspTable,
    /// The track as a whole.
    #[serde(default)]
    pub track: TrackTable,
    /// Rail condition along the track, in the order of position.
    #[serde(default)]
    pub rail: Vec<RailTable>,
    /// Grade along the track, in the order of position.
    #[serde(default)]
    pub grade: Vec<GradeTable>,
    /// What changes slowly and unseen.
    #[serde(default)]
    pub disturbance: DisturbanceTable,
    /// Sensors beyond what the vehicle file declares.
    #[serde(default)]
    pub sensors: SensorTable,
    /// What differs on single wagons.
    #[serde(default)]
    pub wagon: Vec<WagonTable>,
    /// Sensor faults.
    #[serde(default)]
    pub fault: Vec<FaultTable>,
    /// Couplers; absent: wagons do not pull on each other.
    pub couplers: Option<CouplerTable>,
}

/// The wagons of the train.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainTable {
    /// Number of wagons.
    pub wagons: usize,
    /// Length of a wagon over couplers.
    #[serde(default = "default_wagon_length_m")]
    pub wagon_length_m: f64,
    /// Vehicle file, relative to the scenario file.
    pub vehicle: Option<std::path::PathBuf>,
}

fn default_wagon_length_m() -> f64 {
    26.4
}

/// One phase of the driver's programme; exactly one of traction, brake, cruise and coast.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DemandTable {
    /// Start of the phase; it lasts until the next begins.
    pub from_s: f64,
    /// Share of full traction, 0 to 1.
    pub traction: Option<f64>,
    /// Share of full service braking, 0 to 1.
    pub brake: Option<f64>,
    /// Speed to hold.
    pub cruise_m_s: Option<f64>,
    /// Neither traction nor brake.
    #[serde(default)]
    pub coast: bool,
    /// Sanding, 0 to 1.
    #[serde(default)]
    pub sanding: f64,
}

/// Traction: the same share of effort on every wheelset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TractionTable {
    /// Acceleration at full traction and low speed.
    pub acceleration_m_s2: f64,
    /// Speed above which power, not effort, is constant.
    pub full_power_speed_m_s: f64,
    /// Time constant of the effort.
    pub response_time_s: f64,
    /// Whether effort is taken back from a spinning wheelset.
    pub spin_protection: bool,
}

impl Default for TractionTable {
    fn default() -> Self {
        Self {
            acceleration_m_s2: 0.8,
            full_power_speed_m_s: 16.0,
            response_time_s: 0.4,
            spin_protection: true,
        }
    }
}

/// Train brake: pipe, relay and cylinders.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BrakeTable {
    /// Deceleration at full service braking with nominal pads on a level dry track; sets the full pressing force.
    pub full_service_deceleration_m_s2: f64,
    /// Cylinder pressure at full service braking.
    pub full_pressure_pa: f64,
    /// Pressure below which the return spring holds the pads off.
    pub spring_pressure_pa: f64,
    /// Speed of a brake command along the train.
    pub propagation_speed_m_s: f64,
    /// Dead time of the distributor.
    pub dead_time_s: f64,
    /// Time constant of filling.
    pub fill_time_s: f64,
    /// Time constant of venting.
    pub vent_time_s: f64,
}

impl Default for BrakeTable {
    fn default() -> Self {
        Self {
            full_service_deceleration_m_s2: 1.1,
            full_pressure_pa: 3.8e5,
            spring_pressure_pa: 3e4,
            propagation_speed_m_s: 280.0,
            dead_time_s: 0.25,
            fill_time_s: 1.3,
            vent_time_s: 1.6,
        }
    }
}

/// Wheel-slide protection after the manner of EN 15595: a valve a wheelset that applies, holds or vents.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WspTable {
    /// Whether the wagons have it.
    pub enabled: bool,
    /// Relative slide from which pressure is held.
    pub hold_slip: f64,
    /// Relative slide from which pressure is vented.
    pub vent_slip: f64,
    /// Deceleration of the rim from which pressure is held or, beyond the hold slip, vented.
    pub rim_deceleration_m_s2: f64,
    /// Vehicle speed below which it does not act.
    pub minimum_speed_m_s: f64,
    /// Dead time of the valves.
    pub valve_dead_time_s: f64,
    /// Time constant of venting through the valve.
    pub valve_vent_time_s: f64,
    /// Time constant of filling through the valve.
    pub valve_fill_time_s: f64,
    /// Length of an apply pulse while it is active.
    pub apply_pulse_s: f64,
    /// Pause between two apply pulses.
    pub apply_pause_s: f64,
}

impl Default for WspTable {
    fn default() -> Self {
        Self {
            enabled: true,
            hold_slip: 0.05,
            vent_slip: 0.14,
            rim_deceleration_m_s2: 2.8,
            minimum_speed_m_s: 1.4,
            valve_dead_time_s: 0.02,
            valve_vent_time_s: 0.12,
            valve_fill_time_s: 0.15,
            apply_pulse_s: 0.04,
            apply_pause_s: 0.12,
        }
    }
}

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
}

fn one() -> f64 {
    1.0
}

/// Couplers between neighbours: spring and damper without slack.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CouplerTable {
    /// Stiffness.
    pub stiffness_n_per_m: f64,
    /// Damping.
    pub damping_n_s_per_m: f64,
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
