//! The history over restarts, clock jumps, damage and a full disk.
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use railgrip_history::{
    Event, EventFilter, FormerName, HistoryError, Keep, Limits, Reader, Retention, Store, Tier,
};
use std::path::Path;

const START: i64 = 1_700_000_000 / 86_400 * 86_400;
const COLUMNS: [(&str, Keep); 2] = [("mu_w", Keep::Extremes), ("mu_b", Keep::Mean)];

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

fn near(found: f32, expected: f32) -> bool {
    (found - expected).abs() <= 2e-5 * expected.abs()
}

#[test]
fn what_was_flushed_is_read_at_every_step_before_coarse_blocks_are_complete() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("history.db");
    let mut store = Store::open(&path, &COLUMNS).expect("open");
    fill(&mut store, 1, 0..7300);
    fill(&mut store, 2, 0..10);
    let flushed = store.flush(false).expect("flush");
    println!("{} blocks, {} bytes for 7300 s", flushed.blocks, flushed.bytes);
    for everything in [false, true] {
        if everything {
            store.flush(true).expect("flush");
        }
        let seconds = means(&path, 100..160, 1);
        assert_eq!(seconds.len(), 60);
        assert!(near(seconds[0].1, 100.2) && seconds[0].2 == 100.0 && seconds[0].4 == 5, "{:?}", seconds[0]);
        let tens = means(&path, 100..160, 10);
        assert_eq!(tens.len(), 6);
        assert!(near(tens[0].1, 104.7) && tens[0].2 == 100.0 && near(tens[0].3, 109.4));
        let minutes = means(&path, 0..7300, 60);
        assert_eq!(minutes.len(), 122);
        assert!(
            near(minutes[2].1, 149.7) && minutes[2].2 == 120.0 && minutes[2].4 == 300,
            "{:?}",
            minutes[2]
        );
        let hours = means(&path, 0..7300, 3600);
        assert_eq!((hours.len(), hours[1].4, hours[2].4), (3, 18_000, 500), "everything: {everything}");
    }
    let reader = Reader::open(&path).expect("open");
    let other = reader.query(1, &["mu_b", "none"], START, START + 5, 1).expect("query");
    assert!(other.iter().all(|p| p.cells.iter().all(|cell| cell.mean.is_nan())));
    assert_eq!(reader.wagons().expect("wagons"), [1, 2]);
    // The first block begins at most its own length before the first figure.
    for tier in Tier::ALL {
        let from_s = reader.stored_from(tier).expect("oldest").expect("something is stored");
        assert!((START - tier.block_s() + 1..=START).contains(&from_s), "{tier:?}: {from_s}");
    }
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
fn a_clock_that_was_far_ahead_for_a_while_hides_and_deletes_nothing() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("history.db");
    let mut store = Store::open(&path, &COLUMNS).expect("open");
    fill(&mut store, 1, 0..300);
    let in_2099 = 4_090_000_000 - START;
    fill(&mut store, 1, in_2099..in_2099 + 10);
    // Before 1970 nothing is kept, and that is no error.
    store.push(1, -5, &[1.0, 1.0]).expect("ignored");
    fill(&mut store, 1, 300..320);
    store.flush(false).expect("flush");
    let gone = store.prune(&Retention::default(), None).expect("prune without a clock");
    assert_eq!(gone, 0);
    assert_eq!(means(&path, 0..320, 60).iter().map(|minute| minute.4).sum::<u32>(), 5 * 320);
    assert_eq!(means(&path, 0..320, 3600).len(), 1, "the present is seen in every tier");
    assert_eq!(means(&path, in_2099..in_2099 + 10, 1).len(), 10);
    drop(store);
    let mut store = Store::open(&path, &COLUMNS).expect("open again");
    fill(&mut store, 1, 320..330);
    store.flush(true).expect("flush");
    assert_eq!(means(&path, 0..330, 60).iter().map(|minute| minute.4).sum::<u32>(), 5 * 330);
}

