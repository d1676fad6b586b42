//! Where samples come from, and when each is due.

mod lines;
mod replay;
mod rig;
mod simulate;

pub use lines::{Lines, parse_line};
pub use replay::Replay;
pub use rig::{Rigs, feed_of};
pub use simulate::Simulated;

use railgrip_filter::PlantKind;
use railgrip_recording::{BogieRow, MotorRow, Row};
use railgrip_settings::{Source, TrainSettings};

/// One thing that came from a source.
#[derive(Debug)]
pub enum Arrival<'a> {
    /// A sample of a wagon (counted from 0).
    Row {
        /// Index of the wagon.
        wagon: usize,
        /// Its values; NaN = missing.
        row: &'a Row,
        /// Wheelsets of the wagon.
        wheelsets: usize,
        /// Seconds after the start of the source at which it is due.
        due_s: f64,
        /// The time base begins anew with it.
        begins: bool,
    },
    /// A sample of a driven rig (counted from 0 like wagons).
    Motor {
        /// Index of the wagon.
        wagon: usize,
        /// Its values; NaN = missing.
        row: &'a MotorRow,
        /// Seconds after the start of the source at which it is due.
        due_s: f64,
        /// The time base begins anew with it.
        begins: bool,
    },
    /// A sample of a bogie rig (counted from 0 like wagons).
    Bogie {
        /// Index of the wagon.
        wagon: usize,
        /// Its values; NaN = missing.
        row: &'a BogieRow,
        /// Seconds after the start of the source at which it is due.
        due_s: f64,
        /// The time base begins anew with it.
        begins: bool,
    },
    /// Something that is no sample; the words name place and problem.
    Refused(String),
}

/// Whether a source has more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Next {
    /// There is more to come.
    More,
    /// It has ended.
    Ended,
}

/// How a simulated wagon or rig rolls: what its microphone would hear comes from that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rolls {
    /// Speed, m/s.
    pub speed_m_s: f64,
    /// Creepage of the leading wheelset, magnitude.
    pub creepage: f64,
    /// 0 dry to 1 wet.
    pub wetness: f64,
}

/// A source of samples.
pub trait Feed {
    /// How a wagon (counted from 0) rolls now; nothing where that is not simulated.
    fn rolls(&self, _wagon: usize) -> Option<Rolls> {
        None
    }

    /// Hands over, in order, everything that is due up to `until_s` seconds after the start.
    fn take_due(&mut self, until_s: f64, sink: &mut dyn FnMut(Arrival<'_>)) -> Next;

    /// Seconds of the source in a second of real time.
    fn speed(&self) -> f64;

    /// What it is, in a few words.
    fn describe(&self) -> String;
}

/// Why a source cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum InputError {
    /// A recording is wrong.
    #[error(transparent)]
    Recording(#[from] railgrip_recording::RecordingError),
    /// A recording does not fit its vehicle.
    #[error("{}: {found} wheelsets, its vehicle file describes {expected}", file.display())]
    Wheelsets {
        /// The recording.
        file: std::path::PathBuf,
        /// In the recording.
        found: usize,
        /// By the vehicle file.
        expected: usize,
    },
    /// This source has no such samples.
    #[error("wagon {wagon} is a {plant}: {source_kind} cannot feed it; {allowed}")]
    Plant {
        /// Number of the wagon.
        wagon: u32,
        /// What it is.
        plant: &'static str,
        /// The source.
        source_kind: &'static str,
        /// What can be done.
        allowed: &'static str,
    },
    /// A recording of a microphone is wrong.
    #[error(transparent)]
    Audio(#[from] railgrip_acoustics::wav::WavError),
    /// The simulated train cannot be built.
    #[error(transparent)]
    Scenario(#[from] railgrip_simulation::ScenarioError),
}

/// Opens the source that the settings name.
///
/// # Errors
/// A recording that cannot be read or does not fit its vehicle, a scenario that cannot be run.
pub fn open(settings: &TrainSettings) -> Result<Box<dyn Feed>, InputError> {
    check_plants(settings)?;
    let vehicles: Vec<_> = settings.wagons.iter().map(|wagon| wagon.vehicle.clone()).collect();
    let plants: Vec<_> = settings.wagons.iter().map(|wagon| wagon.plant.kind()).collect();
    Ok(match &settings.source {
        Source::Simulate { scenario, seed, sample_rate_hz, speed } => {
            let real = settings.wagons.iter().zip(vehicles);
            let real: Vec<_> =
                real.map(|(wagon, believed)| wagon.simulated.clone().unwrap_or(believed)).collect();
            Box::new(Simulated::new(scenario, &real, *seed, *sample_rate_hz, *speed)?)
        }
        Source::Replay { runs, speed, repeat } => {
            Box::new(Replay::open(runs, &vehicles, &plants, *speed, *repeat)?)
        }
        Source::Rig { programme, seed, speed, repeat } => {
            Box::new(Rigs::new(*programme, *seed, settings.wagons.len(), *speed, *repeat))
        }
        Source::Stdin => {
            let wheelsets = vehicles.iter().map(railgrip_vehicle::VehicleParameters::wheelsets).collect();
            Box::new(Lines::start(std::io::BufReader::new(std::io::stdin()), wheelsets))
        }
    })
}

/// Refuses a source that has no samples of what a wagon is.
fn check_plants(settings: &TrainSettings) -> Result<(), InputError> {
    for wagon in &settings.wagons {
        let kind = wagon.plant.kind();
        let (fits, source_kind) = match &settings.source {
            Source::Replay { .. } => (true, "a replay"),
            Source::Simulate { .. } => (kind == PlantKind::Wagon, "a simulated train"),
            Source::Stdin => (matches!(kind, PlantKind::Wagon | PlantKind::Roller), "the standard input"),
            Source::Rig { programme, .. } => (kind == programme.plant(), "this programme"),
        };
        if !fits {
            let (wagon, plant) = (wagon.number, kind.name());
            let allowed = "allowed are a recording of it, or kind = \"rig\" with a programme of its rig";
            return Err(InputError::Plant { wagon, plant, source_kind, allowed });
        }
    }
    Ok(())
}
