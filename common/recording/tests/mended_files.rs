//! Recordings as they are: what is mended, what is said about it, what is refused.
#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "tests print what they measure and should fail where they can"
)]

use railgrip_recording::{Mended, Mending, RailClass, Recording, RecordingError, Renamed, prepare};
use std::f64::consts::TAU;

const HEADER: &str = "t_s,v_m_s,omega_f_rad_s,omega_r_rad_s,f_perp_f_n,f_perp_r_n";
const PERIOD_S: f64 = 0.02;

/// Vehicle speed, m/s: slow waves on a long brake.
fn speed(t_s: f64) -> f64 {
    40.0 - 0.5 * t_s + 0.2 * (TAU * t_s / 4.0).sin()
}

/// Pressing force, N.
fn force(t_s: f64) -> f64 {
    2e4 + 5e3 * (TAU * t_s / 3.0).sin()
}

/// A row of a regular run, taken at `t_s`, as cells.
fn row(t_s: f64) -> Vec<String> {
    let v = speed(t_s);
    [t_s, v, v / 0.45, v / 0.45, force(t_s), 0.9 * force(t_s)].map(|cell| format!("{cell:?}")).to_vec()
}

/// Twelve seconds at 50 Hz; `change` may alter a row or take it away.
fn mend_as(
    header: &str,
    mending: &Mending,
    change: impl Fn(usize, f64) -> Option<Vec<String>>,
) -> Result<Mended, RecordingError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stop.dry.csv");
    let rows = (0..600).filter_map(|k| change(k, PERIOD_S * k as f64));
    let text: String = rows.map(|cells| cells.join(",") + "\n").collect();
    std::fs::write(&path, format!("{header}\n{text}")).unwrap();
    let mended = Recording::read_mended(&path, mending);
    match &mended {
        Ok(mended) => mended.notes.iter().for_each(|note| println!("{note}")),
        Err(error) => println!("{error}"),
    }
    mended
}

fn mend(change: impl Fn(usize, f64) -> Option<Vec<String>>) -> Result<Mended, RecordingError> {
    mend_as(HEADER, &Mending::default(), change)
}

/// A row with some cells emptied.
fn without(t_s: f64, columns: &[usize]) -> Vec<String> {
    let mut cells = row(t_s);
    columns.iter().for_each(|column| cells[*column].clear());
    cells
}

fn says(mended: &Mended, words: &[&str]) {
    let said = mended.notes.join("\n");
    words.iter().for_each(|word| assert!(said.contains(word), "no {word:?} in: {said}"));
}

#[test]
fn a_regular_run_stays_as_it_is() {
    let mended = mend(|_, t_s| Some(row(t_s))).unwrap();
    assert_eq!(mended.parts.len(), 1);
    let part = &mended.parts[0];
    assert_eq!((part.name.as_str(), part.len()), ("stop.dry", 600));
    assert!((0..600).all(|k| part.t_s[k] == PERIOD_S * k as f64 && part.v_m_s[k] == speed(part.t_s[k])));
    says(&mended, &["taken as a trailer", "level track"]);
    assert_eq!(mended.notes.len(), 2);
}

#[test]
fn jitter_is_taken_out_without_smoothing() {
    let late = |k: usize| 0.15 * PERIOD_S * (k as f64 * 2.399).sin();
    let mended = mend(|k, t_s| Some(row(t_s + late(k)))).unwrap();
    let part = &mended.parts[0];
    assert_eq!(part.len(), 600);
    let worst = |value: &dyn Fn(usize) -> f64| (1..599).map(|k| value(k).abs()).fold(0.0, f64::max);
    let uneven = worst(&|k| part.t_s[k + 1] - part.t_s[k] - PERIOD_S);
    let off = worst(&|k| part.v_m_s[k] - speed(part.t_s[k]));
    println!("steps differ by {uneven:.1e} s, speeds by {off:.1e} m/s");
    assert!(uneven < 2e-5 && off < 1e-4);
    says(&mended, &["jitter by up to 1", "50.0"]);
    let error =
        mend(|k, t_s| Some(row(t_s + if k == 40 { 0.3 * PERIOD_S } else { 0.0 }))).unwrap_err().to_string();
    assert!(error.contains("line 42, column t_s") && error.contains("20 %"), "{error}");
}

