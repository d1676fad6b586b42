//! Frames of CAN buses: from SocketCAN, or played from a log in the form of `candump -L`.

use super::overrun::{self, Overruns};
use super::{Inlet, InputError, Tally};
use railgrip_bus::monotonic_ns;
use railgrip_fieldbus::{Gathering, dbc};
use railgrip_messages::SourceCount;
use railgrip_settings::{CanLog, CanSource};
use socketcan::dump::{ParseError, Reader};
use socketcan::{CanAnyFrame, CanFdSocket, EmbeddedFrame, Frame, Socket, SocketOptions};
use std::fs::File;
use std::io::{BufReader, ErrorKind};
use std::thread::spawn;
use std::time::{Duration, Instant, SystemTime};

/// Pause before an interface is tried again.
const PAUSE: Duration = Duration::from_secs(1);
/// A gap in a log that is longer than this is not waited for.
const LONGEST_GAP_S: f64 = 10.0;
/// A stamp of the kernel that is older than this is not believed.
const OLDEST: Duration = Duration::from_secs(1);

/// Starts to read the buses or the log.
///
/// # Errors
/// A log that cannot be opened.
pub(super) fn start(source: &CanSource, inlet: Inlet) -> Result<(), InputError> {
    let frames = |inlet: Inlet| Frames {
        gathering: Gathering::new(source.messages.plan.clone(), source.messages.hold_s),
        tally: inlet.tally().clone(),
        inlet,
    };
    if let Some(log) = source.log.clone() {
        let failed = |source| InputError::Log { file: log.file.clone(), source };
        let file = File::open(&log.file).map_err(failed)?;
        let (frames, interfaces) = (frames(inlet), source.interfaces.clone());
        spawn(move || play(frames, &log, file, &interfaces));
        return Ok(());
    }
    for (lane, interface) in source.interfaces.iter().cloned().enumerate() {
        let frames = frames(inlet.clone());
        spawn(move || listen(frames, lane, &interface));
    }
    Ok(())
}

/// What takes the frames of a bus.
struct Frames {
    gathering: Gathering,
    tally: Tally,
    inlet: Inlet,
}

impl Frames {
    /// Takes a frame that came at a time of the bus, s, and at an instant of our clock; false once nobody takes rows any more.
    fn take(&mut self, lane: usize, frame: &CanAnyFrame, at_s: f64, arrived_ns: u64) -> bool {
        self.tally.add(SourceCount::Arrived, 1);
        let data = match frame {
            CanAnyFrame::Normal(frame) => frame.data(),
            CanAnyFrame::Fd(frame) => frame.data(),
            CanAnyFrame::Remote(_) => {
                self.tally.add(SourceCount::RemoteFrame, 1);
                return true;
            }
            CanAnyFrame::Error(_) => {
                self.tally.add(SourceCount::ErrorFrame, 1);
                return true;
            }
        };
        let mut open = true;
        let inlet = &self.inlet;
        let key = dbc::key_of(frame.id_word());
        let taken = self.gathering.take(lane, key, data, at_s, &mut |wagon, row| {
            open &= inlet.sample(wagon, row, arrived_ns);
        });
        self.tally.add(SourceCount::Unwanted, u64::from(!taken.wanted));
        self.tally.add(SourceCount::Short, u64::from(taken.short));
        self.tally.add(SourceCount::OutOfRange, u64::from(taken.out_of_range));
        open
    }
}

/// Reads an interface, and opens it again for as long as anybody takes the rows.
fn listen(mut frames: Frames, lane: usize, interface: &str) {
    let mut told = false;
    loop {
        let trouble = match open(interface) {
            Ok(socket) => {
                tracing::info!("can {interface}: open");
                told = false;
                match read(&mut frames, lane, &socket) {
                    None => return,
                    Some(trouble) => trouble,
                }
            }
            Err(trouble) => trouble,
        };
        if !told {
            tracing::warn!("can {interface}: {trouble}; tried again and again");
            told = true;
        }
        std::thread::sleep(PAUSE);
    }
}

