//! Bad input gets an error that names file, place, column and what is allowed; no input makes a reader panic.

use proptest::prelude::*;
use railgrip_recording::{Problem, Recording, RecordingError, Strictness, Table};
use std::path::Path;

const HEADER: &str =
    "t_s,v_m_s,omega_f_rad_s,omega_r_rad_s,f_perp_f_n,f_perp_r_n,m_w_f_nm,m_w_r_nm,grade_rad";

/// 150 good rows, each changed by `edit` (row number from 0, cells).
fn text(header: &str, edit: impl Fn(usize, &mut Vec<String>)) -> String {
    let mut text = format!("{header}\n");
    for row in 0..150 {
        let time = format!("{:.2}", row as f64 / 100.0);
        let mut cells: Vec<String> = vec![time];
        cells.extend(["20.0", "45.0", "45.1", "1000", "1010", "0", "0", "0.001"].map(str::to_owned));
        edit(row, &mut cells);
        text.push_str(&cells.join(","));
        text.push('\n');
    }
    text
}

fn read(text: &str, strictness: Strictness) -> Result<Recording, RecordingError> {
    Recording::read_csv(text.as_bytes(), Path::new("runs/stop.dry.csv"), strictness)
}

fn set(row: usize, column: usize, value: &'static str) -> impl Fn(usize, &mut Vec<String>) {
    move |at, cells| {
        if at == row {
            cells[column] = value.to_owned();
        }
    }
}

/// Strict and tolerant outcome of a text: `None` = accepted, else the words that its error must hold.
fn expect(text: &str, strict: &[&str], tolerant: Option<&[&str]>) {
    let holds = |error: String, words: &[&str]| {
        for word in words.iter().chain(&["runs/stop.dry.csv"]) {
            assert!(error.contains(word), "`{word}` is missing in: {error}");
        }
    };
    holds(read(text, Strictness::Strict).expect_err("strict must refuse").to_string(), strict);
    match (read(text, Strictness::Tolerant), tolerant) {
        (Ok(_), None) => {}
        (Err(error), Some(words)) => holds(error.to_string(), words),
        (Ok(_), Some(words)) => panic!("tolerant must refuse with {words:?}"),
        (Err(error), None) => panic!("tolerant must accept: {error}"),
    }
}

#[test]
fn the_good_text_is_good() {
    assert_eq!(read(&text(HEADER, |_, _| {}), Strictness::Strict).expect("good").len(), 150);
}

#[test]
fn headers() {
    let good = |_: usize, _: &mut Vec<String>| {};
    let missing = text(&HEADER.replace("omega_r_rad_s", "sanding"), good);
    expect(&missing, &["column omega_r_rad_s", "missing", "v_m_s"], Some(&["column omega_r_rad_s"]));
    let unknown = text(&HEADER.replace("grade_rad", "slope"), good);
    expect(
        &unknown,
        &["column slope", "unknown", "grade_rad (optional)"],
        Some(&["column slope", "unknown"]),
    );
    let twice = text(&HEADER.replace("m_w_r_nm", "m_w_f_nm"), good);
    expect(&twice, &["column m_w_f_nm", "twice"], Some(&["twice"]));
    expect("", &["empty", "columns"], Some(&["empty"]));
    expect(&format!("{HEADER}\n"), &["empty run"], Some(&["empty run"]));
    let spaces = text(HEADER, good).replace(',', " ");
    expect(&spaces, &["line 1", "unknown column"], Some(&["line 1"]));
    let half_wsp = text(&HEADER.replace("grade_rad", "wsp_f"), good);
    expect(&half_wsp, &["column wsp_r", "missing"], Some(&["column wsp_r"]));
}

