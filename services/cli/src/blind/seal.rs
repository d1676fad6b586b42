//! The seal: a hash that is published before the first diagnosis and opened after the last.

use std::path::Path;

use sha2::{Digest, Sha256};

use super::{digest::hex, files::write, make::Made};
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
