//! Where a train lives on this machine, and how large its channels are.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use iceoryx2::prelude::{Config, FilePath, SemanticString};

use crate::BusError;

/// The longest name of a train.
pub const MAX_TRAIN_NAME: usize = 24;
/// Characters of iceoryx2 root and prefix that fit into the path of a socket.
const MAX_ROOT_AND_PREFIX: usize = 68;
/// The environment variable that moves all instances elsewhere.
const RUNTIME_DIR_VARIABLE: &str = "RAILGRIP_RUNTIME_DIR";

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
    /// Folder of all instances, see [`default_runtime_dir`].
    pub runtime_dir: PathBuf,
    /// Name of the train.
    pub train: String,
    /// Numbers of its wagons.
    pub wagons: Vec<u32>,
    /// Sizes of the channels.
    pub limits: Limits,
}

/// `$RAILGRIP_RUNTIME_DIR`, else `$XDG_RUNTIME_DIR/railgrip`, else `/tmp/railgrip-UID`.
#[must_use]
pub fn default_runtime_dir() -> PathBuf {
    let folder =
        |variable: &str| std::env::var_os(variable).filter(|value| !value.is_empty()).map(PathBuf::from);
    folder(RUNTIME_DIR_VARIABLE)
        .or_else(|| folder("XDG_RUNTIME_DIR").filter(|path| path.is_dir()).map(|path| path.join("railgrip")))
        .unwrap_or_else(|| format!("/tmp/railgrip-{}", rustix::process::getuid().as_raw()).into())
}

impl BusConfig {
    /// A train with wagons 1 to `wagons` in the default place.
    #[must_use]
    pub fn new(train: &str, wagons: u32) -> Self {
        Self {
            runtime_dir: default_runtime_dir(),
            train: train.to_owned(),
            wagons: (1..=wagons).collect(),
            limits: Limits::default(),
        }
    }

    /// The same train with its folder elsewhere.
    #[must_use]
    pub fn in_dir(mut self, runtime_dir: &Path) -> Self {
        runtime_dir.clone_into(&mut self.runtime_dir);
        self
    }

    /// Folder of this instance: locks, configuration, sockets, and small files such as [`BusConfig::http_file`].
    #[must_use]
    pub fn folder(&self) -> PathBuf {
        self.runtime_dir.join(&self.train)
    }

    /// Where the health service writes the address it serves, for example `http://127.0.0.1:8080`.
    #[must_use]
    pub fn http_file(&self) -> PathBuf {
        self.folder().join("http")
    }

    /// Where a service may keep state that survives its restart (but not a restart of the machine).
    #[must_use]
    pub fn state_dir(&self) -> PathBuf {
        self.folder().join("state")
    }

    pub(crate) fn root(&self) -> PathBuf {
        self.folder().join("iox")
    }

    pub(crate) fn transport_file(&self) -> PathBuf {
        self.folder().join("iceoryx2.toml")
    }

    /// Start of the names of everything this instance has in `/dev/shm`; other folders have other prefixes.
    #[must_use]
    pub fn prefix(&self) -> String {
        let folder = self.folder();
        let folder = std::path::absolute(&folder).unwrap_or(folder);
        // FNV-1a: stable across builds, unlike the hashes of the standard library.
        let hash =
            folder.as_os_str().as_encoded_bytes().iter().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
                (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
            });
        format!("rg{:08x}_", (hash >> 32) ^ (hash & 0xffff_ffff))
    }

    /// Checks names, numbers and lengths.
    ///
    /// # Errors
    /// Names what is wrong and what is allowed.
    pub fn validate(&self) -> Result<(), BusError> {
        let name_error = |reason| BusError::TrainName { name: self.train.clone(), reason };
        if self.train.is_empty() {
            return Err(name_error("is empty"));
        }
        if self.train.len() > MAX_TRAIN_NAME {
            return Err(name_error("is too long"));
        }
        if !self.train.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-' || byte == b'_') {
            return Err(name_error("has other characters"));
        }
        let length = self.root().as_os_str().len() + self.prefix().len();
        if length > MAX_ROOT_AND_PREFIX {
            return Err(BusError::PathTooLong { folder: self.folder(), length, max: MAX_ROOT_AND_PREFIX });
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
            prefix = self.prefix()
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
        BusConfig::new("demo", 8).in_dir(Path::new("/run/user/1000/railgrip"))
    }

    #[test]
    fn the_longest_train_name_fits_into_a_user_runtime_folder() {
        let name = "t".repeat(MAX_TRAIN_NAME);
        let config = BusConfig { train: name, ..config() };
        config.validate().expect("must fit");
    }

    #[test]
    fn refuses_names_paths_and_numbers_in_words() {
        let cases: [(BusConfig, &str); 6] = [
            (BusConfig { train: "a/b".into(), ..config() }, "has other characters"),
            (BusConfig { train: "x".repeat(25), ..config() }, "is too long"),
            (config().in_dir(Path::new(&format!("/{}", "d".repeat(60)))), "at most 68"),
            (BusConfig { wagons: vec![], ..config() }, "1 to 256 wagons"),
            (BusConfig { wagons: vec![1, 2, 1], ..config() }, "each number once"),
            (BusConfig { limits: Limits { max_batch: 0, ..Limits::default() }, ..config() }, "max_batch = 0"),
        ];
        for (config, words) in cases {
            let text = config.validate().expect_err(words).to_string();
            assert!(text.contains(words), "{text}");
        }
    }

    #[test]
    fn equal_names_in_other_folders_have_other_prefixes() {
        let here = config();
        let there = config().in_dir(Path::new("/run/user/1001/railgrip"));
        assert_ne!(here.prefix(), there.prefix());
        assert_eq!(here.prefix(), config().prefix());
        assert_eq!(here.prefix().len(), 11);
    }
}
