//! What is written is read back; files of other programs are read.

use proptest::prelude::*;
use railgrip_recording::{
    Combine, Mapping, Optional, RailClass, Recording, Row, Rule, RunWriter, Strictness, Table, Truth,
    TruthRow, unit,
};
use std::path::Path;

/// A run of plausible values, different in every cell.
fn run(wheelsets: usize, rows: usize, optional: Optional) -> Recording {
    let mut recording = Recording::empty("run.wet", Some(RailClass::Wet), wheelsets, optional);
    for index in 0..rows {
        let x = index as f64;
        let each = |scale: f64| std::array::from_fn(|wheelset| scale * (x + 0.1 * wheelset as f64).sin());
        recording.push(&Row {
            t_s: x / 100.0,
            v_m_s: 20.0 + (0.3 * x).sin(),
            wheel_speed_rad_s: each(50.0),
            pressing_force_n: each(1e3),
            drive_torque_nm: each(7e3),
            grade_rad: 1e-3 * x.cos(),
            sanding: f64::from(index % 7 == 0),
            position_m: 0.2 * x,
            wsp_active: [f64::from(index % 3 == 0); 4],
            load_kg: 4e4 + x,
            brake_demand: 0.2 * (index % 5) as f64,
        });
    }
    recording
}

#[test]
fn both_forms_return_the_same_bits() {
    let folder = tempfile::tempdir().expect("folder");
    for (wheelsets, optional) in
        [(2, Optional::MEASURED), (2, Optional::ALL), (4, Optional::ALL), (1, Optional::ALL)]
    {
        let written = run(wheelsets, 300, optional);
        for ending in ["csv", "parquet"] {
            let path = folder.path().join(format!("run.wet.{ending}"));
            written.write(&path).expect("write");
            let read = Recording::read(&path, Strictness::Strict).expect("read");
            assert_eq!(read, written, "{wheelsets} wheelsets, {ending}");
        }
    }
    let left: Vec<_> = std::fs::read_dir(folder.path()).expect("list").collect();
    assert_eq!(left.len(), 2, "no temporary file is left: {left:?}");
}

#[test]
fn missing_cells_stay_missing_in_both_forms() {
    let folder = tempfile::tempdir().expect("folder");
    let mut written = run(2, 200, Optional::MEASURED);
    written.v_m_s[7] = f64::NAN;
    written.wheel_speed_rad_s[1][199] = f64::NAN;
    for ending in ["csv", "parquet"] {
        let path = folder.path().join(format!("run.wet.{ending}"));
        written.write(&path).expect("write");
        let error = Recording::read(&path, Strictness::Strict).expect_err("a hole").to_string();
        let place = if ending == "csv" { "line 9" } else { "row 8" };
        assert!(error.contains(place) && error.contains("column v_m_s"), "{error}");
        let read = Recording::read(&path, Strictness::Tolerant).expect("tolerant");
        assert!(read.v_m_s[7].is_nan() && read.wheel_speed_rad_s[1][199].is_nan());
        let shown = |run: &Recording| format!("{:?}", run.row(6));
        assert_eq!(shown(&read), shown(&written), "the wheel-slide protection columns are absent in both");
    }
}

#[test]
fn the_row_writer_equals_the_whole_writer_across_groups() {
    let folder = tempfile::tempdir().expect("folder");
    let written = run(2, 70_000, Optional::ALL);
    for ending in ["csv", "parquet"] {
        let path = folder.path().join(format!("run.wet.{ending}"));
        let mut writer = RunWriter::create(&path, 2, Optional::ALL).expect("create");
        for row in written.rows() {
            writer.push(&row).expect("push");
        }
        assert!(!path.exists(), "the file appears when it is finished");
        writer.finish().expect("finish");
        assert_eq!(Recording::read(&path, Strictness::Strict).expect("read"), written);
    }
    let abandoned = RunWriter::create(&folder.path().join("x.csv"), 2, Optional::ALL).expect("create");
    drop(abandoned);
    assert_eq!(std::fs::read_dir(folder.path()).expect("list").count(), 2, "an abandoned run leaves nothing");
}

