//! The seal: a hash that is published before anything is judged and opened after the last.

use std::{fs::File, io::Read, path::Path};

use serde::Serialize;
use sha2::{Digest, Sha256};

use super::{
    digest::hex,
    files::{read, write},
};
use crate::CliError;

/// Name of the published hash, of the salt and of the labels.
const HASH: &str = "sealed.sha256";
const SALT: &str = "salt.txt";
const LABELS: &str = "labels.json";

/// Labels and salt behind a published hash. `cat salt.txt labels.json | sha256sum` gives the hash once they are open.
pub(crate) struct Sealed {
    salt: String,
    labels: String,
    digest: String,
}

impl Sealed {
    /// Seals the labels with a salt.
    pub(crate) fn new<T: Serialize + ?Sized>(salt: String, labels: &T) -> Result<Self, CliError> {
        let labels = serde_json::to_string_pretty(labels).map_err(CliError::failed)?;
        Ok(Self::of(salt, labels))
    }

    fn of(salt: String, labels: String) -> Self {
        let digest = hex(Sha256::new().chain_update(&salt).chain_update(&labels).finalize().as_slice());
        Self { salt, labels, digest }
    }

    /// Salt and labels as they lie open in a folder.
    pub(crate) fn read(folder: &Path) -> Result<Self, CliError> {
        Ok(Self::of(read(&folder.join(SALT))?, read(&folder.join(LABELS))?))
    }

    /// The salt, for whoever made the labels.
    pub(crate) fn salt(&self) -> &str {
        &self.salt
    }

    /// The published hash.
    pub(crate) fn digest(&self) -> &str {
        &self.digest
    }

    /// The labels as text.
    pub(crate) fn labels(&self) -> &str {
        &self.labels
    }

    /// Publishes the hash to `sealed.sha256` and stdout.
    pub(crate) fn publish(&self, out: &Path) -> Result<(), CliError> {
        write(&out.join(HASH), &format!("{}\n", self.digest))?;
        crate::output::say(&format!("sealed: SHA-256 over salt and labels is {}", self.digest));
        Ok(())
    }

    /// Fails unless this is what was published.
    pub(crate) fn check(&self, out: &Path) -> Result<(), CliError> {
        let published = read(&out.join(HASH))?;
        if published.trim() == self.digest {
            return Ok(());
        }
        Err(CliError::failed(format!(
            "the seal is broken: SHA-256 over salt and labels is {}, {} says {}",
            self.digest,
            out.join(HASH).display(),
            published.trim()
        )))
    }

    /// Writes salt and labels where they can be read.
    pub(crate) fn open(&self, out: &Path) -> Result<(), CliError> {
        write(&out.join(SALT), &self.salt)?;
        write(&out.join(LABELS), &self.labels)
    }
}

/// A salt that nobody can guess.
pub(crate) fn random_salt() -> Result<String, CliError> {
    let mut bytes = [0; 32];
    File::open("/dev/urandom")
        .and_then(|mut source| source.read_exact(&mut bytes))
        .map_err(|error| CliError::failed(format!("no random salt: {error}")))?;
    Ok(hex(&bytes))
}
