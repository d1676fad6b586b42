//! The history over restarts, kills, clock jumps, damage and a full disk.

use railgrip_history::{HistoryError, Reader, Retention, Store, Tier};
use std::path::Path;

const START: i64 = 1_800_000_000;
const COLUMNS: [&str; 2] = ["mu_w", "mu_b"];

fn fill(store: &mut Store, wagon: u32, seconds: std::ops::Range<i64>) {
    for second in seconds {
        for tick in 0..5 {
            let value = second as f32 + 0.1 * tick as f32;
            store.push(wagon, START + second, &[value, f32::NAN]).expect("push");
        }
    }
}

fn means(path: &Path, seconds: std::ops::Range<i64>, step_s: i64) -> Vec<(i64, f32, f32, f32, u32)> {
    let reader = Reader::open(path).expect("open");
    let points =
        reader.query(1, &["mu_w"], START + seconds.start, START + seconds.end, step_s).expect("query");
    points
        .iter()
        .map(|p| (p.unix_s - START, p.cells[0].mean, p.cells[0].min, p.cells[0].max, p.samples))
        .collect()
}

#[test]
fn what_was_flushed_is_read_at_every_step() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("history.db");
    let mut store = Store::open(&path, &COLUMNS).expect("open");
    fill(&mut store, 1, 0..7300);
    fill(&mut store, 2, 0..10);
    let flushed = store.flush(true).expect("flush");
    println!("{} blocks, {} bytes for 7300 s", flushed.blocks, flushed.bytes);

    let seconds = means(&path, 100..160, 1);
    assert_eq!(seconds.len(), 60);
    assert!(
        (seconds[0].1 - 100.2).abs() < 1e-4 && seconds[0].2 == 100.0 && seconds[0].4 == 5,
        "{:?}",
        seconds[0]
    );
    let tens = means(&path, 100..160, 10);
    assert_eq!(tens.len(), 6);
    assert!((tens[0].1 - 104.7).abs() < 1e-3 && tens[0].2 == 100.0 && (tens[0].3 - 109.4).abs() < 1e-4);
    let minutes = means(&path, 0..7200, 60);
    assert_eq!(minutes.len(), 120);
    assert!(
        (minutes[2].1 - 149.7).abs() < 1e-2 && minutes[2].2 == 120.0 && minutes[2].4 == 300,
        "{:?}",
        minutes[2]
    );
    let hours = means(&path, 0..7200, 3600);
    assert_eq!((hours.len(), hours[1].4), (2, 18_000));
    let other =
        Reader::open(&path).expect("open").query(1, &["mu_b", "none"], START, START + 5, 1).expect("query");
    assert!(other.iter().all(|p| p.cells.iter().all(|cell| cell.mean.is_nan())));
}

#[test]
fn a_store_that_was_dropped_goes_on_where_it_was_flushed() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("history.db");
    let mut store = Store::open(&path, &COLUMNS).expect("open");
    fill(&mut store, 1, 0..3640);
    store.flush(false).expect("flush");
    fill(&mut store, 1, 3640..3645);
    // The process dies here: no flush, no goodbye.
    drop(store);
    let mut store = Store::open(&path, &COLUMNS).expect("open again");
    fill(&mut store, 1, 3650..3700);
    store.flush(true).expect("flush");
    assert_eq!(means(&path, 3600..3700, 1).len(), 40 + 50);
    let minutes = means(&path, 3600..3660, 60);
    assert_eq!(minutes[0].4, 5 * (40 + 10), "the minute was computed again from its seconds: {minutes:?}");
    let hours: u32 = means(&path, 0..7200, 3600).iter().map(|hour| hour.4).sum();
    assert_eq!(hours, 5 * (3640 + 50));
}

#[test]
fn a_clock_that_jumps_back_merges() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("history.db");
    let mut store = Store::open(&path, &COLUMNS).expect("open");
    fill(&mut store, 1, 0..300);
    store.flush(false).expect("flush");
    fill(&mut store, 1, 100..110);
    store.flush(true).expect("flush");
    let seconds = means(&path, 0..300, 1);
    assert_eq!(seconds.len(), 300);
    assert!(seconds.iter().all(|s| s.4 == if (100..110).contains(&s.0) { 10 } else { 5 }));
}