fn open(interface: &str) -> std::io::Result<CanFdSocket> {
    let socket = CanFdSocket::open(interface)?;
    socket.set_error_filter_accept_all()?;
    socket.set_recv_timestamp(true)?;
    socket.set_read_timeout(overrun::PERIOD)?;
    Ok(socket)
}

/// Until the interface fails; `None` once nobody takes the rows any more.
fn read(frames: &mut Frames, lane: usize, socket: &CanFdSocket) -> Option<std::io::Error> {
    let mut overruns = Overruns::new();
    loop {
        overruns.look(socket, &frames.tally);
        match socket.read_frame_with_timestamp() {
            Ok((frame, stamp)) => {
                // The kernel stamps by the wall clock; what counts is how long ago that was.
                let age = SystemTime::now().duration_since(stamp).ok().filter(|age| *age < OLDEST);
                let age_ns = age.map_or(0, |age| u64::try_from(age.as_nanos()).unwrap_or(0));
                let arrived_ns = monotonic_ns().saturating_sub(age_ns);
                if !frames.take(lane, &frame, arrived_ns as f64 * 1e-9, arrived_ns) {
                    return None;
                }
            }
            Err(error) if overrun::is_pause(&error) => {}
            Err(error) => return Some(error),
        }
    }
}

/// Plays a log at its own pace, or faster.
fn play(mut frames: Frames, log: &CanLog, file: File, interfaces: &[String]) {
    let name = log.file.display().to_string();
    let mut next = Some(file);
    while let Some(file) = next.take() {
        match pass(&mut frames, log, &name, file, interfaces) {
            Pass::Over => {}
            Pass::Closed => return,
        }
        if log.repeat {
            match File::open(&log.file) {
                Ok(file) => next = Some(file),
                Err(error) => tracing::error!(%error, "{name} cannot be read again"),
            }
        }
    }
}

/// How a pass over a log ended.
enum Pass {
    Over,
    /// Nobody takes the rows any more.
    Closed,
}

fn pass(frames: &mut Frames, log: &CanLog, name: &str, file: File, interfaces: &[String]) -> Pass {
    let mut reader = Reader::from_reader(BufReader::new(file));
    let mut began: Option<(Instant, f64)> = None;
    for number in 1_u64.. {
        let record = match reader.next_record() {
            Ok(Some(record)) => record,
            Ok(None) => break,
            // A line that is no text reads as one of no meaning.
            Err(ParseError::Io(error)) if error.kind() != ErrorKind::InvalidData => {
                tracing::error!(%error, "{name} cannot be read to its end");
                break;
            }
            Err(error) => {
                if !frames.inlet.put(Err(format!("{name}, line {number}: {error}"))) {
                    return Pass::Closed;
                }
                continue;
            }
        };
        let lane = match interfaces {
            [] => Some(0),
            known => known.iter().position(|known| *known == record.device),
        };
        let at_s = record.t_us as f64 * 1e-6;
        let due_s =
            |(start, first_s): (Instant, f64)| (at_s - first_s) / log.speed - start.elapsed().as_secs_f64();
        let wait_s = began.map_or(0.0, due_s);
        if began.is_none() || !(-LONGEST_GAP_S..=LONGEST_GAP_S).contains(&wait_s) {
            began = Some((Instant::now(), at_s));
        } else if wait_s > 0.0 {
            std::thread::sleep(Duration::from_secs_f64(wait_s));
        }
        match lane {
            Some(lane) if !frames.take(lane, &record.frame, at_s, monotonic_ns()) => return Pass::Closed,
            Some(_) => {}
            None => {
                frames.tally.add(SourceCount::Arrived, 1);
                frames.tally.add(SourceCount::Unwanted, 1);
            }
        }
    }
    Pass::Over
}