#[test]
fn a_missing_row_leaves_a_hole_in_outputs_and_none_in_inputs() {
    let mended = mend(|k, t_s| (k != 100).then(|| row(t_s))).unwrap();
    let part = &mended.parts[0];
    assert_eq!((mended.parts.len(), part.len()), (1, 600));
    assert!(part.v_m_s[100].is_nan() && part.wheel_speed_rad_s[1][100].is_nan());
    assert_eq!(part.v_m_s.iter().filter(|v| v.is_nan()).count(), 1);
    assert!((part.pressing_force_n[0][100] - force(2.0)).abs() < 5.0);
    says(&mended, &["1 row is missing", "line 101"]);
}

#[test]
fn empty_cells_are_gaps_and_long_ones_of_inputs_cut_the_run() {
    // A speed that is missing for a second, a force for 0.2 s and later for 0.8 s.
    let mended = mend(|k, t_s| {
        Some(match k {
            50..100 => without(t_s, &[1]),
            200..210 => without(t_s, &[4]),
            300..340 => without(t_s, &[5]),
            _ => row(t_s),
        })
    })
    .unwrap();
    let lengths: Vec<usize> = mended.parts.iter().map(Recording::len).collect();
    assert_eq!(lengths, [300, 260]);
    let first = &mended.parts[0];
    assert!(first.v_m_s[50..100].iter().all(|v| v.is_nan()) && first.v_m_s[100].is_finite());
    assert!((first.pressing_force_n[0][205] - force(4.1)).abs() < 200.0);
    assert!((mended.parts[1].t_s[0] - 6.8).abs() < 1e-9);
    says(
        &mended,
        &["50 cells are empty in v_m_s, the first in line 52", "f_perp_r_n is not known from 6.00 s"],
    );
}

#[test]
fn a_pause_cuts_the_run_and_a_snippet_is_left_out() {
    let mended =
        mend(|k, t_s| (!(100..180).contains(&k) && !(200..240).contains(&k)).then(|| row(t_s))).unwrap();
    let lengths: Vec<usize> = mended.parts.iter().map(Recording::len).collect();
    assert_eq!(lengths, [100, 360]);
    says(&mended, &["no row for 1.62 s before line 102", "less than a second"]);
}

#[test]
fn columns_of_their_own_are_left_out_and_said_whatever_they_hold() {
    let header = format!("{HEADER},door,m_w_f_nm,m_w_r_nm");
    let change = |_, t_s| {
        let mut cells = row(t_s);
        cells.extend(["shut".to_owned(), String::new(), "0.0".to_owned()]);
        Some(cells)
    };
    let mended = mend_as(&header, &Mending::default(), change).unwrap();
    says(&mended, &["left out, as no column of a run: door", "every cell of m_w_f_nm is empty"]);
    assert!(mended.parts[0].drive_torque_nm.iter().flatten().all(|torque| *torque == 0.0));
}

#[test]
fn other_names_units_and_rates_are_taken_when_told() {
    let header = HEADER.replace("v_m_s", "speed_kmh");
    let mending = Mending {
        renamed: vec![Renamed { from: "speed_kmh".into(), factor: 1.0 / 3.6, to: "v_m_s".into() }],
        dropped: Vec::new(),
        rate_hz: Some(25.0),
    };
    let change = |_, t_s| {
        let mut cells = row(t_s);
        cells[1] = format!("{:?}", 3.6 * speed(t_s));
        Some(cells)
    };
    let mended = mend_as(&header, &mending, change).unwrap();
    let part = &mended.parts[0];
    assert_eq!(part.len(), 300);
    assert!((part.sample_rate_hz() - 25.0).abs() < 1e-6 && (part.v_m_s[7] - speed(part.t_s[7])).abs() < 1e-9);
    says(&mended, &["speed_kmh times 0.277", "one row in 2 is kept, at 25.00 Hz"]);
    let faster = Mending { rate_hz: Some(100.0), ..Mending::default() };
    let error = mend_as(HEADER, &faster, |_, t_s| Some(row(t_s))).unwrap_err().to_string();
    assert!(error.contains("100 Hz were asked for") && error.contains("20 Hz to the 50.00 Hz"), "{error}");
}

