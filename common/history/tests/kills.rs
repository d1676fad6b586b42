//! A writer that is killed again and again, at any moment: every record that it acknowledged as written is there, unchanged.
//!
//! 12 kills by default; `RAILGRIP_KILLS=200 cargo test --release -p railgrip-history --test kills -- --nocapture` does 200.
#![allow(clippy::print_stdout, reason = "tests print what they measure, and the child tells its parent")]

use railgrip_history::{Event, EventFilter, Keep, Reader, Store};
use railgrip_requirements::{Test, run};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, ExitCode, Stdio};
use std::sync::mpsc::channel;
use std::time::Duration;

const START_S: i64 = 1_700_000_000 / 86_400 * 86_400;
const COLUMNS: [(&str, Keep); 3] = [("a", Keep::Extremes), ("b", Keep::Extremes), ("c", Keep::Mean)];
const WAGONS: u32 = 4;
/// Says to a process of this program that it is the writer of this database.
const DATABASE: &str = "RAILGRIP_TEST_DATABASE";

const TESTS: &[Test] =
    &[("nothing_acknowledged_is_lost_over_many_kills", &[], nothing_acknowledged_is_lost_over_many_kills)];

fn main() -> ExitCode {
    let Some(database) = std::env::var_os(DATABASE) else { return run(TESTS, None) };
    let from = std::env::args().nth(1).and_then(|text| text.parse().ok());
    write_for_ever(Path::new(&database), from.expect("the second to begin with"));
}

/// What wagon `wagon` says at a second.
fn values(wagon: u32, second: i64) -> [f32; 3] {
    [second as f32, ((second * 7919 + i64::from(wagon) * 104_729) % 1000) as f32, wagon as f32]
}

/// The child: writes seconds from a given one on, and says after each flush up to where everything is written.
fn write_for_ever(database: &Path, mut second: i64) -> ! {
    let mut store = Store::open(database, &COLUMNS).expect("open");
    println!("opened");
    loop {
        for _ in 0..5 {
            for wagon in 1..=WAGONS {
                store.push(wagon, START_S + second, &values(wagon, second)).expect("push");
            }
            second += 1;
        }
        store.push_event(Event { unix_ms: second, kind: "mark".into(), ..Event::default() });
        store.flush(false).expect("flush");
        println!("written {second}");
    }
}

/// Runs the child until it is killed, `after` its start or after its first acknowledgement; says up to where it had
/// acknowledged.
fn killed(database: &Path, from: i64, at_work: bool, after: Duration) -> i64 {
    let mut child = Command::new(std::env::current_exe().expect("this program"))
        .arg(from.to_string())
        .env(DATABASE, database)
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .expect("start the writer");
    let output = BufReader::new(child.stdout.take().expect("its output"));
    let (sender, told) = channel();
    let reading = std::thread::spawn(move || {
        let lines = output.lines().map_while(Result::ok);
        let numbers = lines.filter_map(|line| line.rsplit_once("written ")?.1.parse::<i64>().ok());
        numbers.for_each(|number| sender.send(number).expect("the parent listens"));
    });
    let first = at_work.then(|| told.recv_timeout(Duration::from_secs(60)).expect("the writer writes"));
    std::thread::sleep(after);
    child.kill().expect("kill");
    child.wait().expect("wait");
    reading.join().expect("reader");
    told.try_iter().last().or(first).unwrap_or(from)
}

fn nothing_acknowledged_is_lost_over_many_kills() {
    let kills: u64 = std::env::var("RAILGRIP_KILLS").ok().and_then(|text| text.parse().ok()).unwrap_or(12);
    let folder = tempfile::tempdir().expect("folder");
    let database = folder.path().join("history.db");
    let (mut written, mut random, mut beyond) = (0, 0x9e37_79b9_u64, 0);
    for kill in 0..kills {
        // xorshift: the moments are the same in every run, what the writer does then is not.
        random ^= random << 13;
        random ^= random >> 7;
        random ^= random << 17;
        // Two thirds while it works, one third while it starts.
        let (at_work, after) = (kill % 3 != 0, Duration::from_micros(random % 100_000));
        written = killed(&database, written, at_work, after);
        if !database.exists() {
            continue;
        }
        // Opening is what repairs; it is what the next writer would do.
        let store = Store::open(&database, &COLUMNS).expect("open after the kill");
        assert_eq!(store.set_aside(), None, "kill {kill}: taken for damaged");
        drop(store);
        let reader = Reader::open(&database).expect("reader");
        for wagon in 1..=WAGONS {
            let points =
                reader.query(wagon, &["a", "b", "c"], START_S, START_S + 10_000_000, 1).expect("query");
            for (second, point) in points.iter().enumerate() {
                let expected = values(wagon, second as i64);
                let found = [point.cells[0].mean, point.cells[1].max, point.cells[2].mean];
                assert_eq!(point.unix_s, START_S + second as i64, "kill {kill}: a gap");
                assert_eq!(found, expected, "kill {kill}, wagon {wagon}, second {second}");
            }
            assert!(
                points.len() as i64 >= written,
                "kill {kill}, wagon {wagon}: {} of {written} s",
                points.len()
            );
            beyond = beyond.max(points.len() as i64 - written);
            // What was written but not yet acknowledged may be there: the next writer goes on behind it.
            if wagon == WAGONS {
                written = points.len() as i64;
            }
        }
        let marks = reader.events(&EventFilter::default(), 1_000_000).expect("events");
        assert_eq!(marks.len() as i64 * 5, written, "kill {kill}: events go with the seconds around them");
    }
    println!(
        "{kills} kills, {written} s of {WAGONS} wagons acknowledged: none lost; at most {beyond} s more than acknowledged"
    );
    assert!(written > 0);
}
