//! Where a train lives on this machine, and how large its channels are.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use iceoryx2::prelude::{Config, FilePath, SemanticString};
use railgrip_settings::TrainSettings;

use crate::BusError;

/// Where POSIX shared memory lives on Linux.
pub(crate) const SHARED_MEMORY: &str = "/dev/shm";
/// Characters of iceoryx2 root and prefix that fit into the path of a socket.
const MAX_ROOT_AND_PREFIX: usize = 68;
/// Sizes of the channels; the holder's count, the others find the channels as they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Items of one batch, at most.
    pub max_batch: usize,
    /// Batches that a subscriber can be behind before it misses some.
    pub buffer: usize,
    /// Subscribers of one channel at a time, with room for a restart beside one that is dead but not cleaned up yet.
    pub subscribers: usize,
    /// Publishers of one channel of a wagon at a time, with room as above.
    pub publishers: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { max_batch: 32, buffer: 64, subscribers: 6, publishers: 3 }
    }
}

/// One instance of a train on this machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BusConfig {
    /// Name of the train, for people.
    pub train: String,
    /// Folder of this instance: locks, configuration.
    pub dir: PathBuf,
    /// Start of the names of everything this instance has in `/dev/shm`; each folder needs its own.
    pub prefix: String,
    /// Numbers of its wagons.
    pub wagons: Vec<u32>,
    /// Numbers of the wagons that have a microphone.
    pub microphones: Vec<u32>,
    /// Sizes of the channels.
    pub limits: Limits,
}

impl BusConfig {
    /// The instance that the settings of a train name.
    #[must_use]
    pub fn of(settings: &TrainSettings) -> Self {
        Self {
            train: settings.name.clone(),
            dir: settings.instance.dir.clone(),
            prefix: settings.instance.prefix.clone(),
            wagons: settings.wagons.iter().map(|wagon| wagon.number).collect(),
            microphones: settings.microphones.iter().map(|microphone| microphone.wagon).collect(),
            limits: Limits::default(),
        }
    }

    /// What iceoryx2 keeps of nodes and services, and its sockets. In memory as the data are: it syncs each of these files, two a
    /// channel, and where the folder of the instance is on a disk, making the channels would wait for that and wear it.
    pub(crate) fn root(&self) -> PathBuf {
        Path::new(SHARED_MEMORY).join(format!("{}ipc", self.prefix))
    }

    /// Where iceoryx2 describes the channels, a file each.
    pub(crate) fn services(&self) -> PathBuf {
        self.root().join("services")
    }

    pub(crate) fn transport_file(&self) -> PathBuf {
        self.dir.join("iceoryx2.toml")
    }

    /// Checks numbers and lengths.
    ///
    /// # Errors
    /// Names what is wrong and what is allowed.
    pub fn validate(&self) -> Result<(), BusError> {
        let length = self.root().as_os_str().len() + self.prefix.len();
        if length > MAX_ROOT_AND_PREFIX {
            return Err(BusError::PrefixTooLong {
                prefix: self.prefix.clone(),
                length,
                max: MAX_ROOT_AND_PREFIX,
            });
        }
        self.validate_numbers()
    }

    fn validate_numbers(&self) -> Result<(), BusError> {
        let check = |what, value: usize, range: std::ops::RangeInclusive<usize>, allowed| {
            if range.contains(&value) {
                Ok(())
            } else {
                Err(BusError::Limit { what, value: value as u64, allowed })
            }
        };
        check("wagons", self.wagons.len(), 1..=256, "1 to 256 wagons")?;
        check("max_batch", self.limits.max_batch, 1..=4096, "1 to 4096")?;
        check("buffer", self.limits.buffer, 16..=4096, "16 to 4096")?;
        check("subscribers", self.limits.subscribers, 2..=64, "2 to 64")?;
        check("publishers", self.limits.publishers, 1..=16, "1 to 16")?;
        for (index, wagon) in self.wagons.iter().enumerate() {
            if *wagon == railgrip_messages::NO_WAGON || self.wagons[..index].contains(wagon) {
                let allowed = "each number once, 1 or more";
                return Err(BusError::Limit { what: "wagon", value: u64::from(*wagon), allowed });
            }
        }
        Ok(())
    }

    /// The iceoryx2 configuration: own root and prefix; only the holder cleans up after the dead, on its own beat.
    pub(crate) fn transport_text(&self) -> String {
        format!(
            "[global]\nroot-path = \"{root}\"\nprefix = \"{prefix}\"\n\n\
             [global.service]\ncleanup-dead-nodes-on-open = false\n\n\
             [global.node]\ncleanup-dead-nodes-on-creation = false\ncleanup-dead-nodes-on-destruction = false\n",
            root = self.root().display(),
            prefix = self.prefix
        )
    }

    /// Makes this instance the one that iceoryx2 uses in this process. It must come before the first use, because
    /// cleaning up after dead nodes looks at the global configuration only.
    pub(crate) fn install(&self) -> Result<(), BusError> {
        static BOUND: Mutex<Option<PathBuf>> = Mutex::new(None);
        let file = self.transport_file();
        let mut bound = BOUND.lock().unwrap_or_else(PoisonError::into_inner);
        match bound.as_ref() {
            Some(other) if *other == file => return Ok(()),
            Some(other) => return Err(BusError::OtherInstance { bound: other.clone(), wanted: file }),
            None => {}
        }
        let failed =
            |reason: String| BusError::File { path: file.clone(), source: std::io::Error::other(reason) };
        let path = FilePath::new(file.as_os_str().as_encoded_bytes())
            .map_err(|error| failed(format!("{error:?}")))?;
        Config::setup_global_config_from_file(&path).map_err(|error| failed(format!("{error:?}")))?;
        *bound = Some(file);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config() -> BusConfig {
        BusConfig {
            train: "demo".into(),
            dir: "/run/user/1000/railgrip/demo".into(),
            prefix: "rg0123abcd_".into(),
            wagons: (1..=8).collect(),
            microphones: Vec::new(),
            limits: Limits::default(),
        }
    }

    #[test]
    fn refuses_paths_and_numbers_in_words() {
        config().validate().expect("good");
        let cases: [(BusConfig, &str); 4] = [
            (BusConfig { prefix: "p".repeat(40), ..config() }, "at most 68"),
            (BusConfig { wagons: vec![], ..config() }, "1 to 256 wagons"),
            (BusConfig { wagons: vec![1, 2, 1], ..config() }, "each number once"),
            (BusConfig { limits: Limits { max_batch: 0, ..Limits::default() }, ..config() }, "max_batch = 0"),
        ];
        for (config, words) in cases {
            let text = config.validate().expect_err(words).to_string();
            assert!(text.contains(words), "{text}");
        }
    }
}
