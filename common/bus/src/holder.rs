//! The one process that creates channels.
//!
//! Start: take the instance lock; take away the sign of readiness; wait until no process of an earlier incarnation has
//! ports; wipe the root folder and everything of this instance in `/dev/shm`; create all channels; show readiness.
//! End: take away the sign of readiness; wait for the others; drop all channels; wipe again.

use std::path::Path;
use std::time::{Duration, Instant};

use iceoryx2::prelude::{Node, ipc};

use crate::creator::{Creator, Kept, Service};
use crate::folder::own_folder;
use crate::presence::{self, Kind, Lock};
use crate::shared_memory::{self, PrefixClaim, remove_file};
use crate::{BusConfig, BusError, CHANNELS, Channel, Lifecycle, Scope, clock, node};

/// How often the holder looks for dead processes, to clean up after them: so often that looking takes no more than a hundredth of
/// its time (it opens files of every process), within these bounds.
const CLEANUP_PERIODS: [Duration; 2] = [Duration::from_millis(250), Duration::from_secs(2)];
/// How long the holder waits for processes of the train to leave before it wipes.
const LEAVE_PATIENCE: Duration = Duration::from_secs(3);
/// Processes that publish on a channel of the train, beside one a wagon.
const SPARE_PUBLISHERS: usize = 8;
/// Keeps every channel of one train alive; dropping it removes them.
pub struct Holder {
    kept: Vec<Kept>,
    node: Option<Node<ipc::Service>>,
    config: BusConfig,
    _prefix: PrefixClaim,
    _lock: Lock,
}

impl Holder {
    /// Creates every channel of `config`. A predecessor that is about to leave gets `patience`.
    ///
    /// # Errors
    /// [`BusError::AlreadyHeld`] if another holder lives; otherwise what the system or iceoryx2 refused.
    pub fn start(config: BusConfig, patience: Duration) -> Result<Self, BusError> {
        Self::start_with(config, patience, every_channel)
    }

    /// Removes what a holder left that died without cleaning up. Does nothing while one lives.
    ///
    /// # Errors
    /// If files cannot be removed.
    pub fn sweep(config: &BusConfig) -> Result<(), BusError> {
        if !config.dir.exists() {
            return Ok(());
        }
        let path = presence::holder_lock_file(config);
        let Some(_lock) = Lock::acquire(&path, Kind::Exclusive, Duration::ZERO)? else { return Ok(()) };
        remove_file(&presence::holder_file(config))?;
        // Whoever uses the prefix now has files of its own under it.
        match PrefixClaim::take(config, Duration::ZERO) {
            Ok(_claim) => wipe(config),
            Err(BusError::PrefixTaken { .. }) => Ok(()),
            Err(error) => Err(error),
        }
    }

    fn start_with(
        config: BusConfig,
        patience: Duration,
        create: impl Fn(&Creator<'_>, &BusConfig) -> Result<Vec<Kept>, BusError>,
    ) -> Result<Self, BusError> {
        config.validate()?;
        own_folder(&config.dir)?;
        let Some(lock) = Lock::acquire(&presence::holder_lock_file(&config), Kind::Exclusive, patience)?
        else {
            return Err(BusError::AlreadyHeld {
                train: config.train.clone(),
                pid: presence::holder_pid(&config),
                folder: config.dir.clone(),
            });
        };
        let prefix = PrefixClaim::take(&config, patience)?;
        remove_file(&presence::holder_file(&config))?;
        let alone = alone(&config)?;
        wipe(&config)?;
        shared_memory::check_room(&config)?;
        create_root(&config)?;
        write_file(&config.transport_file(), &config.transport_text())?;
        config.install()?;
        let node = node::create(&config, "holder")?;
        let kept = create(&Creator { node: &node, limits: &config.limits }, &config)?;
        write_file(
            &presence::holder_file(&config),
            &format!("{} {}\n", std::process::id(), clock::now().unix_ns),
        )?;
        drop(alone);
        Ok(Self { kept, node: Some(node), config, _prefix: prefix, _lock: lock })
    }

    /// Cleans up after the dead until asked to stop.
    ///
    /// # Errors
    /// [`BusError::ChannelsGone`]: nobody could open those that are missing, however often it started again.
    pub fn run(&self, lifecycle: &Lifecycle) -> Result<(), BusError> {
        lifecycle.ready();
        let [least, most] = CLEANUP_PERIODS;
        let mut next = Instant::now() + least;
        while !lifecycle.should_stop() {
            std::thread::sleep(Duration::from_millis(50));
            let began = Instant::now();
            if began >= next {
                self.clean_up();
                self.check_channels()?;
                next = began + (100 * began.elapsed()).clamp(least, most);
            }
            lifecycle.beat();
        }
        Ok(())
    }

    /// Fails if channels are missing. A process that was stopped while its holder died, and woke under the next, takes those with
    /// it that it was the last to use.
    ///
    /// # Errors
    /// [`BusError::ChannelsGone`].
    pub fn check_channels(&self) -> Result<(), BusError> {
        let folder = self.config.services();
        let entries =
            std::fs::read_dir(&folder).map_err(|source| BusError::File { path: folder.clone(), source })?;
        let channels = self.kept.len();
        match channels.saturating_sub(entries.count()) {
            0 => Ok(()),
            missing => Err(BusError::ChannelsGone { train: self.config.train.clone(), missing, channels }),
        }
    }

    /// Removes what dead processes left in the channels; returns how many were cleaned up.
    pub fn clean_up(&self) -> u64 {
        let Some(node) = &self.node else { return 0 };
        let state = node.try_cleanup_dead_nodes();
        if state.cleanups > 0 {
            tracing::debug!(processes = state.cleanups, "cleaned up after the dead");
        }
        state.cleanups
    }

    /// How many channels exist.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.kept.len()
    }
}

