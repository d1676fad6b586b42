//! A disk that is full, and one that becomes read-only: history pauses and says so, what was written stays readable, and it
//! goes on when there is room again. On real file systems of a kernel, small ones in memory.
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use railgrip_history::{Keep, Reader, Store};
use railgrip_requirements::{PRIVATE_MOUNT, Test, run};
use std::path::Path;
use std::process::{Command, ExitCode};

const START_S: i64 = 1_700_000_000 / 86_400 * 86_400;
const COLUMNS: [(&str, Keep); 2] = [("a", Keep::Extremes), ("b", Keep::Extremes)];
/// Says to a process of this program that it is alone in a world in which this folder is a file system of 2 MB.
const FOLDER: &str = "RAILGRIP_TEST_FOLDER";

const TESTS: &[Test] = &[
    ("a_full_disk_pauses_the_history", &[&PRIVATE_MOUNT], || on_small_disk("full")),
    ("a_disk_that_becomes_read_only_pauses_the_history", &[&PRIVATE_MOUNT], || on_small_disk("read-only")),
];

fn main() -> ExitCode {
    let Some(folder) = std::env::var_os(FOLDER) else { return run(TESTS, None) };
    println!("{MOUNTED}");
    match std::env::args().nth(1).as_deref() {
        Some("full") => full_disk(Path::new(&folder)),
        _ => read_only_disk(Path::new(&folder)),
    }
    ExitCode::SUCCESS
}

/// What the process says when it has its file system.
const MOUNTED: &str = "mounted";

/// Runs this program again on a small disk, to see how the history takes it that the disk is full or read-only.
fn on_small_disk(how: &str) {
    let folder = tempfile::tempdir().expect("folder");
    let program = std::env::current_exe().expect("this program");
    let script = "mount -t tmpfs -o size=2m none \"$0\" || exit 77; exec \"$1\" \"$2\"";
    for unshare in [&["-rm"][..], &["-m"][..]] {
        let output = Command::new("unshare")
            .args(unshare)
            .args(["sh", "-c", script])
            .args([folder.path(), &program, Path::new(how)])
            .env(FOLDER, folder.path())
            .output()
            .expect("unshare");
        let said = String::from_utf8_lossy(&output.stdout);
        if said.starts_with(MOUNTED) {
            println!("{said}");
            assert!(output.status.success(), "{said}\n{}", String::from_utf8_lossy(&output.stderr));
            return;
        }
    }
    panic!("no file system of its own can be mounted");
}

fn push(store: &mut Store, second: i64) {
    for wagon in 1..=8 {
        let noise = (second * 7919 + wagon * 104_729) % 997;
        store.push(wagon as u32, START_S + second, &[second as f32, noise as f32]).expect("push");
    }
}

fn seconds(database: &Path) -> i64 {
    let points = Reader::open(database).expect("reader").query(3, &["a"], START_S, START_S + 1_000_000, 1);
    points.expect("query").len() as i64
}

fn full_disk(folder: &Path) {
    let database = folder.join("history.db");
    let mut store = Store::open(&database, &COLUMNS).expect("open");
    let (mut second, mut written) = (0, 0);
    let mut write = |store: &mut Store| {
        (0..10).for_each(|offset| push(store, second + offset));
        second += 10;
        let flushed = store.flush(false);
        if flushed.is_ok() {
            written = second;
        }
        (flushed, written, second)
    };
    for _ in 0..20 {
        write(&mut store).0.expect("there is room yet");
    }
    let ballast = folder.join("ballast");
    let _ = std::fs::write(&ballast, vec![1; 4_000_000]);
    let (mut refused, mut acknowledged) = (None, 0);
    for _ in 0..60 {
        let (flushed, until, _) = write(&mut store);
        acknowledged = until;
        if let Err(error) = flushed {
            refused = Some(error);
        }
    }
    let refused = refused.expect("a full disk must refuse");
    println!("{refused}");
    assert!(refused.is_storage(), "{refused:?}");
    assert!(seconds(&database) >= acknowledged, "what was acknowledged is there");
    // Somebody frees space: the next flush catches up on everything that waited.
    std::fs::remove_file(&ballast).expect("remove");
    let (flushed, ..) = write(&mut store);
    flushed.expect("there is room again");
    assert_eq!((seconds(&database), store.dropped_blocks()), (810, 0), "nothing that waited was lost");
}

fn read_only_disk(folder: &Path) {
    let mount = |how: &str| {
        let done = Command::new("mount").args(["-o", how]).arg(folder).status();
        done.is_ok_and(|status| status.success())
    };
    let database = folder.join("history.db");
    let mut store = Store::open(&database, &COLUMNS).expect("open");
    (0..100).for_each(|second| push(&mut store, second));
    store.flush(true).expect("flush");
    drop(store);
    assert!(mount("remount,ro"), "the disk of this test becomes read-only");
    let refused = Store::open(&database, &COLUMNS).expect_err("a read-only disk must refuse a writer");
    println!("{refused}");
    assert_eq!(seconds(&database), 100, "what is there can be read");
    assert!(mount("remount,rw"));
    let mut store = Store::open(&database, &COLUMNS).expect("writable again");
    (100..110).for_each(|second| push(&mut store, second));
    store.flush(true).expect("flush");
    assert_eq!(seconds(&database), 110);
}