#[test]
fn truth_goes_both_ways() {
    let folder = tempfile::tempdir().expect("folder");
    for wheelsets in [1, 2, 4] {
        let mut truth = Truth::empty(wheelsets);
        for index in 0..10 {
            let x = f64::from(index);
            let mu_b = [if index < 5 { f64::NAN } else { 0.3 }; 4];
            truth.push(&TruthRow { t_s: x, v_m_s: 2.0 * x, mu_w: -0.1, mu_w_wheelset: [-0.01 * x; 4], mu_b });
        }
        let path = folder.path().join(format!("{wheelsets}.csv"));
        truth.write(&path).expect("write");
        let read = Truth::read(&path).expect("read");
        assert_eq!(format!("{read:?}"), format!("{truth:?}"));
        if wheelsets == 2 {
            let text = std::fs::read_to_string(&path).expect("text");
            assert!(
                text.starts_with("t_s,v_m_s,mu_w,mu_w_f,mu_w_r,mu_b_f,mu_b_r\n0.0,0.0,-0.1,-0.0,-0.0,,\n")
            );
        }
    }
}

#[test]
fn a_file_written_by_pandas_is_read() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/pandas.parquet");
    let table = Table::read(&path).expect("read");
    assert_eq!(table.names(), ["t_s", "creepage", "force_n"], "the row index is no column");
    assert_eq!(table.column("t_s"), Some([0.0, 1.0, 2.0, 3.0].as_slice()));
    let creepage = table.column("creepage").expect("column");
    assert!(creepage[1] == 0.25 && creepage[2].is_nan());
}

#[test]
fn a_byte_order_mark_spaces_and_windows_lines_are_no_obstacle() {
    let text = "\u{feff}t_s, v_m_s ,omega_f_rad_s,omega_r_rad_s,f_perp_f_n,f_perp_r_n,m_w_f_nm,m_w_r_nm\r\n\
                0.0, 1.5 ,3,3,0,0,0,0\r\n\r\n0.01,1.5,3,3,0,0,0,0\r\n";
    let read =
        Recording::read_csv(text.as_bytes(), Path::new("pipe.csv"), Strictness::Tolerant).expect("read");
    assert_eq!((read.len(), read.v_m_s[0], read.grade_rad), (2, 1.5, None));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, rng_seed: proptest::test_runner::RngSeed::Fixed(7), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_numbers_survive_both_forms(cells in prop::collection::vec(any::<f64>(), 1..40)) {
        let finite: Vec<f64> = cells.into_iter().map(|cell| if cell.is_finite() { cell } else { f64::NAN }).collect();
        let table = Table::new(vec![("a".into(), finite.clone()), ("b".into(), finite)]).expect("table");
        let folder = tempfile::tempdir().expect("folder");
        for ending in ["csv", "parquet"] {
            let path = folder.path().join(format!("t.{ending}"));
            table.write(&path).expect("write");
            let read = Table::read(&path).expect("read");
            let bits = |table: &Table| -> Vec<u64> {
                let cells = table.column("a").unwrap_or_default().iter();
                cells.map(|cell| if cell.is_nan() { u64::MAX } else { cell.to_bits() }).collect()
            };
            prop_assert_eq!(bits(&read), bits(&table));
        }
    }
}