#[test]
fn new_columns_join_old_blocks() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("history.db");
    let mut store = Store::open(&path, &COLUMNS).expect("open");
    fill(&mut store, 1, 0..30);
    store.flush(false).expect("flush");
    drop(store);
    let columns = [("slip", Keep::Extremes), ("mu_w", Keep::Extremes)];
    let mut store = Store::open(&path, &columns).expect("open");
    store.push(1, START + 30, &[7.0, 30.0]).expect("push");
    store.flush(false).expect("flush");
    let points =
        Reader::open(&path).expect("open").query(1, &["mu_w", "slip"], START, START + 60, 1).expect("query");
    assert_eq!(points.len(), 31);
    assert_eq!((points[30].cells[0].mean, points[30].cells[1].mean), (30.0, 7.0));
    assert!(points[3].cells[1].mean.is_nan() && near(points[3].cells[0].mean, 3.2));
}

#[test]
fn retention_drops_by_age_and_by_size() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("history.db");
    let mut store = Store::open(&path, &COLUMNS).expect("open");
    for hour in 0..8 {
        fill(&mut store, 1, hour * 3600..hour * 3600 + 3600);
        store.push_event(Event { unix_ms: (START + hour * 3600) * 1000, ..Event::default() });
        store.flush(false).expect("flush");
    }
    let kept = Retention::default();
    let limited = |tier: usize, limits: Limits| {
        let mut kept = kept;
        kept.tiers[tier] = limits;
        kept
    };
    let unlimited = u64::MAX;
    let an_hour = limited(0, Limits { age_s: 3600, size_bytes: unlimited });
    assert!(store.prune(&an_hour, Some(START + 8 * 3600)).expect("prune") >= 7 * 60 - 1);
    assert!(means(&path, 0..7 * 3600 - 60, 1).is_empty());
    assert_eq!(means(&path, 7 * 3600..8 * 3600, 1).len(), 3600);
    assert_eq!(means(&path, 0..7 * 3600, 60).len(), 420, "minutes stay");
    let old_events = Retention { event_s: 3600, ..kept };
    store.prune(&old_events, Some(START + 8 * 3600)).expect("prune");
    let events = Reader::open(&path).expect("open").events(&EventFilter::default(), 100).expect("events");
    assert_eq!(events.len(), 1);

    // The last hour's minutes are on the medium from here on, whatever becomes of its seconds.
    store.flush(true).expect("flush");
    let small = 4000;
    let gone = store.prune(&limited(0, Limits { age_s: i64::MAX / 4, size_bytes: small }), None);
    println!("{} blocks of seconds went by size", gone.expect("prune"));
    let rest = means(&path, 0..8 * 3600, 1);
    assert!(!rest.is_empty() && rest.len() < 3600, "{}", rest.len());
    assert_eq!(rest.last().expect("one").0, 8 * 3600 - 1, "the newest stay");
    assert_eq!(means(&path, 0..8 * 3600, 60).len(), 480, "minutes stay");
    let before = store.size_bytes().expect("size");
    store.prune(&limited(1, Limits { age_s: i64::MAX / 4, size_bytes: 1 }), None).expect("prune");
    assert!(store.size_bytes().expect("size") <= before);
    assert!(means(&path, 0..6 * 3600, 60).is_empty());
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
fn one_writer_at_a_time() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("history.db");
    let store = Store::open(&path, &COLUMNS).expect("open");
    assert!(matches!(Store::open(&path, &COLUMNS), Err(HistoryError::Taken { .. })));
    drop(store);
    assert!(Store::open(&path, &COLUMNS).is_ok());
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
    store.push_event(Event { text: "kept too".into(), ..Event::default() });
    let error = store.flush(false).expect_err("there is no room");
    assert!(error.is_storage(), "{error}");
    store.limit_pages(1_000_000).expect("limit");
    store.flush(true).expect("room again");
    assert_eq!(means(&path, 0..12_000, 1).len(), 12_000);
    assert_eq!(store.dropped_blocks(), 0);
    let events = Reader::open(&path).expect("open").events(&EventFilter::default(), 100).expect("events");
    assert_eq!(events[0].event.text, "kept too");
}

