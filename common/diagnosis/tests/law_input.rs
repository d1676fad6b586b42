//! Bad law-level cases are refused with file, line or key, and what is allowed; good ones give complete, repeatable output.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod law_cases;

use law_cases::{Layout, Simulated, brake};
use railgrip_diagnosis::law_bench::{Options, diagnose, write_predictions};
use railgrip_recording::Table;
use std::path::Path;

fn good() -> Simulated {
    brake(5, Layout::Scattered, 0.01, true, &|_, t, _| 1.0 - 9e-4 * (t - 20.0))
}

fn refused(change: impl Fn(&Path), words: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    good().write(folder.path());
    change(folder.path());
    let error = diagnose(folder.path(), &Options::default()).expect_err("bad input").to_string();
    println!("{error}");
    for word in words {
        assert!(error.contains(word), "`{word}` is not in: {error}");
    }
}

fn edit(folder: &Path, file: &str, from: &str, to: &str) {
    let path = folder.join(file);
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(text.contains(from), "{from}");
    std::fs::write(path, text.replacen(from, to, 1)).unwrap();
}

#[test]
fn a_bad_bench_file_is_named_with_line_and_key() {
    let toml = "bench.toml";
    refused(|f| edit(f, toml, "kind = \"brake\"", "kind = \"clutch\""), &["bench.toml:2", "kind", "creep"]);
    refused(|f| edit(f, toml, "schema = 1", "schema = 2"), &["bench.toml:1", "schema"]);
    refused(|f| edit(f, toml, "friction_coefficient", "friction"), &["bench.toml:4", "friction_coefficient"]);
    refused(|f| edit(f, toml, "sigma = 0.01", "sigma = -0.01"), &["bench.toml:6", "sensors.sigma"]);
    refused(|f| edit(f, toml, "[sensors]", "[sensors]\nnoise = 1"), &["bench.toml:6", "noise"]);
    refused(
        |f| edit(f, toml, "friction_coefficient = ", "friction_coefficient = -"),
        &["bench.toml:4", "0.001 to 2"],
    );
    refused(|f| std::fs::remove_file(f.join(toml)).unwrap(), &["bench.toml"]);
}

#[test]
fn bad_points_are_named_with_file_line_and_column() {
    let file = "fit/run1.csv";
    let header = "mu,speed_m_s,temperature_c,pressing_force_n";
    refused(
        |f| edit(f, file, header, "mu,speed,temperature_c,pressing_force_n"),
        &["run1.csv", "speed", "allowed"],
    );
    refused(
        |f| edit(f, file, header, "level,speed_m_s,temperature_c,pressing_force_n"),
        &["run1.csv", "level"],
    );
    refused(
        |f| std::fs::write(f.join(file), format!("{header}\n0.3,10,100,NaN\n")).unwrap(),
        &["line 2", "pressing_force_n"],
    );
    refused(
        |f| std::fs::write(f.join(file), format!("{header}\n0.3,10,100,9e3\n0.3,10,,9e3\n")).unwrap(),
        &["line 3", "temperature_c"],
    );
    refused(
        |f| std::fs::write(f.join(file), format!("{header}\n0.3,10,100,-9e3\n")).unwrap(),
        &["line 2", "0 to 1000000 N"],
    );
    refused(|f| std::fs::write(f.join(file), format!("{header}\n")).unwrap(), &["run1.csv", "empty"]);
    refused(
        |f| std::fs::write(f.join(file), "mu,speed_m_s\n0.3,10\n").unwrap(),
        &["run1.csv", "pressing_force_n"],
    );
    refused(|f| std::fs::remove_dir_all(f.join("holdout")).unwrap(), &["holdout"]);
    refused(
        |f| std::fs::write(f.join("holdout/run0.csv"), format!("{header}\n0.3,x,100,9e3\n")).unwrap(),
        &["holdout", "line 2", "speed_m_s"],
    );
}

#[test]
fn an_unknown_id_to_leave_out_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    good().write(folder.path());
    let options = Options { without: vec!["brake_fad".to_owned()], ..Options::default() };
    let error = diagnose(folder.path(), &options).expect_err("unknown id").to_string();
    assert!(error.contains("brake_fad") && error.contains("brake_fade"), "{error}");
}

#[test]
fn reported_holdout_gaps_follow_from_the_prediction_files() {
    let folder = tempfile::tempdir().unwrap();
    good().write(folder.path());
    let outcome = diagnose(folder.path(), &Options { seed: 3, ..Options::default() }).unwrap();
    let out = folder.path().join("predictions");
    write_predictions(&out, &outcome.predictions).unwrap();
    let (mut squares, mut count) = ([0.0; 3], 0);
    for name in ["run0", "run1"] {
        let table = Table::read(&out.join(format!("{name}.csv"))).unwrap();
        let measured = table.column("mu").unwrap();
        for (slot, model) in squares.iter_mut().zip(["mu_nominal", "mu_calibrated", "mu_extended"]) {
            let errors = table.column(model).unwrap().iter().zip(measured).map(|(p, m)| (p - m) / 0.01);
            *slot += errors.map(|error| error * error).sum::<f64>();
        }
        count += table.rows();
        assert!(table.column("window").unwrap().iter().all(|window| *window == 0.0));
    }
    let holdout = &outcome.report.gap.holdout;
    let reported = [holdout.nominal, holdout.calibrated, holdout.extended];
    for (sum, reported) in squares.into_iter().zip(reported) {
        let gap = (sum / count as f64).sqrt();
        assert!((gap / reported - 1.0).abs() < 1e-9, "{gap} {reported}");
    }
    println!("{reported:?}, {:?}", holdout.reduction_ci95);
}

#[test]
fn the_same_seed_gives_the_same_report_on_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    good().write(folder.path());
    let report = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let options = Options { seed: 9, ..Options::default() };
        let mut report = pool.install(|| diagnose(folder.path(), &options)).unwrap().report;
        report.seconds = 0.0;
        report
    };
    assert_eq!(report(1), report(3));
}