#[test]
fn cells() {
    let tolerated = ["", "NaN", "nan", "inf", "-inf", "1e999"];
    for value in tolerated {
        expect(&text(HEADER, set(10, 1, value)), &["line 12", "column v_m_s", "finite"], None);
    }
    for value in ["abc", "1,5", "0x10", "12 km/h", "--3"] {
        let text = text(HEADER, set(3, 2, value));
        let words: &[&str] = if value.contains(',') {
            &["line 5", "10 cells", "9 columns"]
        } else {
            &["line 5", "column omega_f_rad_s", "not a number"]
        };
        expect(&text, words, Some(words));
    }
    let again = text(HEADER, |row, cells| {
        if row == 70 {
            *cells = HEADER.split(',').map(str::to_owned).collect();
        }
    });
    expect(&again, &["line 72", "header stands again"], Some(&["line 72"]));
    let short = text(HEADER, |row, cells| cells.truncate(if row == 149 { 4 } else { 9 }));
    expect(&short, &["line 151", "4 cells", "9 columns"], Some(&["line 151"]));
    let mut bytes = text(HEADER, |_, _| {}).into_bytes();
    let at = bytes.len() - 4;
    bytes[at] = 0xff;
    let error =
        Recording::read_csv(bytes.as_slice(), Path::new("a.csv"), Strictness::Tolerant).expect_err("no text");
    assert!(error.to_string().contains("line 151") && error.to_string().contains("UTF-8"), "{error}");
}

#[test]
fn nonsense_values() {
    for (column, value, name) in [
        (4, "-30000", "f_perp_f_n"),
        (2, "45000", "omega_f_rad_s"),
        (1, "900", "v_m_s"),
        (8, "12.5", "grade_rad"),
        (6, "-2e7", "m_w_f_nm"),
    ] {
        expect(&text(HEADER, set(20, column, value)), &["line 22", name, "out of range", "allowed"], None);
    }
    assert!(
        read(&text(HEADER, set(20, 4, "-400")), Strictness::Strict).is_ok(),
        "noise around zero force is no error"
    );
}

#[test]
fn times() {
    expect(&text(HEADER, set(50, 0, "0.49")), &["line 52", "column t_s", "increase"], None);
    expect(&text(HEADER, set(50, 0, "0.2")), &["line 52", "t_s", "increase"], None);
    expect(&text(HEADER, set(50, 0, "0.503")), &["line 52", "t_s", "0.013", "0.010", "5 %"], None);
    expect(&text(HEADER, set(50, 0, "")), &["line 52", "t_s", "finite"], Some(&["line 52", "t_s"]));
    let gap = text(HEADER, |row, cells| {
        if row >= 90 {
            cells[0] = format!("{:.2}", row as f64 / 100.0 + 0.01);
        }
    });
    expect(&gap, &["line 92", "t_s", "0.020"], None);
    let brief: String = text(HEADER, |_, _| {}).lines().take(60).map(|line| format!("{line}\n")).collect();
    expect(&brief, &["lasts 0.58", "at least 1 s"], None);
    let single: String = text(HEADER, |_, _| {}).lines().take(2).map(|line| format!("{line}\n")).collect();
    expect(&single, &["lasts 0.000"], None);
}

#[test]
fn another_rate_is_named() {
    let run = read(&text(HEADER, |_, _| {}), Strictness::Strict).expect("good");
    let error = run.require_rate(Path::new("stop.dry.csv"), 50.0).expect_err("rate").to_string();
    assert!(error.contains("100.000 Hz") && error.contains("50 Hz"), "{error}");
}

#[test]
fn files_that_are_none() {
    let folder = tempfile::tempdir().expect("folder");
    let absent = Recording::read(&folder.path().join("x.dry.csv"), Strictness::Strict).expect_err("absent");
    assert!(matches!(absent.problem, Problem::Io(_)) && absent.to_string().contains("x.dry.csv"));
    let ending = Recording::read(&folder.path().join("x.dry.xlsx"), Strictness::Strict).expect_err("ending");
    assert!(ending.to_string().contains(".csv or .parquet"));
    let path = folder.path().join("x.dry.parquet");
    std::fs::write(&path, "PAR1 this is no parquet PAR1").expect("write");
    let broken = Recording::read(&path, Strictness::Strict).expect_err("broken");
    assert!(matches!(broken.problem, Problem::Parquet(_)), "{broken}");
}

