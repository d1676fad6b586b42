//! Files in which a process keeps what it knows for its successor.
//!
//! A line that names the form, a checksum, the state. A file is written beside its place and renamed into it, so that no reader
//! sees half of one; what is damaged or of another form is refused with what is wrong.

use std::io::Write;
use std::path::{Path, PathBuf};

const CHECKSUM_BYTES: usize = 8;

/// Why a file was not used or not written.
#[derive(Debug, thiserror::Error)]
pub enum KeptError {
    /// The file cannot be read or written.
    #[error("{}: {source}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The file is damaged or of another form.
    #[error("{}: {problem}", file.display())]
    Form {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        problem: &'static str,
    },
}

impl KeptError {
    /// The file holds something else than it should.
    #[must_use]
    pub fn form(file: &Path, problem: &'static str) -> Self {
        Self::Form { file: file.to_owned(), problem }
    }
}

/// Keeps `state`; `form` is the first line of the file, without its end, and changes whenever the layout of the state does.
///
/// # Errors
/// If the file cannot be written.
pub fn keep(file: &Path, form: &str, state: &[u8]) -> Result<(), KeptError> {
    let failed = |source| KeptError::File { file: file.to_owned(), source };
    let beside = file.with_extension("new");
    let mut out = std::fs::File::create(&beside).map_err(failed)?;
    let parts: [&[u8]; 4] = [form.as_bytes(), b"\n", &checksum(state).to_le_bytes(), state];
    parts.iter().try_for_each(|part| out.write_all(part)).map_err(failed)?;
    std::fs::rename(&beside, file).map_err(failed)
}

/// What was kept in the file; `None` if there is none.
///
/// # Errors
/// A file that cannot be read, is damaged, or is of another form.
pub fn kept(file: &Path, form: &str) -> Result<Option<Vec<u8>>, KeptError> {
    let mut bytes = match std::fs::read(file) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(source) => return Err(KeptError::File { file: file.to_owned(), source }),
    };
    let rest = bytes.strip_prefix(form.as_bytes()).and_then(|rest| rest.strip_prefix(b"\n"));
    let rest = rest.ok_or_else(|| KeptError::form(file, "not a snapshot of this version"))?;
    let (sum, state) =
        rest.split_at_checked(CHECKSUM_BYTES).ok_or_else(|| KeptError::form(file, "cut short"))?;
    if sum != checksum(state).to_le_bytes() {
        return Err(KeptError::form(file, "damaged: its checksum does not match"));
    }
    let from = bytes.len() - state.len();
    bytes.drain(..from);
    Ok(Some(bytes))
}

/// FNV-1a, 64 bit: finds torn and damaged files, not forged ones.
fn checksum(bytes: &[u8]) -> u64 {
    bytes
        .iter()
        .fold(0xcbf2_9ce4_8422_2325, |sum, byte| (sum ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_kept_comes_back_and_what_was_damaged_is_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("x.snapshot");
        assert!(kept(&file, "form 1").expect("no file is no error").is_none());
        keep(&file, "form 1", b"state").expect("written");
        assert_eq!(kept(&file, "form 1").expect("read").as_deref(), Some(&b"state"[..]));
        let problem = |form| kept(&file, form).expect_err("refused").to_string();
        assert!(problem("form 2").ends_with("not a snapshot of this version"));
        let whole = std::fs::read(&file).expect("read");
        for cut in 7..whole.len() {
            std::fs::write(&file, &whole[..cut]).expect("written");
            assert!(kept(&file, "form 1").is_err(), "cut to {cut} bytes");
        }
        for place in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[place] ^= 0x40;
            std::fs::write(&file, &bytes).expect("written");
            assert!(kept(&file, "form 1").is_err(), "byte {place}");
        }
    }
}
