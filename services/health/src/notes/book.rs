//! The notes of all vehicles, in memory and on the disk.

use super::model::{Note, NoteKind};
use crate::time::parse_rfc3339;
use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::{Mutex, OnceLock, PoisonError};

/// Most notes of one vehicle that are told at once.
const MOST: usize = 200;

/// The notes; without a file they last as long as the process.
#[derive(Debug, Default)]
pub struct NoteBook {
    notes: Mutex<Vec<Note>>,
    file: OnceLock<PathBuf>,
}

impl NoteBook {
    /// Keeps notes in `file` from now on, and reads those that are in it. What cannot be read is left alone and named in the
    /// log. Only the first file counts.
    pub fn keep(&self, file: PathBuf) {
        let text = match std::fs::read_to_string(&file) {
            Ok(text) => text,
            Err(error) if error.kind() == io::ErrorKind::NotFound => String::new(),
            Err(error) => {
                tracing::error!("notes {}: {error}", file.display());
                String::new()
            }
        };
        let mut notes = Vec::new();
        for (number, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
            match serde_json::from_str::<Note>(line) {
                Ok(note) => notes.push(note),
                Err(error) => {
                    tracing::warn!("notes {}, line {}: {error}; skipped", file.display(), number + 1);
                }
            }
        }
        if self.file.set(file).is_ok() {
            *self.notes.lock().unwrap_or_else(PoisonError::into_inner) = notes;
        }
    }

    /// Writes a note down; it counts once it is on the disk.
    ///
    /// # Errors
    /// A file that cannot be written; the note is then not kept.
    pub fn add(&self, note: Note) -> io::Result<()> {
        let mut notes = self.notes.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(path) = self.file.get() {
            if let Some(folder) = path.parent() {
                std::fs::create_dir_all(folder)?;
            }
            let mut file = OpenOptions::new().create(true).append(true).open(path)?;
            // Begins with a line end: half a line of an earlier power cut must not swallow this one.
            let line = serde_json::to_string(&note).map_err(io::Error::other)?;
            file.write_all(format!("\n{line}\n").as_bytes())?;
            file.sync_all()?;
        }
        notes.push(note);
        Ok(())
    }

    /// The latest notes of a vehicle, the newest first.
    #[must_use]
    pub fn of(&self, vehicle: &str) -> Vec<Note> {
        let notes = self.notes.lock().unwrap_or_else(PoisonError::into_inner);
        notes.iter().rev().filter(|note| note.vehicle == vehicle).take(MOST).cloned().collect()
    }

    /// When the pads of a vehicle were changed last, RFC 3339.
    #[must_use]
    pub fn pads_changed(&self, vehicle: &str) -> Option<String> {
        let notes = self.notes.lock().unwrap_or_else(PoisonError::into_inner);
        let changes =
            notes.iter().rev().filter(|note| note.vehicle == vehicle && note.kind == NoteKind::PadsChanged);
        changes.map(|note| note.at.clone()).next()
    }

    /// The same in seconds since 1970.
    #[must_use]
    pub fn pads_changed_unix_s(&self, vehicle: &str) -> Option<i64> {
        self.pads_changed(vehicle).and_then(|at| parse_rfc3339(&at)).map(|at| at.floor() as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn note(vehicle: &str, at: &str, kind: NoteKind, text: &str) -> Note {
        let text = Some(text.to_owned());
        Note { vehicle: vehicle.to_owned(), at: at.to_owned(), by: "fitter".to_owned(), kind, text }
    }

    #[test]
    fn notes_outlive_the_process_and_half_a_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("below").join("notes.jsonl");
        let book = NoteBook::default();
        book.keep(path.clone());
        book.add(note("a", "2026-03-01T12:00:00Z", NoteKind::PadsChanged, "left side")).unwrap();
        book.add(note("b", "2026-03-01T12:05:00Z", NoteKind::Note, "squeals")).unwrap();
        // A power cut in the middle of a line.
        let mut file = OpenOptions::new().append(true).open(&path).unwrap();
        file.write_all(b"{\"vehicle\":\"a\",\"at\":\"2026-03-").unwrap();
        let again = NoteBook::default();
        again.keep(path.clone());
        again.add(note("a", "2026-03-02T12:00:00Z", NoteKind::Note, "\u{e4}\n2nd line")).unwrap();
        let third = NoteBook::default();
        third.keep(path);
        let words: Vec<Option<String>> = third.of("a").into_iter().map(|note| note.text).collect();
        assert_eq!(words, [Some("\u{e4}\n2nd line".to_owned()), Some("left side".to_owned())]);
        assert_eq!(third.of("b").len(), 1);
        assert_eq!(third.pads_changed_unix_s("a"), Some(1_772_366_400));
        assert_eq!(third.pads_changed("b"), None);
    }

    #[test]
    fn what_cannot_be_written_is_not_kept() {
        let folder = tempfile::tempdir().unwrap();
        let book = NoteBook::default();
        // A folder stands where the file should be.
        book.keep(folder.path().to_owned());
        assert!(book.add(note("a", "2026-03-01T12:00:00Z", NoteKind::Note, "x")).is_err());
        assert!(book.of("a").is_empty());
    }
}