#[test]
fn a_trailer_of_a_train_is_read_with_numbered_wheelsets_load_and_demand() {
    let header = |count: usize| {
        let each = |before: &str, after: &str| {
            (1..=count).map(|k| format!(",{before}{k}{after}")).collect::<String>()
        };
        format!("t_s,v_m_s{}{},load_kg,brake_demand", each("omega_", "_rad_s"), each("f_perp_", "_n"))
    };
    for count in [2, 4] {
        let mut text = header(count) + "\n";
        for row in 0..120 {
            let wheels = ",45.0".repeat(count) + &",1000".repeat(count);
            text += &format!("{:.2},20.0{wheels},41000,0.3\n", f64::from(row) / 100.0);
        }
        let run =
            Recording::read_csv(text.as_bytes(), Path::new("run.csv"), Strictness::Strict).expect("good");
        assert_eq!((run.wheelsets, run.len(), run.rail), (count, 120, None));
        let row = run.row(7);
        assert_eq!((row.load_kg, row.brake_demand, row.wheel_speed_rad_s[count - 1]), (41_000.0, 0.3, 45.0));
        assert!(row.drive_torque_nm[..count].iter().all(|torque| *torque == 0.0) && row.grade_rad.is_nan());
    }
    let mixed = header(2).replace("omega_2", "omega_f") + "\n0,1,1,1,1,1,1,1\n";
    Recording::read_csv(mixed.as_bytes(), Path::new("run.csv"), Strictness::Tolerant)
        .expect_err("front twice");
}

#[test]
fn spreadsheets_of_other_countries_and_packed_files_are_the_same_run() {
    let folder = tempfile::tempdir().expect("folder");
    let written = run(2, 150, Optional::ALL);
    let plain = folder.path().join("run.wet.csv");
    written.write(&plain).expect("write");
    let text = std::fs::read_to_string(&plain).expect("text");
    let european = text.replace(',', ";").replace('.', ",");
    std::fs::write(&plain, &european).expect("write");
    assert_eq!(Recording::read(&plain, Strictness::Strict).expect("semicolons"), written);
    std::fs::write(&plain, text.replace(',', "\t")).expect("write");
    assert_eq!(Recording::read(&plain, Strictness::Strict).expect("tabs"), written);

    let packed = folder.path().join("run.wet.csv.gz");
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut packer, text.as_bytes()).expect("packed");
    std::fs::write(&packed, packer.finish().expect("packed")).expect("write");
    assert_eq!(Recording::read(&packed, Strictness::Strict).expect("gz"), written);
    assert!(written.write(&packed).is_err(), "packed files are read and never written");
}

#[test]
fn a_mapped_file_is_the_same_run_as_one_with_the_usual_names_and_units() {
    let folder = tempfile::tempdir().expect("folder");
    let written = run(2, 150, Optional::MEASURED);
    let table = |name: &str, factor: f64, cells: &[f64]| {
        (name.to_owned(), cells.iter().map(|x| x * factor).collect())
    };
    let path = folder.path().join("run.wet.parquet");
    let columns: Vec<(String, Vec<f64>)> = vec![
        table("ms", 1e3, &written.t_s),
        table("kmh", 3.6, &written.v_m_s),
        table("n1", -60.0 / std::f64::consts::TAU, &written.wheel_speed_rad_s[0]),
        table("n2", 60.0 / std::f64::consts::TAU, &written.wheel_speed_rad_s[1]),
        table("f_perp_f_n", 1.0, &written.pressing_force_n[0]),
        table("p2", 1e-5 / 0.16, &written.pressing_force_n[1]),
        table("grade_rad", 1.0, written.grade_rad.as_deref().unwrap_or_default()),
        table("something_else", 1.0, &written.t_s),
    ];
    Table::new(columns).expect("table").write(&path).expect("write");
    let rule = |to: &str, from: &str, name: &str, scale: f64| Rule {
        to: to.to_owned(),
        from: vec![from.to_owned()],
        combine: Combine::First,
        factor: unit(name).expect("known").0 * scale,
        offset: 0.0,
        flag: None,
    };
    let rules = vec![
        rule("t_s", "ms", "ms", 1.0),
        rule("v_m_s", "kmh", "km/h", 1.0),
        rule("omega_f_rad_s", "n1", "rpm", -1.0),
        rule("omega_r_rad_s", "n2", "rpm", 1.0),
        rule("f_perp_r_n", "p2", "bar", 0.16),
    ];
    let read =
        Recording::read_mapped(&path, &Mapping { rules: rules.clone() }, Strictness::Strict).expect("mapped");
    let near = |a: &[f64], b: &[f64]| {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-9 * b.abs().max(1.0))
    };
    assert!(near(&read.t_s, &written.t_s) && near(&read.v_m_s, &written.v_m_s));
    for wheelset in 0..2 {
        assert!(near(&read.wheel_speed_rad_s[wheelset], &written.wheel_speed_rad_s[wheelset]), "{wheelset}");
        assert!(near(&read.pressing_force_n[wheelset], &written.pressing_force_n[wheelset]), "{wheelset}");
    }
    assert_eq!((read.grade_rad, read.sanding), (written.grade_rad, None));
    let mut absent = rules;
    absent[0].from = vec!["seconds".to_owned()];
    let said =
        Recording::read_mapped(&path, &Mapping { rules: absent }, Strictness::Strict).expect_err("absent");
    assert!(said.to_string().contains("column seconds"), "{said}");
}