#[test]
fn events_come_page_by_page_newest_first() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("history.db");
    let mut store = Store::open(&path, &COLUMNS).expect("open");
    for number in 0..25_u32 {
        store.push_event(Event {
            unix_ms: START * 1000 + i64::from(number),
            kind: if number % 2 == 0 { "even" } else { "odd" }.into(),
            wagon: Some(number % 3),
            grade: Some("act".into()),
            text: format!("event {number}"),
            ..Event::default()
        });
    }
    assert_eq!(store.flush(false).expect("flush").events, 25);
    let reader = Reader::open(&path).expect("open");
    let mut filter = EventFilter { kind: Some("even".into()), ..EventFilter::default() };
    let mut all = Vec::new();
    loop {
        let page = reader.events(&filter, 5).expect("page");
        filter.before_id = page.last().map(|last| last.id);
        all.extend(page.iter().map(|event| event.event.unix_ms - START * 1000));
        if page.len() < 5 {
            break;
        }
    }
    assert_eq!(all, (0..=12).rev().map(|half| 2 * half).collect::<Vec<i64>>());
    let some = EventFilter { wagon: Some(1), from_ms: Some(START * 1000 + 10), ..EventFilter::default() };
    assert_eq!(reader.events(&some, 100).expect("events").len(), 5);
}

#[test]
fn a_database_of_version_1_is_migrated_and_continued() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("history.db");
    let first = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/version-1.db");
    std::fs::copy(first, &path).expect("copy");
    let mut store = Store::open(&path, &COLUMNS).expect("open");
    // It holds 90 s of five samples a second: mu_w is the second and tenths, as `fill` makes them.
    let seconds = means(&path, 0..200, 1);
    assert_eq!(seconds.len(), 90);
    for (second, mean, min, max, samples) in &seconds {
        let expected = *second as f32;
        assert!(near(*mean, expected + 0.2) && near(*min, expected) && near(*max, expected + 0.4));
        assert_eq!(*samples, 5);
    }
    assert_eq!(means(&path, 0..200, 60).iter().map(|minute| minute.4).collect::<Vec<_>>(), [300, 150]);
    fill(&mut store, 1, 90..100);
    store.push_event(Event::default());
    store.flush(true).expect("flush");
    assert_eq!(means(&path, 0..200, 1).len(), 100, "an old block is continued in the new form");
    assert_eq!(means(&path, 0..200, 3600)[0].4, 500);
}

#[test]
fn a_reader_at_one_instant_does_not_see_what_comes_meanwhile() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("history.db");
    let mut store = Store::open(&path, &COLUMNS).expect("open");
    fill(&mut store, 1, 0..10);
    store.flush(false).expect("flush");
    let reader = Reader::open(&path).expect("open");
    let count =
        |reader: &Reader| reader.query(1, &["mu_w"], START, START + 100, 1).map(|points| points.len());
    let counts = reader.at_one_instant(|reader| {
        let before = count(reader)?;
        fill(&mut store, 1, 10..20);
        store.flush(false)?;
        Ok::<_, HistoryError>((before, count(reader)?))
    });
    assert_eq!(counts.expect("counts"), (10, 10));
    assert_eq!(count(&reader).expect("count"), 20);
}

#[test]
fn the_tier_follows_the_step() {
    assert_eq!(
        [1, 59, 60, 3599, 3600, 86_400].map(Reader::tier),
        [Tier::Second, Tier::Second, Tier::Minute, Tier::Minute, Tier::Hour, Tier::Hour]
    );
}

#[test]
fn columns_of_an_older_version_go_on_under_their_names_of_today() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("history.db");
    let mut store = Store::open(&path, &[("speed", Keep::Extremes), ("slip", Keep::Mean)]).expect("open");
    (0..120).for_each(|t| store.push(1, START + t, &[20.0, 0.1]).expect("push"));
    store.flush(true).expect("flush");
    drop(store);
    let former = [FormerName { then: "speed".to_owned(), now: "v_m_s".to_owned() }];
    let mean = |from_s: i64, former: &[FormerName]| {
        let reader = Reader::open(&path).expect("open").with_names(former);
        reader.query(1, &["v_m_s"], from_s, from_s + 60, 60).expect("query")[0].cells[0].mean
    };
    assert!(mean(START, &[]).is_nan(), "nobody told the reader");
    assert_eq!(mean(START, &former), 20.0, "as it was written, on a medium that nobody may write");
    let columns = [("v_m_s", Keep::Extremes), ("slip", Keep::Mean)];
    let mut store = Store::open_renamed(&path, &columns, &former).expect("open again");
    (120..240).for_each(|t| store.push(1, START + t, &[30.0, 0.1]).expect("push"));
    store.flush(true).expect("flush");
    drop(store);
    assert_eq!((mean(START, &[]), mean(START + 180, &[])), (20.0, 30.0), "one column goes on");
    assert_eq!(Reader::open(&path).expect("open").columns().expect("columns"), ["v_m_s", "slip"]);
}
