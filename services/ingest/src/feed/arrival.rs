//! What a source of samples is, and what comes from it.

use super::tally::Account;
use railgrip_recording::{BogieRow, MotorRow, Row};

/// When a sample was taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum When {
    /// Seconds after the start of the source at which it is due.
    Due(f64),
    /// This instant of our monotonic clock, ns.
    At(u64),
}

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
        /// When it was taken.
        when: When,
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
    /// A sample whose time is not after that of the sample before: late, or sent twice.
    Late {
        /// Index of the wagon.
        wagon: usize,
    },
    /// A sample of a wagon whose columns cannot be in their units.
    Withheld {
        /// Index of the wagon.
        wagon: usize,
    },
    /// The clock of a wagon's source drifts more than a clock should, or no longer does.
    Drifts {
        /// Index of the wagon.
        wagon: usize,
        /// How much faster our clock runs, parts in a million.
        drift_ppm: f64,
        /// More than a clock should.
        wrong: bool,
    },
    /// The columns of a wagon cannot be in their units (`Some`, with what gives it away), or are plausible again.
    Implausible {
        /// Index of the wagon.
        wagon: usize,
        /// What gives it away.
        why: Option<String>,
    },
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

    /// What it has counted as a whole, and of each wagon; nothing where nothing can be lost on the way.
    fn accounts(&self) -> Option<(Account, Vec<Account>)> {
        None
    }

    /// Samples will be taken and sent from now on: what a predecessor has left may be taken over.
    fn begin(&mut self) {}

    /// What was handed over will be sent now, wagon by wagon.
    fn sending(&mut self) {}

    /// Of so many wagons it has been sent.
    fn sent(&mut self, _wagons: usize) {}

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
    /// Other programs publish the samples.
    #[error("[source] kind is external: other programs publish the samples, and there is nothing to ingest")]
    External,
    /// An address that cannot be listened on.
    #[error("[source] listen {address}: {source}")]
    Listen {
        /// The address.
        address: std::net::SocketAddr,
        /// What the system says.
        source: std::io::Error,
    },
    /// A multicast group that cannot be joined.
    #[error("[source] groups {group}: {source}")]
    Group {
        /// The group.
        group: std::net::Ipv4Addr,
        /// What the system says.
        source: std::io::Error,
    },
    /// A log of frames that cannot be read.
    #[error("{}: {source}", file.display())]
    Log {
        /// The file.
        file: std::path::PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// A column of a recording cannot be in its unit.
    #[error("{}, at {:.2} s, {source}", file.display(), source.t_s)]
    Units {
        /// The recording.
        file: std::path::PathBuf,
        /// The column, and what gives it away.
        source: railgrip_diagnosis::data::units::UnitError,
    },
    /// A recording of a microphone is wrong.
    #[error(transparent)]
    Audio(#[from] railgrip_acoustics::wav::WavError),
    /// The simulated train cannot be built.
    #[error(transparent)]
    Scenario(#[from] railgrip_simulation::ScenarioError),
}