impl Drop for Holder {
    fn drop(&mut self) {
        let result = remove_file(&presence::holder_file(&self.config)).and_then(|()| {
            let _alone = alone(&self.config)?;
            self.clean_up();
            self.kept.clear();
            self.node = None;
            wipe(&self.config)
        });
        if let Err(error) = result {
            tracing::warn!(%error, "could not clean up the channels");
        }
    }
}

/// Process id of the holder, once all its channels exist.
#[must_use]
pub fn holder_pid(config: &BusConfig) -> Option<u32> {
    presence::incarnation(config).and_then(|text| text.split(' ').next()?.parse().ok())
}

/// Creates every channel of the table for every wagon that has it.
fn every_channel(creator: &Creator<'_>, config: &BusConfig) -> Result<Vec<Kept>, BusError> {
    let mut kept = Vec::new();
    for row in CHANNELS {
        let wagons = match row.scope {
            Scope::Train => &[railgrip_messages::NO_WAGON][..],
            Scope::Wagon => &config.wagons,
            Scope::Microphone => &config.microphones,
        };
        for wagon in wagons {
            let service = service(config, row, *wagon);
            kept.push((row.create)(creator, &service)?);
            if row.wakes {
                kept.push(creator.wake(&service)?);
            }
        }
    }
    Ok(kept)
}

fn service(config: &BusConfig, row: &Channel, wagon: u32) -> Service {
    let publishers = match row.scope {
        Scope::Wagon | Scope::Microphone => config.limits.publishers,
        Scope::Train => config.wagons.len() + SPARE_PUBLISHERS,
    };
    Service { name: row.service_name(wagon), publishers, history: row.history }
}

/// Waits until no process of this instance has ports; goes on without after [`LEAVE_PATIENCE`], because a stopped
/// process may never leave. It notices by [`crate::Bus::check_holder`] as soon as it runs again.
fn alone(config: &BusConfig) -> Result<Option<Lock>, BusError> {
    let lock = Lock::acquire(&presence::ports_lock_file(config), Kind::Exclusive, LEAVE_PATIENCE)?;
    if lock.is_none() {
        tracing::warn!(
            train = config.train,
            "a process of an earlier run does not leave; its channels are removed now"
        );
    }
    Ok(lock)
}

/// Removes everything that iceoryx2 keeps for this instance.
fn wipe(config: &BusConfig) -> Result<(), BusError> {
    wipe_root(config)?;
    shared_memory::wipe(&config.prefix)
}

fn wipe_root(config: &BusConfig) -> Result<(), BusError> {
    let root = config.root();
    match std::fs::remove_dir_all(&root) {
        Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
            Err(BusError::File { path: root, source })
        }
        _ => Ok(()),
    }
}

/// Makes the folder in which iceoryx2 puts its files. Others can write beside it: one that they made is not taken.
fn create_root(config: &BusConfig) -> Result<(), BusError> {
    use std::os::unix::fs::DirBuilderExt;
    let root = config.root();
    let made = std::fs::DirBuilder::new().mode(0o700).create(&root);
    made.map_err(|source| BusError::File { path: root, source })
}

/// Writes beside and renames, so that nobody reads half a file.
fn write_file(path: &Path, text: &str) -> Result<(), BusError> {
    let beside = path.with_extension("new");
    std::fs::write(&beside, text)
        .and_then(|()| std::fs::rename(&beside, path))
        .map_err(|source| BusError::File { path: path.to_owned(), source })
}

#[cfg(test)]
mod tests {
    use railgrip_messages::{Estimate, Payload, ProcessKind, Sample};

    use super::*;
    use crate::{Bus, channel};

    #[test]
    fn a_payload_of_another_version_is_refused_with_both_names() {
        let folder = tempfile::Builder::new().prefix("rg").tempdir_in("/tmp").expect("folder");
        let config = BusConfig {
            train: "mixed".into(),
            dir: folder.path().into(),
            prefix: format!("rgm{}_", std::process::id()),
            wagons: vec![1],
            microphones: Vec::new(),
            limits: crate::Limits::default(),
        };
        let samples = channel("samples").expect("row");
        let holder = Holder::start_with(config.clone(), Duration::ZERO, |creator, config| {
            Ok(vec![creator.channel::<Estimate>(&service(config, samples, 1))?])
        })
        .expect("holder");
        let bus = Bus::open(config, ProcessKind::Estimator, 1).expect("bus");
        let error = bus.sample_subscriber(1).err().expect("must be refused").to_string();
        println!("{error}");
        for name in [Sample::TYPE_NAME, Estimate::TYPE_NAME] {
            assert!(error.contains(name), "{error}");
        }
        drop((bus, holder));
    }
}
