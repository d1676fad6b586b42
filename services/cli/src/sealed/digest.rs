//! SHA-256 of folders, and hashes as text.

use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};

use sha2::{Digest, Sha256};

use crate::CliError;

/// SHA-256 over names and contents of all files below a folder, in the order of their names.
pub(crate) fn digest_of_folder(folder: &Path) -> Result<String, CliError> {
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

/// Hexadecimal text of bytes.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::with_capacity(2 * bytes.len()), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
