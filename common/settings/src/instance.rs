//! Where one running train keeps its channels and files, apart from every other train on the machine.

use crate::SettingsError;
use crate::identity::VehicleNumber;
use crate::place::ConfigText;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// Longest path of the folder: with the names of the sockets in it, it fits into the 107 bytes of a socket path.
const MAX_DIR: usize = 92;

#[derive(Debug, Default, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct InstanceTable {
    /// Folder of the channels and files of this train; without it `$XDG_RUNTIME_DIR/railgrip/NAME`.
    pub dir: Option<String>,
    /// Prefix of its shared-memory files, 1 to 16 letters, digits, `-`, `_`; without it made from `dir`.
    pub prefix: Option<String>,
    /// Where estimators keep their snapshots; without it `snapshots` in `dir`.
    pub snapshot_dir: Option<String>,
}

/// Folders and names of one running train.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Instance {
    /// Folder of everything that lives while the train runs.
    pub dir: PathBuf,
    /// Prefix of its shared-memory files.
    pub prefix: String,
    /// Where estimators keep their snapshots.
    pub snapshot_dir: PathBuf,
    /// What outlives the computer's night: systemd's state folder, where it gives one.
    state_dir: Option<PathBuf>,
}

impl Instance {
    /// File with the address that the HTTP service listens on, for example `127.0.0.1:8080`.
    #[must_use]
    pub fn http_address_file(&self) -> PathBuf {
        self.dir.join("http.address")
    }

    /// What the config said when it was last accepted by `railgrip up`: its processes start by that, whatever has happened to
    /// the file since.
    #[must_use]
    pub fn accepted_config(&self) -> PathBuf {
        self.dir.join("config.accepted")
    }

    /// Folder with recordings of what the model does not explain, a case of `railgrip gap diagnose` each.
    #[must_use]
    pub fn gap_folder(&self) -> PathBuf {
        self.dir.join("gaps")
    }

    /// Socket of the HTTP service for the user that runs the train; there while the network address is shut to strangers.
    #[must_use]
    pub fn http_socket(&self) -> PathBuf {
        self.dir.join("http.sock")
    }

    /// Snapshot of a wagon's estimator: that of the vehicle wherever it runs, else that of the place in the train.
    #[must_use]
    pub fn snapshot_file(&self, wagon: u32, vehicle: Option<&VehicleNumber>) -> PathBuf {
        let name = match vehicle {
            Some(vehicle) => format!("vehicle-{}.snapshot", vehicle.key()),
            None => format!("wagon-{wagon}.snapshot"),
        };
        self.snapshot_dir.join(name)
    }

    /// Where a wagon's estimator notes how far it has come, for whoever comes after it.
    #[must_use]
    pub fn absence_file(&self, wagon: u32) -> PathBuf {
        self.dir.join(format!("estimator-{wagon}.ledger"))
    }

    /// What the judge of the train has learnt.
    #[must_use]
    pub fn judgement_file(&self) -> PathBuf {
        self.state_dir.as_ref().unwrap_or(&self.snapshot_dir).join("train.snapshot")
    }

    /// Folder of what shall outlive the computer's night: under systemd its state folder, else that of the instance where it was
    /// asked for.
    pub(crate) fn lasting_dir<'a>(&'a self, asked_for: Option<&'a Path>) -> Option<&'a Path> {
        self.state_dir.as_deref().or(asked_for)
    }

    /// File with the sign of this start of the train; it stays the same while single processes are started again.
    fn session_file(&self) -> PathBuf {
        self.dir.join("session")
    }

    /// The sign of this start of the train; empty where it has none.
    #[must_use]
    pub fn session(&self) -> String {
        std::fs::read_to_string(self.session_file()).unwrap_or_default().trim().to_owned()
    }

