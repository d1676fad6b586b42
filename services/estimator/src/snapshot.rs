//! What an estimator leaves on disk so that its successor goes on where it stopped.
//!
//! One file a wagon; one that is damaged, of another form, wagon or vehicle is refused, and the estimator starts fresh. A wagon with a vehicle number keeps its file wherever it runs in the train; one without goes on only
//! within one start of the train, because nobody knows whether the next one has the same wagon there.

use crate::worker::Worker;
use railgrip_bus::{KeptError, keep, kept};
use railgrip_filter::EstimatorSnapshot;
use railgrip_indicators::IndicatorState;
use railgrip_messages::Stamp;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// First line of the file: its form. Changes whenever the layout of the state does.
const FORM: &str = "railgrip snapshot 4";

/// Why a snapshot was not used or not written.
#[derive(Debug, thiserror::Error)]
pub enum SnapshotError {
    /// The file cannot be read or written, is damaged, or of something else.
    #[error(transparent)]
    Kept(#[from] KeptError),
    /// It is of an earlier start of the train, and the wagon has no vehicle number: an ordinary day.
    #[error("{}: of an earlier start; without a vehicle number it may be of another wagon", .0.display())]
    EarlierStart(PathBuf),
    /// The filter refuses the state.
    #[error("{}: {source}", file.display())]
    Filter {
        /// The file.
        file: PathBuf,
        /// Why.
        source: railgrip_filter::FilterError,
    },
}

#[derive(Serialize, Deserialize)]
struct State {
    wagon: u32,
    /// Letters and digits of the vehicle number; empty where there is none.
    vehicle: String,
    turned: bool,
    session: String,
    sequence: u64,
    unix_ns: i64,
    monotonic_ns: u64,
    estimator: EstimatorSnapshot,
    indicators: Vec<u8>,
}

/// Writes the state of `worker`; nothing to do before its first sample.
///
/// # Errors
/// If the file cannot be written.
pub fn save(file: &Path, worker: &Worker) -> Result<(), SnapshotError> {
    let Some((sequence, stamp)) = worker.last else { return Ok(()) };
    let state = State {
        wagon: worker.wagon,
        vehicle: vehicle(worker),
        turned: worker.turned,
        session: worker.session.clone(),
        sequence,
        unix_ns: stamp.unix_ns,
        monotonic_ns: stamp.monotonic_ns,
        estimator: worker.estimator.snapshot(),
        indicators: bytemuck::bytes_of(worker.indicators.state()).to_vec(),
    };
    let body = postcard::to_stdvec(&state)
        .map_err(|_| KeptError::form(file, "the state cannot be put into bytes"))?;
    Ok(keep(file, FORM, &body)?)
}

/// Puts `worker` into the state of the snapshot; gives the stamp of the last sample in it. `None` if there is none.
///
/// # Errors
/// A snapshot that is damaged or foreign; the worker is then as it was.
pub fn restore(file: &Path, worker: &mut Worker) -> Result<Option<Stamp>, SnapshotError> {
    let Some(body) = kept(file, FORM)? else { return Ok(None) };
    let problem = |problem| SnapshotError::from(KeptError::form(file, problem));
    let state: State = postcard::from_bytes(&body).map_err(|_| problem("not a snapshot of this version"))?;
    if state.vehicle != vehicle(worker) {
        return Err(problem("the snapshot of another wagon"));
    }
    if worker.vehicle_number.is_none() {
        if state.wagon != worker.wagon {
            return Err(problem("the snapshot of another wagon"));
        }
        if state.session != worker.session {
            return Err(SnapshotError::EarlierStart(file.to_owned()));
        }
    }
    if state.turned != worker.turned {
        return Err(problem("of a wagon that ran the other end first"));
    }
    if state.indicators.len() != size_of::<IndicatorState>() {
        return Err(problem("its indicators have another layout"));
    }
    let indicators: IndicatorState = bytemuck::pod_read_unaligned(&state.indicators);
    worker
        .estimator
        .restore(&state.estimator)
        .map_err(|source| SnapshotError::Filter { file: file.to_owned(), source })?;
    if !worker.indicators.restore(&indicators) {
        tracing::warn!(file = %file.display(), "the indicators of the snapshot make no sense and start anew");
    }
    let stamp = Stamp { unix_ns: state.unix_ns, monotonic_ns: state.monotonic_ns };
    worker.last = Some((state.sequence, stamp));
    worker.has_state = true;
    Ok(Some(stamp))
}

fn vehicle(worker: &Worker) -> String {
    worker.vehicle_number.as_ref().map_or_else(String::new, |number| number.key().to_owned())
}
