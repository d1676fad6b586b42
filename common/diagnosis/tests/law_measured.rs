//! Measured creep points of a full-scale roller rig (Virginia Tech), read from the shared material beside the project and never
//! copied into it: which nominal law falls short, and what closes the gap.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

use railgrip_diagnosis::html::render;
use railgrip_diagnosis::law_bench::{Options, diagnose};
use railgrip_diagnosis::words::summary;
use railgrip_recording::Table;
use railgrip_requirements::CREEP_POINTS;
use std::fmt::Write;
use std::path::Path;

railgrip_requirements::tests! {
    polach_beats_the_bilinear_law_on_measured_points: [CREEP_POINTS],
    what_closes_the_gap_on_the_measured_sweep: [CREEP_POINTS],
}

/// Wheel load of the creepage sweep as its source suggests, N.
const LOAD_N: f64 = 9600.0;

/// Creepage (dimensionless) and force (N) of the sweep.
fn sweep() -> Vec<(f64, f64)> {
    let table = Table::read(&CREEP_POINTS.path().join("creepage_sweep_digitised.csv")).unwrap();
    let creepage = table.column("creepage_percent").unwrap();
    let force = table.column("Fx_N_mid").unwrap();
    creepage.iter().zip(force).map(|(s, f)| (s / 100.0, *f)).collect()
}

fn rmse(points: &[(f64, f64)], law: impl Fn(f64) -> f64) -> f64 {
    let sum: f64 = points.iter().map(|(s, f)| (law(*s) - f).powi(2)).sum();
    (sum / points.len() as f64).sqrt()
}

/// Best RMSE over a grid of the two parameters of a law, refined three times.
fn best(points: &[(f64, f64)], law: impl Fn(f64, f64, f64) -> f64) -> (f64, f64, f64) {
    let (mut slope, mut limit, mut reach) = (7e5, 4800.0, 0.5);
    let mut error = f64::INFINITY;
    for _ in 0..9 {
        let (s0, l0) = (slope, limit);
        for i in -10..=10 {
            for j in -10..=10 {
                let (s, l) =
                    (s0 * (1.0 + reach * f64::from(i) / 10.0), l0 * (1.0 + reach * f64::from(j) / 10.0));
                let e = rmse(points, |creepage| law(creepage, s, l));
                if e < error {
                    (error, slope, limit) = (e, s, l);
                }
            }
        }
        reach *= 0.5;
    }
    (error, slope, limit)
}

fn polach_beats_the_bilinear_law_on_measured_points() {
    let points = sweep();
    let (bilinear, slope, limit) = best(&points, |s, slope, limit| (slope * s).min(limit));
    let (polach, stiffness, friction) = best(&points, |s, stiffness, limit| {
        let eps = stiffness * s / limit;
        limit * std::f64::consts::FRAC_2_PI * (eps / (1.0 + eps * eps) + (0.4 * eps).atan())
    });
    println!("{} points", points.len());
    println!("bilinear Coulomb: RMSE {bilinear:.0} N, slope {slope:.3e} N, limit {limit:.0} N");
    println!("Polach, k_A 1, k_S 0.4: RMSE {polach:.0} N, K {stiffness:.3e} N, limit {friction:.0} N");
    assert!((220.0..270.0).contains(&bilinear), "{bilinear}");
    assert!(polach < 0.4 * bilinear, "{polach}");
}

/// A case of the sweep: every second of four parts is held out, so that both sets cover the range.
fn write_case(folder: &Path, points: &[(f64, f64)], k_s: f64) {
    let toml = format!(
        "schema = 1\nkind = \"creep\"\n[nominal]\nmu0 = 0.5\nstiffness_n = 7.0e5\nk_a = 1.0\nk_s = {k_s}\n"
    );
    std::fs::write(folder.join("bench.toml"), toml).unwrap();
    let mut texts = [("fit", String::new()), ("holdout", String::new())];
    for (_, text) in &mut texts {
        text.push_str("creepage,load_n,force_n\n");
    }
    for (index, (s, f)) in points.iter().enumerate() {
        let set = usize::from(index % 4 == 3);
        writeln!(texts[set].1, "{s},{LOAD_N},{f}").unwrap();
    }
    for (set, text) in texts {
        std::fs::create_dir_all(folder.join(set)).unwrap();
        std::fs::write(folder.join(set).join("sweep.csv"), text).unwrap();
    }
}

fn what_closes_the_gap_on_the_measured_sweep() {
    let points = sweep();
    for (name, k_s) in [("polach", 0.4), ("stiff_knee", 1.0)] {
        let case = tempfile::tempdir().unwrap();
        write_case(case.path(), &points, k_s);
        let outcome = diagnose(case.path(), &Options { seed: 1, ..Options::default() }).unwrap();
        let report = &outcome.report;
        println!("nominal k_A 1, k_S {k_s}; {}", outcome.detail.notes.join(" "));
        println!("{name}: {}", summary(report, &outcome.detail));
        let page = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("real_{name}.html"));
        std::fs::write(page, render(report, &outcome.detail)).unwrap();
        let holdout = &report.gap.holdout;
        assert!(holdout.extended <= holdout.calibrated * 1.05, "{holdout:?}");
        assert!(holdout.extended < 2.0, "{holdout:?}");
    }
}
