//! A power cut in the middle of a write: whatever is left of the files, everything that was acknowledged before is there.
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use railgrip_history::{Keep, Reader, Store};
use std::path::{Path, PathBuf};

const START: i64 = 1_700_000_000 / 86_400 * 86_400;
const COLUMNS: [(&str, Keep); 3] = [("a", Keep::Extremes), ("b", Keep::Extremes), ("c", Keep::Mean)];
const FLUSHES: i64 = 12;
const SECONDS_A_FLUSH: i64 = 10;

/// What the disk holds right after a flush was acknowledged.
struct Acknowledged {
    seconds: i64,
    wal_bytes: usize,
}

fn push(store: &mut Store, second: i64) {
    for wagon in 1..=3 {
        let noise = (second * 7919 + i64::from(wagon) * 104_729) % 1000;
        store.push(wagon, START + second, &[second as f32, noise as f32 * 1e-3, 0.35]).expect("push");
    }
}

fn wal(database: &Path) -> PathBuf {
    database.with_file_name("history.db-wal")
}

/// Writes in batches and copies the files as they are while the writer lives: what a power cut would leave.
fn written(folder: &Path) -> (PathBuf, Vec<Acknowledged>) {
    let path = folder.join("history.db");
    let mut store = Store::open(&path, &COLUMNS).expect("open");
    let mut acknowledged = Vec::new();
    for flush in 0..FLUSHES {
        for second in flush * SECONDS_A_FLUSH..(flush + 1) * SECONDS_A_FLUSH {
            push(&mut store, second);
        }
        store.flush(false).expect("flush");
        let wal_bytes = std::fs::read(wal(&path)).expect("wal").len();
        acknowledged.push(Acknowledged { seconds: (flush + 1) * SECONDS_A_FLUSH, wal_bytes });
    }
    let left = folder.join("left");
    std::fs::create_dir(&left).expect("folder");
    for name in ["history.db", "history.db-wal"] {
        std::fs::copy(folder.join(name), left.join(name)).expect("copy");
    }
    (left, acknowledged)
}

/// Seconds of each wagon that a store opened on these files has; they must be the first ones, unchanged.
fn recovered(database: &Path) -> i64 {
    let mut store = Store::open(database, &COLUMNS).expect("open after the cut");
    assert_eq!(store.set_aside(), None, "the database was taken for damaged");
    let reader = Reader::open(database).expect("open");
    let mut counts = Vec::new();
    for wagon in 1..=3 {
        let points = reader.query(wagon, &["a", "b"], START, START + 10_000, 1).expect("query");
        for (index, point) in points.iter().enumerate() {
            assert_eq!((point.unix_s, point.samples), (START + index as i64, 1));
            assert_eq!(point.cells[0].mean, index as f32);
        }
        let minutes = reader.query(wagon, &["a"], START, START + 10_000, 60).expect("query");
        let samples: u32 = minutes.iter().map(|minute| minute.samples).sum();
        assert_eq!(samples as usize, points.len(), "the tiers agree");
        counts.push(points.len() as i64);
    }
    assert!(counts.iter().all(|count| *count == counts[0]), "a flush is there for all wagons or for none");
    // It can be continued.
    push(&mut store, counts[0]);
    store.flush(true).expect("flush");
    counts[0]
}

#[test]
fn a_log_cut_anywhere_keeps_all_flushes_before_the_cut() {
    let folder = tempfile::tempdir().expect("folder");
    let (left, acknowledged) = written(folder.path());
    let log = std::fs::read(wal(&left.join("history.db"))).expect("wal");
    let database = std::fs::read(left.join("history.db")).expect("database");
    let first = acknowledged[0].wal_bytes;
    let mut cuts = 0;
    for cut in (first..=log.len()).step_by(331) {
        let here = folder.path().join(format!("cut-{cut}"));
        std::fs::create_dir(&here).expect("folder");
        let path = here.join("history.db");
        std::fs::write(&path, &database).expect("write");
        std::fs::write(wal(&path), &log[..cut]).expect("write");
        let promised =
            acknowledged.iter().filter(|flush| flush.wal_bytes <= cut).map(|flush| flush.seconds).max();
        let kept = recovered(&path);
        assert!(kept >= promised.unwrap_or(0), "cut at {cut}: {kept} s of {promised:?}");
        std::fs::remove_dir_all(here).expect("remove");
        cuts += 1;
    }
    println!("{cuts} cuts of a log of {} bytes: nothing acknowledged was lost", log.len());
    assert!(cuts > 100);
}

#[test]
fn a_torn_last_write_keeps_all_flushes_before_it() {
    let folder = tempfile::tempdir().expect("folder");
    let (left, acknowledged) = written(folder.path());
    let log = std::fs::read(wal(&left.join("history.db"))).expect("wal");
    let database = std::fs::read(left.join("history.db")).expect("database");
    let last = &acknowledged[acknowledged.len() - 2];
    let mut torn = 0;
    for at in (last.wal_bytes..log.len()).step_by(97) {
        // Sectors of the last write that never reached the medium: zeros, or what stood there before.
        for fill in [0_u8, 0xff] {
            let mut damaged = log.clone();
            let end = (at + 512).min(log.len());
            damaged[at..end].fill(fill);
            let here = folder.path().join(format!("torn-{at}-{fill}"));
            std::fs::create_dir(&here).expect("folder");
            let path = here.join("history.db");
            std::fs::write(&path, &database).expect("write");
            std::fs::write(wal(&path), &damaged).expect("write");
            let kept = recovered(&path);
            assert!(kept >= last.seconds, "torn at {at}: {kept} s of {}", last.seconds);
            std::fs::remove_dir_all(here).expect("remove");
            torn += 1;
        }
    }
    println!("{torn} torn writes: nothing acknowledged before was lost");
    assert!(torn > 40);
}
