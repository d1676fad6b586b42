//! Figures that survive the death of the process that wrote them, at whatever instant it dies.
//!
//! A file of two slots that are written in turn, each with a running number and a checksum: a kill spoils one of them at most, and
//! what was written to the other is still there. Nothing is forced onto a disk, so that writing costs microseconds: a successor
//! on the same running computer reads what was written last.
//!
//! Figures that come true one after another (batches that are sent, say) are written first, and then marked as far as they are true:
//! a successor gets the figures before, those after, and how far it went.

use std::fs::File;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::Result;
use std::os::unix::fs::{FileExt, OpenOptionsExt};
use std::path::Path;

/// Running number and checksum of a slot.
const FRAME_WORDS: usize = 2;
const WORD_BYTES: usize = 8;

/// What a predecessor has left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Left {
    /// The figures that it wrote last.
    pub latest: Vec<u64>,
    /// Those before, if they are still there.
    pub before: Option<Vec<u64>>,
    /// How far the latest ones had come true.
    pub done: u64,
}

/// Such a file.
#[derive(Debug)]
pub struct Ledger {
    file: File,
    /// Begins every checksum: a file that is about something else has no valid slot.
    seed: u64,
    round: u64,
    buffer: Vec<u8>,
    words: usize,
}

impl Ledger {
    /// Opens the file or makes it, and gives what a predecessor has left, if it wrote so many figures and about the same.
    ///
    /// # Errors
    /// A file that cannot be made or read.
    pub fn open(file: &Path, about: &impl Hash, words: usize) -> Result<(Self, Option<Left>)> {
        let mut hasher = DefaultHasher::new();
        (about, words).hash(&mut hasher);
        let mut options = File::options();
        let file = options.read(true).write(true).create(true).truncate(false).mode(0o600).open(file)?;
        let bytes = (words + FRAME_WORDS) * WORD_BYTES;
        let mut ledger = Self { file, seed: hasher.finish(), round: 0, buffer: vec![0; bytes], words };
        let mut slots: Vec<_> = (0..2).filter_map(|slot| ledger.read(slot)).collect();
        slots.sort_by_key(|(round, _)| *round);
        let Some((round, latest)) = slots.pop() else { return Ok((ledger, None)) };
        ledger.round = round;
        let before = slots.pop().map(|(_, figures)| figures);
        let done = ledger.done().filter(|(marked, _)| *marked == round).map_or(0, |(_, done)| done);
        Ok((ledger, Some(Left { latest, before, done })))
    }

    /// Writes these figures; there must be as many as were announced.
    ///
    /// # Errors
    /// A file that cannot be written, or another number of figures.
    pub fn write(&mut self, figures: &[u64]) -> Result<()> {
        if figures.len() != self.words {
            return Err(std::io::ErrorKind::InvalidInput.into());
        }
        self.round += 1;
        let sum = checksum(self.seed, self.round, figures);
        let words = [self.round, sum].into_iter().chain(figures.iter().copied());
        for (place, word) in self.buffer.chunks_exact_mut(WORD_BYTES).zip(words) {
            place.copy_from_slice(&word.to_le_bytes());
        }
        self.file.write_all_at(&self.buffer, self.offset(self.round % 2))
    }

    /// Marks how far the figures that were written last have come true.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn mark(&mut self, done: u64) -> Result<()> {
        let mut bytes = [0; 2 * WORD_BYTES];
        bytes[..WORD_BYTES].copy_from_slice(&self.round.to_le_bytes());
        bytes[WORD_BYTES..].copy_from_slice(&done.to_le_bytes());
        self.file.write_all_at(&bytes, self.offset(2))
    }

    /// Which figures were marked last, and how far.
    fn done(&self) -> Option<(u64, u64)> {
        let mut bytes = [0; 2 * WORD_BYTES];
        self.file.read_exact_at(&mut bytes, self.offset(2)).ok()?;
        let (round, done) = bytes.split_at(WORD_BYTES);
        Some((u64::from_le_bytes(round.try_into().ok()?), u64::from_le_bytes(done.try_into().ok()?)))
    }

    fn offset(&self, slot: u64) -> u64 {
        slot * self.buffer.len() as u64
    }

    /// Running number and figures of a slot, if it is whole and about the same.
    fn read(&self, slot: u64) -> Option<(u64, Vec<u64>)> {
        let mut bytes = vec![0; self.buffer.len()];
        self.file.read_exact_at(&mut bytes, self.offset(slot)).ok()?;
        let mut words: Vec<u64> = bytes
            .chunks_exact(WORD_BYTES)
            .filter_map(|word| Some(u64::from_le_bytes(word.try_into().ok()?)))
            .collect();
        let figures = words.split_off(FRAME_WORDS);
        let (round, sum) = (*words.first()?, *words.get(1)?);
        (sum == checksum(self.seed, round, &figures)).then_some((round, figures))
    }
}

/// FNV-1a by words: finds what is torn or foreign, not what is forged.
fn checksum(seed: u64, round: u64, figures: &[u64]) -> u64 {
    let words = std::iter::once(&round).chain(figures);
    words.fold(0xcbf2_9ce4_8422_2325 ^ seed, |sum, word| (sum ^ word).wrapping_mul(0x0100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn left(file: &Path, about: &str) -> Option<Left> {
        Ledger::open(file, &about, 2).expect("opened").1
    }

    #[test]
    fn a_successor_reads_what_was_written_last_and_nothing_about_something_else() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("ledger");
        let (mut ledger, nothing) = Ledger::open(&file, &"a", 2).expect("opened");
        assert_eq!(nothing, None);
        let mut before = None;
        for round in 1..=5_u64 {
            let latest = vec![round, u64::MAX - round];
            ledger.write(&latest).expect("written");
            assert_eq!(
                left(&file, "a"),
                Some(Left { latest: latest.clone(), before: before.clone(), done: 0 })
            );
            ledger.mark(round + 7).expect("written");
            assert_eq!(left(&file, "a").map(|left| left.done), Some(round + 7));
            before = Some(latest);
        }
        assert_eq!(left(&file, "b"), None);
        assert_eq!(Ledger::open(&file, &"a", 3).expect("opened").1, None);
        assert!(ledger.write(&[1]).is_err());
        // A successor goes on where it was.
        let (mut successor, _) = Ledger::open(&file, &"a", 2).expect("opened");
        successor.write(&[6, 6]).expect("written");
        assert_eq!(left(&file, "a"), Some(Left { latest: vec![6, 6], before, done: 0 }));
    }

    #[test]
    fn of_a_write_that_was_cut_short_the_one_before_is_left() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("ledger");
        let (mut ledger, _) = Ledger::open(&file, &"a", 2).expect("opened");
        ledger.write(&[1, 2]).expect("written");
        let before = std::fs::read(&file).expect("read");
        ledger.write(&[4, 5]).expect("written");
        let after = std::fs::read(&file).expect("read");
        for cut in 0..=after.len() {
            let mut torn = after[..cut].to_vec();
            torn.extend(before.get(cut..).unwrap_or_default());
            std::fs::write(&file, &torn).expect("written");
            let read = left(&file, "a").unwrap_or_else(|| panic!("nothing is left, cut at {cut}")).latest;
            assert!(read == [1, 2] || read == [4, 5], "{read:?}");
        }
    }
}