#[test]
fn an_input_of_several_rules_and_a_column_that_is_an_input_too_stay_until_the_last() {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("run.parquet");
    let column = |name: &str, factor: f64| {
        (name.to_owned(), (0..150).map(|row| 20.0 + factor * f64::from(row)).collect::<Vec<f64>>())
    };
    let names = ["t_s", "v_m_s", "p", "n"];
    let columns = names.iter().zip([0.01, 0.02, 0.03, 0.04]).map(|(name, factor)| column(name, factor));
    Table::new(columns.collect()).expect("table").write(&path).expect("write");
    let rule = |to: &str, from: &[&str]| Rule {
        to: to.to_owned(),
        from: from.iter().map(|from| (*from).to_owned()).collect(),
        combine: Combine::Sum,
        factor: 1.0,
        offset: 0.0,
        flag: None,
    };
    let rules = vec![
        rule("f_perp_f_n", &["p"]),
        rule("omega_f_rad_s", &["n"]),
        rule("omega_r_rad_s", &["v_m_s", "n"]),
        rule("f_perp_r_n", &["p"]),
    ];
    let run = Recording::read_mapped(&path, &Mapping { rules }, Strictness::Strict).expect("mapped");
    let last = run.row(149);
    assert_eq!((last.v_m_s, last.wheel_speed_rad_s[0]), (22.98, 25.96));
    assert_eq!(last.wheel_speed_rad_s[1], 22.98 + 25.96);
    assert_eq!(last.pressing_force_n[..2], [24.47; 2]);
}

fn fixture(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name)
}

#[test]
fn times_durations_and_decimals_of_other_programs_are_numbers_in_seconds_and_units() {
    let table = Table::read(&fixture("arrow_types.parquet")).expect("read");
    // 2026-03-01 12:00:00 UTC.
    let noon_s = 1_772_366_400.0;
    for name in ["at_ms", "at_us_utc", "at_ns"] {
        let cells = table.column(name).expect(name);
        for (row, seconds) in cells.iter().enumerate() {
            assert!((seconds - noon_s - 0.01 * row as f64).abs() < 3e-7, "{name}, row {row}: {seconds}");
        }
    }
    let column = |name: &str| table.column(name).expect(name).to_vec();
    assert_eq!(column("since_s"), [0.0, 3.0, 6.0, 9.0]);
    assert_eq!(column("since_ns"), [0.0, 0.01, 0.02, 0.03]);
    assert_eq!(column("day_us"), [3600.25; 4]);
    let small = column("small");
    assert!(small[1].is_nan() && [small[0], small[2], small[3]] == [-1.25, 20.5, 0.0], "{small:?}");
    let large = column("large");
    assert!(
        (large[0] / -123_456_789_012_345_678_901.5 - 1.0).abs() < 1e-15 && large[3].is_nan(),
        "{large:?}"
    );
    assert_eq!((large[1], column("counter")[0]), (1.5, 2_f64.powi(64)));
    assert!(column("plain")[1].is_nan());
    let polars = Table::read(&fixture("polars_duration.parquet")).expect("read");
    assert_eq!(polars.column("since_us").expect("column"), [0.0, 0.0025, 0.005, 0.0075]);
}
