//! The file of the audit log: one line a record, put aside by size; what cannot be written is counted.

use crate::time::unix_s;
use railgrip_settings::AuditSettings;
use serde::de::DeserializeOwned;
use std::fs::File;
use std::io::Write;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Receiver;

/// Time between two complaints about a disk that takes nothing, s.
const COMPLAINT_PERIOD_S: i64 = 60;
/// Which file a record goes to; each is put aside by itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shelf {
    /// What somebody did whom we know, and what nobody asked for.
    Known,
    /// What strangers did, or tried to.
    Strangers,
}

impl Shelf {
    /// Its file, where that of the log is known.
    pub(super) fn file(self, log: &Path) -> PathBuf {
        match self {
            Self::Known => log.to_owned(),
            Self::Strangers => {
                let stem = log.file_stem().unwrap_or_default().to_string_lossy();
                log.with_file_name(format!("{stem}-strangers.jsonl"))
            }
        }
    }
}

/// Writes what arrives until the service stops.
pub(super) fn write_all(settings: &AuditSettings, lines: &Receiver<(Shelf, String)>, lost: &AtomicU64) {
    let of = |shelf: Shelf| AuditSettings { file: shelf.file(&settings.file), ..settings.clone() };
    let (known, strangers) = (of(Shelf::Known), of(Shelf::Strangers));
    let mut logs = [&known, &strangers].map(|settings| Rotating { settings, open: None });
    let mut complained_s = None;
    for (shelf, line) in lines {
        let log = &mut logs[usize::from(shelf == Shelf::Strangers)];
        if let Err(error) = log.write(&line) {
            lost.fetch_add(1, Ordering::Relaxed);
            log.open = None;
            let now_s = unix_s();
            if complained_s.is_none_or(|at| now_s - at >= COMPLAINT_PERIOD_S) {
                complained_s = Some(now_s);
                tracing::error!("{}: {error}; the audit log loses records", settings.file.display());
            }
        }
    }
}

/// The current file, put aside when it is full.
struct Rotating<'a> {
    settings: &'a AuditSettings,
    open: Option<(File, u64)>,
}

impl Rotating<'_> {
    fn write(&mut self, line: &str) -> std::io::Result<()> {
        let length = line.len() as u64 + 1;
        if self.open.as_ref().is_some_and(|(_, size)| size + length > self.settings.max_bytes) {
            self.open = None;
            self.rotate()?;
        }
        let (file, size) = match &mut self.open {
            Some(open) => open,
            none => none.insert(open(&self.settings.file)?),
        };
        // One write a line: a kill leaves whole lines.
        file.write_all(format!("{line}\n").as_bytes())?;
        *size += length;
        Ok(())
    }

    /// audit.jsonl → audit.jsonl.1 → … ; the oldest goes.
    fn rotate(&self) -> std::io::Result<()> {
        let numbered = |number: usize| {
            if number == 0 {
                return self.settings.file.clone();
            }
            let mut name = self.settings.file.clone().into_os_string();
            name.push(format!(".{number}"));
            PathBuf::from(name)
        };
        if self.settings.keep == 1 {
            return std::fs::remove_file(numbered(0));
        }
        for number in (0..self.settings.keep - 1).rev() {
            match std::fs::rename(numbered(number), numbered(number + 1)) {
                Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error),
                _ => {}
            }
        }
        Ok(())
    }
}

/// The end of a file, and its size. After a line that a full disk cut off, a new one is begun.
fn open(file: &Path) -> std::io::Result<(File, u64)> {
    if let Some(folder) = file.parent() {
        std::fs::create_dir_all(folder)?;
    }
    let mut opened = File::options().create(true).append(true).read(true).mode(0o600).open(file)?;
    let mut size = opened.metadata()?.len();
    if size > 0 && !ends_with_newline(&opened, size)? {
        opened.write_all(b"\n")?;
        size += 1;
    }
    Ok((opened, size))
}

fn ends_with_newline(file: &File, size: u64) -> std::io::Result<bool> {
    use std::os::unix::fs::FileExt;
    let mut last = [0];
    file.read_exact_at(&mut last, size - 1)?;
    Ok(last == *b"\n")
}

/// The latest records of the log, oldest first; at most so many.
pub(super) fn latest<T: DeserializeOwned>(file: &Path, count: usize) -> std::io::Result<Vec<T>> {
    let text = std::fs::read_to_string(file)?;
    let lines: Vec<&str> = text.lines().collect();
    let from = lines.len().saturating_sub(count);
    Ok(lines[from..].iter().filter_map(|line| serde_json::from_str(line).ok()).collect())
}
