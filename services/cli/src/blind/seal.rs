//! The seal: a hash that is published before the first diagnosis and opened after the last.

use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};

use sha2::{Digest, Sha256};

use super::{make::Made, write};
use crate::CliError;

/// Labels and salt behind a published hash. `cat salt.txt labels.json | sha256sum` gives the hash once they are open.
pub(super) struct Sealed {
    salt: String,
    labels: String,
    digest: String,
}

impl Sealed {
    /// Seals the labels. The salt follows from the seed, so that an interrupted run continues under the same seal.
    pub(super) fn new(seed: u64, made: &[Made]) -> Result<Self, CliError> {
        let salt = hex(Sha256::digest(format!("railgrip gap blind {seed}")).as_slice());
        let labels = serde_json::to_string_pretty(made).map_err(CliError::failed)?;
        let digest = hex(Sha256::new().chain_update(&salt).chain_update(&labels).finalize().as_slice());
        Ok(Self { salt, labels, digest })
    }

    /// The published hash.
    pub(super) fn digest(&self) -> &str {
        &self.digest
    }

    /// Publishes the hash to `sealed.sha256` and stdout.
    pub(super) fn publish(&self, out: &Path) -> Result<(), CliError> {
        write(&out.join("sealed.sha256"), &format!("{}\n", self.digest))?;
        crate::output::say(&format!("sealed: SHA-256 over salt and labels is {}", self.digest));
        Ok(())
    }

    /// Opens salt and labels.
    pub(super) fn open(&self, out: &Path) -> Result<(), CliError> {
        write(&out.join("salt.txt"), &self.salt)?;
        write(&out.join("labels.json"), &self.labels)
    }
}

/// SHA-256 over names and contents of all files below a folder, in the order of their names.
pub(super) fn digest_of_folder(folder: &Path) -> Result<String, CliError> {
    let mut paths = Vec::new();
    list(folder, &mut paths)?;
    paths.sort();
    let mut hasher = Sha256::new();
    for path in paths {
        let name = path.strip_prefix(folder).unwrap_or(&path);
        hasher.update(name.to_string_lossy().as_bytes());
        hasher.update(fs::read(&path).map_err(|error| cannot_read(&path, &error))?);
    }
    Ok(hex(hasher.finalize().as_slice()))
}

fn list(folder: &Path, paths: &mut Vec<PathBuf>) -> Result<(), CliError> {
    for entry in fs::read_dir(folder).map_err(|error| cannot_read(folder, &error))? {
        let path = entry.map_err(|error| cannot_read(folder, &error))?.path();
        if path.is_dir() { list(&path, paths)? } else { paths.push(path) }
    }
    Ok(())
}

fn cannot_read(path: &Path, error: &std::io::Error) -> CliError {
    CliError::failed(format!("cannot read {}: {error}", path.display()))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::with_capacity(2 * bytes.len()), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