#[test]
fn what_cannot_be_mended_is_refused_with_its_place() {
    let holds = |result: Result<Mended, RecordingError>, words: &[&str]| {
        let said = result.unwrap_err().to_string();
        words.iter().for_each(|word| assert!(said.contains(word), "no {word:?} in: {said}"));
    };
    let cell = |line: usize, column: usize, text: &'static str| {
        move |k: usize, t_s: f64| {
            let mut cells = row(t_s);
            if k + 2 == line {
                cells[column] = text.to_owned();
            }
            Some(cells)
        }
    };
    holds(mend(cell(40, 1, "NaN")), &["line 40, column v_m_s", "leave the cell empty"]);
    holds(mend(cell(41, 4, "9e9")), &["line 41, column f_perp_f_n", "out of range"]);
    holds(mend(cell(42, 0, "")), &["line 42, column t_s"]);
    holds(mend(cell(43, 0, "0.1")), &["line 43, column t_s", "must increase"]);
    holds(mend(|_, t_s| Some(without(t_s, &[2]))), &["column omega_f_rad_s", "every cell is empty"]);
    holds(mend(|k, t_s| (k < 20).then(|| row(t_s))), &["0.380 s"]);
    holds(mend(|_, t_s| Some(row(10.0 * t_s))), &["5.000 Hz", "20 to 200 Hz"]);
    let misspelt = HEADER.replace("omega_f", "omega_x");
    holds(
        mend_as(&misspelt, &Mending::default(), |_, t_s| Some(row(t_s))),
        &["line 1, column omega_f_rad_s", "missing", "omega_x_rad_s"],
    );
}

#[test]
fn prepared_files_are_those_of_a_case_and_need_no_more_mending() {
    let folder = tempfile::tempdir().unwrap();
    let (raw, made) = (folder.path().join("raw"), folder.path().join("fit"));
    std::fs::create_dir(&raw).unwrap();
    for (name, pause) in [("stop.wet.csv", 0..0), ("trip.csv", 200..260)] {
        let kept = (0..600).filter(|k| !pause.contains(k));
        let rows: String = kept.map(|k| row(PERIOD_S * k as f64).join(",") + ",x\n").collect();
        std::fs::write(raw.join(name), format!("{HEADER},door\n{rows}")).unwrap();
    }
    let prepared = prepare(&raw, &made, &Mending::default(), Some(RailClass::Dry)).unwrap();
    let names: Vec<String> = prepared
        .iter()
        .flat_map(|one| &one.runs)
        .map(|(path, _, _)| path.file_name().unwrap().to_string_lossy().into_owned())
        .collect();
    assert_eq!(names, ["stop.wet.csv", "trip_1.dry.csv", "trip_2.dry.csv"]);
    assert!(prepared[1].notes.iter().any(|note| note.contains("door")));
    for (path, rows, rate_hz) in prepared.iter().flat_map(|one| &one.runs) {
        let again = Recording::read_mended(path, &Mending::default()).unwrap();
        assert_eq!((again.parts.len(), again.parts[0].len()), (1, *rows));
        assert!((rate_hz - 50.0).abs() < 1e-6);
        Recording::read(path, railgrip_recording::Strictness::Strict).unwrap();
    }
    let error = prepare(&raw, &made, &Mending::default(), None).unwrap_err().to_string();
    assert!(error.contains("stop.wet.csv") && error.contains("name another folder"), "{error}");
}

/// Half a folder once was written before a bad recording was met.
#[test]
fn a_bad_recording_of_a_folder_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let (raw, made) = (folder.path().join("raw"), folder.path().join("fit"));
    std::fs::create_dir(&raw).unwrap();
    let rows: String = (0..600).map(|k| row(PERIOD_S * k as f64).join(",") + "\n").collect();
    std::fs::write(raw.join("a.dry.csv"), format!("{HEADER}\n{rows}")).unwrap();
    std::fs::write(raw.join("b.dry.csv"), "").unwrap();
    let error = prepare(&raw, &made, &Mending::default(), None).unwrap_err().to_string();
    assert!(error.contains("b.dry.csv"), "{error}");
    assert!(!made.exists(), "something was written");
}

#[test]
fn a_rate_or_column_that_is_none_is_refused_as_such() {
    let with = |mending: Mending| mend_as(HEADER, &mending, |_, t_s| Some(row(t_s)));
    for rate_hz in [f64::NAN, f64::INFINITY, 0.0, 7.0, 60.0] {
        let wanted = Mending { rate_hz: Some(rate_hz), ..Mending::default() };
        let said = with(wanted).unwrap_err().to_string();
        assert!(said.contains("were asked for") && said.contains("20 Hz to the 50.00 Hz"), "{said}");
    }
    let dropped = Mending { dropped: vec!["door".into()], ..Mending::default() };
    let said = with(dropped).unwrap_err().to_string();
    assert!(said.contains("column door: no such column") && said.contains("v_m_s"), "{said}");
}