/// Bytes of a small good Parquet file.
fn parquet() -> Vec<u8> {
    std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/pandas.parquet")).expect("fixture")
}

fn config(cases: u32) -> ProptestConfig {
    let rng_seed = proptest::test_runner::RngSeed::Fixed(11);
    ProptestConfig { cases, rng_seed, failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(config(400))]

    #[test]
    fn no_text_makes_the_reader_panic(text in "(t_s|v_m_s|,|\\n|\"|[0-9.eE+-]{1,6}|omega_[fr1-9]_rad_s|NaN|\\PC){0,60}") {
        for strictness in [Strictness::Strict, Strictness::Tolerant] {
            read(&text, strictness).ok();
        }
    }

    #[test]
    fn no_bytes_make_the_reader_panic(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        Table::read_csv(bytes.as_slice(), Path::new("x.csv"), &|_| Ok(())).ok();
    }

    #[test]
    fn no_damage_to_a_good_text_makes_the_reader_panic(at in 0usize..6000, byte in any::<u8>(), cut in 0usize..8000) {
        let mut bytes = text(HEADER, |_, _| {}).into_bytes();
        let last = bytes.len() - 1;
        bytes[at.min(last)] = byte;
        bytes.truncate(cut.max(1));
        for strictness in [Strictness::Strict, Strictness::Tolerant] {
            Recording::read_csv(bytes.as_slice(), Path::new("x.dry.csv"), strictness).ok();
        }
    }

    #[test]
    fn no_damage_to_a_parquet_file_makes_the_reader_panic(hits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)) {
        let mut bytes = parquet();
        for (index, byte) in hits {
            let at = index.index(bytes.len());
            bytes[at] = byte;
        }
        Table::read_parquet(bytes, Path::new("x.parquet"), &|_| Ok(())).ok();
    }
}

#[test]
fn what_is_no_number_in_a_parquet_file_is_named() {
    for (file, column, kind) in [("text.parquet", "name", "text"), ("date.parquet", "day", "dates")] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(file);
        let said = Table::read(&path).expect_err(file).to_string();
        assert!(said.contains(&format!("column {column}: holds {kind}")), "{said}");
    }
}

/// A run of two wheelsets at 100 Hz whose times are changed.
fn timed(change: impl Fn(usize) -> f64) -> String {
    let rows = (0..400).map(|k| format!("{:?},20,45,45,0,0\n", change(k)));
    let header = "t_s,v_m_s,omega_f_rad_s,omega_r_rad_s,f_perp_f_n,f_perp_r_n\n".to_owned();
    std::iter::once(header).chain(rows).collect()
}

#[test]
fn a_tolerant_reader_takes_late_rows_and_refuses_a_shuffled_run_or_another_unit_of_time() {
    let read = |text: String| {
        Recording::read_csv(text.as_bytes(), Path::new("run.csv"), Strictness::Tolerant)
            .map_err(|e| e.to_string())
    };
    let late = timed(|k| 0.01 * if k % 50 == 7 { k as f64 - 2.5 } else { k as f64 });
    assert_eq!(read(late).map(|run| run.len()), Ok(400));
    let shuffled = timed(|k| 0.01 * ((k * 173) % 400) as f64);
    let said = read(shuffled).expect_err("no order");
    assert!(said.contains("column t_s") && said.contains("not in the order"), "{said}");
    let said = read(timed(|_| 3.0)).expect_err("stands");
    assert!(said.contains("column t_s: the time is 3 s in every row"), "{said}");
    for unit in [1e3, 1e6] {
        let said = read(timed(|k| 0.01 * unit * k as f64)).expect_err("ms");
        assert!(said.contains("not ms or µs"), "{said}");
    }
}