#[test]
fn new_columns_join_old_blocks() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("history.db");
    let mut store = Store::open(&path, &COLUMNS).expect("open");
    fill(&mut store, 1, 0..30);
    store.flush(false).expect("flush");
    drop(store);
    let mut store = Store::open(&path, &["slip", "mu_w"]).expect("open");
    store.push(1, START + 30, &[7.0, 30.0]).expect("push");
    store.flush(false).expect("flush");
    let points =
        Reader::open(&path).expect("open").query(1, &["mu_w", "slip"], START, START + 60, 1).expect("query");
    assert_eq!(points.len(), 31);
    assert_eq!((points[30].cells[0].mean, points[30].cells[1].mean), (30.0, 7.0));
    assert!(points[3].cells[1].mean.is_nan() && (points[3].cells[0].mean - 3.2).abs() < 1e-5);
}

#[test]
fn retention_drops_by_age_and_by_size() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("history.db");
    let mut store = Store::open(&path, &COLUMNS).expect("open");
    fill(&mut store, 1, 0..7200);
    store.flush(true).expect("flush");
    let keep_an_hour = Retention { second_s: 3600, ..Retention::default() };
    assert!(store.prune(&keep_an_hour, START + 7200).expect("prune") >= 59);
    assert!(means(&path, 0..3500, 1).is_empty());
    assert_eq!(means(&path, 3600..7200, 1).len(), 3600);
    assert_eq!(means(&path, 0..7200, 60).len(), 120, "minutes stay");
    let before = store.size_bytes().expect("size");
    let tiny = Retention { size_bytes: 1, ..Retention::default() };
    store.prune(&tiny, START + 7200).expect("prune");
    assert!(store.size_bytes().expect("size") <= before);
    assert!(means(&path, 0..7200, 1).is_empty(), "the oldest seconds go first");
    assert!(!means(&path, 0..7200, 3600).is_empty(), "hours stay");
}

#[test]
fn a_damaged_database_is_set_aside() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("history.db");
    std::fs::write(&path, b"this was a database before the power went").expect("write");
    let mut store = Store::open(&path, &COLUMNS).expect("open");
    assert!(store.set_aside().is_some_and(Path::exists));
    fill(&mut store, 1, 0..3);
    store.flush(false).expect("flush");
    assert_eq!(means(&path, 0..3, 1).len(), 3);
}

#[test]
fn a_newer_database_is_refused_and_untouched() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("history.db");
    drop(Store::open(&path, &COLUMNS).expect("open"));
    let raw = rusqlite::Connection::open(&path).expect("open");
    raw.pragma_update(None, "user_version", 99).expect("set");
    drop(raw);
    assert!(matches!(Store::open(&path, &COLUMNS), Err(HistoryError::Newer { found: 99, .. })));
}

#[test]
fn a_full_disk_pauses_the_history_and_loses_nothing() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("history.db");
    let mut store = Store::open(&path, &COLUMNS).expect("open");
    fill(&mut store, 1, 0..60);
    store.flush(false).expect("flush");
    store.limit_pages(1).expect("limit");
    fill(&mut store, 1, 60..12_000);
    let error = store.flush(false).expect_err("there is no room");
    assert!(error.is_storage(), "{error}");
    store.limit_pages(1_000_000).expect("limit");
    store.flush(true).expect("room again");
    assert_eq!(means(&path, 0..12_000, 1).len(), 12_000);
    assert_eq!(store.dropped_blocks(), 0);
}

#[test]
fn the_tier_follows_the_step() {
    assert_eq!(
        [1, 59, 60, 3599, 3600, 86_400].map(Reader::tier),
        [Tier::Second, Tier::Second, Tier::Minute, Tier::Minute, Tier::Hour, Tier::Hour]
    );
}
