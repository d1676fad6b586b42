//! Who is there: file locks that the kernel releases at any death, `kill -9` included.
//!
//! * `holder.lock` – exclusive while a holder lives.
//! * `ports.lock` – shared by every process with ports; the holder takes it exclusively while it wipes and creates,
//!   so nobody opens a channel that is about to vanish, and waits for it before it cleans up.
//! * `reload.turn` – exclusive from when a process leaves in order to start again until it is gone; it names that process.
//! * `PROCESS.lock`, `PROCESS-N.lock` – exclusive while that process lives, where there may be one of it (for wagon N).
//! * `holder` – process id and incarnation of the holder, present only once all channels exist.

use std::fs::{File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use railgrip_messages::{NO_WAGON, ProcessKind};

use crate::{BusConfig, BusError};

const POLL: Duration = Duration::from_millis(5);

/// A lock on a file of the instance, held until dropped.
#[derive(Debug)]
pub(crate) struct Lock {
    _file: File,
}

/// The locks of a process with ports. The bus and every port share them: a port that ends takes its channel with it where it was
/// the last, by name, so a holder may create channels of that name only once all ports have ended.
#[derive(Debug)]
pub(crate) struct Membership {
    pub _ports: Lock,
    pub _role: Option<Lock>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    Shared,
    Exclusive,
}

impl Lock {
    /// Tries until `patience` is over; `None` if somebody else kept it.
    pub(crate) fn acquire(path: &Path, kind: Kind, patience: Duration) -> Result<Option<Self>, BusError> {
        let failed = |source| BusError::File { path: path.to_owned(), source };
        let file = OpenOptions::new()
            .create(true)
            .truncate(false)
            .write(true)
            .read(true)
            .open(path)
            .map_err(failed)?;
        let deadline = Instant::now() + patience;
        loop {
            let result = match kind {
                Kind::Shared => file.try_lock_shared(),
                Kind::Exclusive => file.try_lock(),
            };
            match result {
                Ok(()) => return Ok(Some(Self { _file: file })),
                Err(TryLockError::WouldBlock) if Instant::now() >= deadline => return Ok(None),
                Err(TryLockError::WouldBlock) => std::thread::sleep(POLL),
                Err(TryLockError::Error(source)) => return Err(failed(source)),
            }
        }
    }
}

pub(crate) fn holder_lock_file(config: &BusConfig) -> PathBuf {
    config.dir.join("holder.lock")
}

pub(crate) fn ports_lock_file(config: &BusConfig) -> PathBuf {
    config.dir.join("ports.lock")
}

/// The lock of a process of which a train has one, or one a wagon; `None` for those that may be many.
pub(crate) fn role_lock_file(config: &BusConfig, process: ProcessKind, name: &str) -> Option<PathBuf> {
    let single = match process {
        ProcessKind::Ingest
        | ProcessKind::Estimator
        | ProcessKind::Listener
        | ProcessKind::Health
        | ProcessKind::Judge => true,
        ProcessKind::Holder | ProcessKind::Record => false,
    };
    single.then(|| config.dir.join(format!("{name}.lock")))
}

/// The right to leave in order to start again, of which a train has one; held until dropped.
#[derive(Debug)]
pub struct Turn {
    _lock: Lock,
}

/// How long who took the last turn may take to be back.
const BACK_WITHIN: Duration = Duration::from_secs(10);

/// Takes the turn to leave in order to start again, so that processes that shall all do so go one after another: `None` while
/// another has it, or has left and is not back.
///
/// # Errors
/// Files that cannot be used.
pub fn take_turn(config: &BusConfig, process: ProcessKind, wagon: u32) -> Result<Option<Turn>, BusError> {
    let path = config.dir.join("reload.turn");
    let Some(lock) = Lock::acquire(&path, Kind::Exclusive, Duration::ZERO)? else { return Ok(None) };
    let failed = |source| BusError::File { path: path.clone(), source };
    let last = std::fs::read_to_string(&path).map_err(failed)?;
    let left_at = std::fs::metadata(&path).and_then(|file| file.modified()).map_err(failed)?;
    let recently = left_at.elapsed().is_ok_and(|since| since < BACK_WITHIN);
    if recently && !last.is_empty() {
        let role = config.dir.join(last.trim());
        let is_back = Lock::acquire(&role, Kind::Shared, Duration::ZERO)?.is_none();
        if !is_back {
            return Ok(None);
        }
    }
    let own = role_lock_file(config, process, &role_name(process, wagon));
    let own = own.as_deref().and_then(Path::file_name).unwrap_or_default().to_string_lossy().into_owned();
    std::fs::write(&path, own).map_err(failed)?;
    Ok(Some(Turn { _lock: lock }))
}

/// What a process is called among those of its train.
pub(crate) fn role_name(process: ProcessKind, wagon: u32) -> String {
    if wagon == NO_WAGON { process.to_string() } else { format!("{process}-{wagon}") }
}

pub(crate) fn holder_file(config: &BusConfig) -> PathBuf {
    config.dir.join("holder")
}

/// True while some process has the holder's lock.
pub(crate) fn holder_alive(config: &BusConfig) -> Result<bool, BusError> {
    let path = holder_lock_file(config);
    if !path.exists() {
        return Ok(false);
    }
    Ok(Lock::acquire(&path, Kind::Shared, Duration::ZERO)?.is_none())
}

/// What the holder wrote once all channels existed: process id, blank, start time.
pub(crate) fn incarnation(config: &BusConfig) -> Option<String> {
    std::fs::read_to_string(holder_file(config)).ok().filter(|text| text.ends_with('\n'))
}

/// The process id of the holder, in words.
pub(crate) fn holder_pid(config: &BusConfig) -> String {
    incarnation(config)
        .and_then(|text| text.split(' ').next().map(str::to_owned))
        .unwrap_or_else(|| "?".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn locks_exclude_and_share_as_they_should() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("lock");
        let take = |kind| Lock::acquire(&path, kind, Duration::ZERO).expect("usable");
        let first = take(Kind::Shared);
        let second = take(Kind::Shared);
        assert!(first.is_some() && second.is_some());
        assert!(take(Kind::Exclusive).is_none());
        drop((first, second));
        let writer = take(Kind::Exclusive);
        assert!(writer.is_some() && take(Kind::Shared).is_none());
    }

    #[test]
    fn the_next_one_leaves_when_the_one_before_is_back() {
        let folder = tempfile::tempdir().expect("folder");
        let config = BusConfig {
            train: "t".into(),
            dir: folder.path().into(),
            prefix: "rgturn_".into(),
            wagons: vec![1, 2],
            microphones: Vec::new(),
            limits: crate::Limits::default(),
        };
        let turn = |wagon| take_turn(&config, ProcessKind::Estimator, wagon).expect("usable");
        let role = |wagon| folder.path().join(format!("estimator-{wagon}.lock"));
        let there = |wagon| Lock::acquire(&role(wagon), Kind::Exclusive, Duration::ZERO).expect("usable");
        let (one, _two) = (there(1), there(2));
        let first = turn(1);
        assert!(first.is_some() && turn(2).is_none(), "one at a time");
        drop(one);
        drop(first);
        assert!(turn(2).is_none(), "the first has left and is not back");
        let _one = there(1);
        assert!(turn(2).is_some());
    }
}
