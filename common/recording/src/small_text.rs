//! Texts that people write: configs, vehicles, scenarios, descriptions of messages.

use std::fs::File;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// Such a text is no longer than this, bytes; a log or a device that was given by mistake would fill the memory.
const LONGEST: u64 = 32 << 20;

/// Reads a text file of at most 32 MiB; a byte order mark before it is left out.
///
/// # Errors
/// A file that cannot be read, is longer or is no UTF-8 text.
pub fn read_text(path: &Path) -> Result<String> {
    String::from_utf8(read_bytes(path)?).map_err(|_| Error::new(ErrorKind::InvalidData, "not UTF-8 text"))
}

/// Reads a file of at most 32 MiB; a UTF-8 byte order mark before it is left out.
///
/// # Errors
/// A file that cannot be read or is longer.
pub fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    const MARK: [u8; 3] = [0xef, 0xbb, 0xbf];
    let mut bytes = Vec::new();
    // What a device says of its length is nothing to go by.
    File::open(path)?.take(LONGEST + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > LONGEST {
        let why = format!("longer than {} MiB: no such file is", LONGEST >> 20);
        return Err(Error::new(ErrorKind::FileTooLarge, why));
    }
    if bytes.starts_with(&MARK) {
        bytes.drain(..MARK.len());
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_read_and_what_is_none_is_refused() {
        let folder = tempfile::tempdir().expect("folder");
        let file = folder.path().join("a.toml");
        std::fs::write(&file, "\u{feff}schema = 1\n").expect("write");
        assert_eq!(read_text(&file).expect("text"), "schema = 1\n");
        std::fs::write(&file, [0xff, 0xfe, b'a', 0]).expect("write");
        assert_eq!(read_text(&file).expect_err("UTF-16").to_string(), "not UTF-8 text");
        let said = read_text(Path::new("/dev/zero")).expect_err("endless").to_string();
        assert_eq!(said, "longer than 32 MiB: no such file is");
        assert!(read_text(folder.path()).is_err(), "a folder");
    }
}