    /// Gives this start of the train a sign of its own.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn begin_session(&self) -> std::io::Result<()> {
        let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
        let beside = self.dir.join("session.new");
        std::fs::write(&beside, format!("{} {}\n", since.as_nanos(), std::process::id()))?;
        std::fs::rename(&beside, self.session_file())
    }

    pub(crate) fn of(
        at: &ConfigText<'_>,
        table: &InstanceTable,
        train: &str,
        dir_override: Option<&Path>,
    ) -> Result<Self, SettingsError> {
        let given = dir_override.map(Path::to_owned).or_else(|| table.dir.as_ref().map(PathBuf::from));
        let dir = given.unwrap_or_else(|| runtime_folder().join(train));
        let dir = std::path::absolute(&dir)
            .map_err(|error| at.refuse("instance.dir", dir.display(), format!("a folder ({error})")))?;
        let prefix = match &table.prefix {
            Some(prefix) => at.or(check_prefix(at, prefix), String::new()),
            None => format!("rg{:08x}_", fingerprint(&dir)),
        };
        let snapshot_dir = match &table.snapshot_dir {
            Some(given) => at.file.parent().unwrap_or(Path::new("")).join(given),
            None => dir.join("snapshots"),
        };
        let instance = Self { dir, prefix, snapshot_dir, state_dir: systemd_state(train) };
        let length = instance.dir.as_os_str().len();
        if length > MAX_DIR {
            let allowed = format!("a path that is {} bytes shorter", length - MAX_DIR);
            at.note(at.refuse("instance.dir", instance.dir.display(), allowed));
        }
        Ok(instance)
    }
}

/// Where systemd has a service keep what lasts (`StateDirectory=`), by train; `None` for what it does not run.
pub(crate) fn systemd_state(train: &str) -> Option<PathBuf> {
    let folders = std::env::var_os("STATE_DIRECTORY").filter(|value| !value.is_empty())?;
    folders.to_string_lossy().split(':').next().map(|first| Path::new(first).join(train))
}

fn check_prefix(at: &ConfigText<'_>, prefix: &str) -> Result<String, SettingsError> {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    if (1..=16).contains(&prefix.len()) && prefix.chars().all(plain) {
        return Ok(prefix.to_owned());
    }
    Err(at.refuse("instance.prefix", format!("{prefix:?}"), "1 to 16 letters, digits, `-`, `_`"))
}

/// `$XDG_RUNTIME_DIR/railgrip`, else a folder of this user among the temporary ones.
fn runtime_folder() -> PathBuf {
    match std::env::var_os("XDG_RUNTIME_DIR") {
        Some(dir) if !dir.is_empty() => PathBuf::from(dir).join("railgrip"),
        _ => std::env::temp_dir().join(format!("railgrip-{}", rustix::process::getuid().as_raw())),
    }
}

/// FNV-1a over the path: two folders get two prefixes, one folder always the same.
fn fingerprint(path: &Path) -> u32 {
    path.as_os_str()
        .as_encoded_bytes()
        .iter()
        .fold(0x811c_9dc5, |hash: u32, byte| (hash ^ u32::from(*byte)).wrapping_mul(0x0100_0193))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn instance(dir: Option<&str>, prefix: Option<&str>) -> Result<Instance, SettingsError> {
        let table = InstanceTable {
            dir: dir.map(str::to_owned),
            prefix: prefix.map(str::to_owned),
            snapshot_dir: None,
        };
        let at = ConfigText::new(Path::new("x.toml"), "");
        let instance = Instance::of(&at, &table, "demo", None)?;
        at.into_found().pop().map_or(Ok(instance), Err)
    }

    #[test]
    fn two_folders_have_two_prefixes() {
        let (one, two) =
            (instance(Some("/tmp/one"), None).unwrap(), instance(Some("/tmp/two"), None).unwrap());
        assert_ne!(one.prefix, two.prefix);
        assert_eq!(one, instance(Some("/tmp/one"), None).unwrap());
        assert_eq!(one.snapshot_file(3, None), Path::new("/tmp/one/snapshots/wagon-3.snapshot"));
        let number = VehicleNumber::new("51 80-7");
        let file = Path::new("/tmp/one/snapshots/vehicle-51807.snapshot");
        assert_eq!(one.snapshot_file(3, number.as_ref()), file);
    }

    #[test]
    fn a_path_too_long_for_sockets_is_refused_with_what_to_cut() {
        let said = instance(Some(&format!("/tmp/{}", "x".repeat(90))), None).unwrap_err().to_string();
        assert!(said.contains("instance.dir") && said.contains("shorter"), "{said}");
        let said = instance(None, Some("a/b")).unwrap_err().to_string();
        assert!(said.contains("instance.prefix"), "{said}");
    }
}
