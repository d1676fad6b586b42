//! The notes of all vehicles, in memory and on the disk.

use super::model::{Note, NoteKind};
use crate::time::parse_rfc3339;
use serde::{Deserialize, Serialize};
use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::{Mutex, OnceLock, PoisonError};

/// Most notes of one vehicle that are told at once.
const MOST: usize = 200;

/// Which vehicle a note is about.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Whose {
    /// Its number, letters and digits alone; its name where it has no number.
    pub vehicle: String,
    /// The sign of this start of the train where it has no number: in the next start another vehicle may have the name.
    pub start: Option<String>,
}

/// A note as it is kept: beside what is told, the start of the train within which its vehicle is known.
#[derive(Debug, Serialize, Deserialize)]
struct Kept {
    #[serde(flatten)]
    note: Note,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    start: Option<String>,
}

impl Kept {
    fn is_about(&self, whose: &Whose) -> bool {
        self.note.vehicle == whose.vehicle && self.start == whose.start
    }
}

/// The notes; without a file they last as long as the process.
#[derive(Debug, Default)]
pub struct NoteBook {
    notes: Mutex<Vec<Kept>>,
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
            match serde_json::from_str::<Kept>(line) {
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

    /// Writes a note down; it counts once it is on the disk. `start` is that of its vehicle, see [`Whose`].
    ///
    /// # Errors
    /// A file that cannot be written; the note is then not kept.
    pub fn add(&self, note: Note, start: Option<String>) -> io::Result<()> {
        let kept = Kept { note, start };
        let mut notes = self.notes.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(path) = self.file.get() {
            if let Some(folder) = path.parent() {
                std::fs::create_dir_all(folder)?;
            }
            let mut file = OpenOptions::new().create(true).append(true).open(path)?;
            // Begins with a line end: half a line of an earlier power cut must not swallow this one.
            let line = serde_json::to_string(&kept).map_err(io::Error::other)?;
            file.write_all(format!("\n{line}\n").as_bytes())?;
            file.sync_all()?;
        }
        notes.push(kept);
        Ok(())
    }

    /// The latest notes of a vehicle, the newest first.
    #[must_use]
    pub fn of(&self, whose: &Whose) -> Vec<Note> {
        let notes = self.notes.lock().unwrap_or_else(PoisonError::into_inner);
        let of_vehicle = notes.iter().rev().filter(|kept| kept.is_about(whose));
        of_vehicle.take(MOST).map(|kept| kept.note.clone()).collect()
    }

    /// When the pads of a vehicle were changed last, RFC 3339.
    #[must_use]
    pub fn pads_changed(&self, whose: &Whose) -> Option<String> {
        let notes = self.notes.lock().unwrap_or_else(PoisonError::into_inner);
        let mut of_vehicle = notes.iter().rev().filter(|kept| kept.is_about(whose));
        of_vehicle.find(|kept| kept.note.kind == NoteKind::PadsChanged).map(|kept| kept.note.at.clone())
    }

    /// The same in seconds since 1970.
    #[must_use]
    pub fn pads_changed_unix_s(&self, whose: &Whose) -> Option<i64> {
        self.pads_changed(whose).and_then(|at| parse_rfc3339(&at)).map(|at| at.floor() as i64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn note(vehicle: &str, at: &str, kind: NoteKind, text: &str) -> Note {
        let text = Some(text.to_owned());
        let (vehicle, at, by) = (vehicle.to_owned(), at.to_owned(), "fitter".to_owned());
        Note { vehicle, at, by, kind, text }
    }

    fn whose(vehicle: &str) -> Whose {
        Whose { vehicle: vehicle.to_owned(), start: None }
    }

    #[test]
    fn notes_outlive_the_process_and_half_a_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("below").join("notes.jsonl");
        let book = NoteBook::default();
        book.keep(path.clone());
        book.add(note("a", "2026-03-01T12:00:00Z", NoteKind::PadsChanged, "left side"), None).unwrap();
        book.add(note("b", "2026-03-01T12:05:00Z", NoteKind::Note, "squeals"), None).unwrap();
        // A power cut in the middle of a line.
        let mut file = OpenOptions::new().append(true).open(&path).unwrap();
        file.write_all(b"{\"vehicle\":\"a\",\"at\":\"2026-03-").unwrap();
        let again = NoteBook::default();
        again.keep(path.clone());
        again.add(note("a", "2026-03-02T12:00:00Z", NoteKind::Note, "\u{e4}\n2nd line"), None).unwrap();
        let third = NoteBook::default();
        third.keep(path);
        let words: Vec<Option<String>> = third.of(&whose("a")).into_iter().map(|note| note.text).collect();
        assert_eq!(words, [Some("\u{e4}\n2nd line".to_owned()), Some("left side".to_owned())]);
        assert_eq!(third.of(&whose("b")).len(), 1);
        assert_eq!(third.pads_changed_unix_s(&whose("a")), Some(1_772_366_400));
        assert_eq!(third.pads_changed(&whose("b")), None);
    }

    #[test]
    fn what_cannot_be_written_is_not_kept() {
        let folder = tempfile::tempdir().unwrap();
        let book = NoteBook::default();
        // A folder stands where the file should be.
        book.keep(folder.path().to_owned());
        assert!(book.add(note("a", "2026-03-01T12:00:00Z", NoteKind::Note, "x"), None).is_err());
        assert!(book.of(&whose("a")).is_empty());
    }
}
