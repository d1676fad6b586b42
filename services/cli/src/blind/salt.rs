//! The salt of a blind test: random, kept from everybody but its owner until the labels are opened.

use std::{fs, os::unix::fs::PermissionsExt, path::Path};

use sha2::{Digest, Sha256};

use crate::CliError;
use crate::sealed::{
    files::{cannot_write, read, write},
    seal::random_salt,
};

/// Folder that only its owner may read, and the salt in it.
const FOLDER: &str = "sealed";
const FILE: &str = "salt.txt";

/// The salt that was asked for, that of an interrupted run in this folder, or a new one.
pub(super) fn of(out: &Path, asked: Option<&str>) -> Result<String, CliError> {
    let folder = out.join(FOLDER);
    let file = folder.join(FILE);
    let salt = match asked {
        Some(salt) => salt.to_owned(),
        None if file.exists() => return read(&file),
        None => random_salt()?,
    };
    fs::create_dir_all(&folder).map_err(|error| cannot_write(&folder, &error))?;
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o700))
        .map_err(|error| cannot_write(&folder, &error))?;
    write(&file, &salt)?;
    Ok(salt)
}

/// Seed of the cases: from salt and seed together.
pub(super) fn seed(salt: &str, seed: u64) -> u64 {
    let digest =
        Sha256::new().chain_update("cases").chain_update(salt).chain_update(seed.to_le_bytes()).finalize();
    let mut bytes = [0; 8];
    bytes.copy_from_slice(&digest[..8]);
    u64::from_le_bytes(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_salt_is_random_stays_for_a_continuation_and_decides_the_cases() {
        let (first, second) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let salt = of(first.path(), None).unwrap();
        assert_eq!(of(first.path(), None).unwrap(), salt);
        let other = of(second.path(), None).unwrap();
        assert_ne!(other, salt);
        assert_ne!(seed(&salt, 1), seed(&other, 1));
        assert_ne!(seed(&salt, 1), seed(&salt, 2));
        assert_eq!(of(second.path(), Some(&salt)).unwrap(), salt);
        let mode = fs::metadata(first.path().join(FOLDER)).unwrap().permissions().mode();
        assert_eq!(mode & 0o077, 0, "nobody else may read it");
    }
}
