//! Scenario files: what a simulated train does, on which track, with which faults. Units stand in the keys.

mod check;
mod equipment;
mod exceptions;
mod file;
mod surroundings;

pub(crate) use check::signal_of;
pub use equipment::{BrakeTable, CouplerTable, TractionTable, WspTable};
pub use exceptions::{FaultKind, FaultTable, SensorTable, WagonTable};
pub use file::BUILT_IN;
pub use surroundings::{DisturbanceTable, GradeTable, RailTable, TrackTable};

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
