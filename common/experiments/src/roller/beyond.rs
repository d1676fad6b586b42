//! Beyond the paper: both tests with the sensors of a train (0.03 rad/s, 0.03 m/s, pads 0.15 s late), by the paper's
//! matrices, by one tuning that suits these sensors, by multiple models, by the product's default filter, and by
//! fixed-interval smoothing of the whole record.

use super::filter::{PadLaw, Tuning, estimate, smoothed};
use super::judge::{BOUND, judge};
use super::multiple_model;
use super::noise::product_adhesion;
use super::rig::{RigSample, RigSensors, Test, nominal_model, simulate};
use crate::plot::{Mark, Panel, Series, write_svg};
use crate::{Criterion, ExperimentError, Report};
use std::path::Path;

/// Seed of rail and sensors; the tunings below were chosen on another one.
const SEED: u64 = 77;
/// R of the service sensors.
const R: [f64; 2] = [9e-4, 9e-4];
/// One tuning for all situations: fast enough to follow a jump in about 0.1 s.
const ONE: Tuning = Tuning { q: [1e1, 1e-5, 1e-4, 5e-3], r: R };
/// Adhesion that hardly moves.
const STEADY: Tuning = Tuning { q: [3.0, 1e-5, 1e-4, 3e-4], r: R };
/// Adhesion that jumps.
const MOVING: Tuning = Tuning { q: [1e1, 1e-5, 1e-4, 1e-1], r: R };
/// Probability to stay in a mode over one sample.
const STAY: f64 = 0.95;

/// Table and figure.
pub fn experiment(directory: &Path) -> Result<Report, ExperimentError> {
    let mut report = Report::default();
    let mut panels = Vec::new();
    for (test, name) in [(Test::SlideProtection, "slide protection"), (Test::Sanding, "sanding")] {
        let samples = simulate(test, SEED, RigSensors::SERVICE);
        let model = nominal_model(test);
        let pick = |estimates: Vec<super::filter::RigEstimate>| -> Vec<f64> {
            estimates.iter().map(|estimate| estimate.adhesion).collect()
        };
        let by = [
            ("matrices (20)", pick(estimate(&model, &Tuning::PAPER, PadLaw::Constant, &samples))),
            ("one tuning", pick(estimate(&model, &ONE, PadLaw::Constant, &samples))),
            ("multiple models", pick(multiple_model::estimate(&model, &[STEADY, MOVING], STAY, &samples))),
            ("default filter", product_adhesion("default", test, &samples)?),
            ("one tuning, smoothed", pick(smoothed(&model, &ONE, &samples)?)),
        ];
        rows(&mut report, name, &samples, &by);
        panels.push(panel(name, &samples, &by));
    }
    let path = directory.join("schwarz-beyond.svg");
    write_svg(&path, 1, (1240, 360), &panels)?;
    report.files.push(path);
    Ok(report)
}

fn rows(report: &mut Report, name: &str, samples: &[RigSample], by: &[(&str, Vec<f64>); 5]) {
    let judged = by.each_ref().map(|(_, adhesion)| judge(samples, |k| adhesion[k]));
    for ((what, _), judged) in by.iter().zip(&judged) {
        let sensors = if *what == "default filter" { "; two wheel-speed sensors" } else { "" };
        let share = 100.0 * judged.share_above;
        let remark = format!("share of samples above {BOUND}: {share:.1} %{sensors}");
        report.table.push(name, format!("RMS error, {what}"), "", None, judged.rms, remark);
        let longest = judged.longest_above_s;
        report.table.push(name, format!("longest time above {BOUND}, {what}"), "s", Some(0.1), longest, "");
    }
    let [paper, one, multiple, default, smooth] = judged;
    let mut criterion = |text: &str, better: f64, worse: f64| {
        report.criteria.push(Criterion {
            name: format!("{name}: {text}"),
            figure: format!("RMS {better:.4} against {worse:.4}"),
            met: better < worse,
        });
    };
    criterion("multiple models beat the paper's filter", multiple.rms, paper.rms);
    criterion("multiple models beat one tuning", multiple.rms, one.rms);
    criterion("the default filter beats the paper's and one tuning", default.rms, one.rms.min(paper.rms));
    criterion("smoothing a record takes at least 40 % of its filter's error away", smooth.rms, 0.6 * one.rms);
}

fn panel(name: &str, samples: &[RigSample], by: &[(&str, Vec<f64>); 5]) -> Panel {
    let series = |label: &str, colour: usize, mark: Mark, pick: &dyn Fn(usize) -> f64| {
        let points = (0..samples.len()).step_by(4).map(|k| (samples[k].time_s, pick(k))).collect();
        Series::new(label, colour, mark, points)
    };
    let (from, to) = if name == "sanding" { (2.0, 46.0) } else { (40.0, 84.0) };
    Panel::new(format!("Adhesion utilised with the sensors of a train: {name}"), "time, s", "|μ_W|")
        .x(from, to)
        .y(-0.02, 0.14)
        .with(series(by[1].0, 5, Mark::Line, &|k| -by[1].1[k]))
        .with(series(by[2].0, 1, Mark::Line, &|k| -by[2].1[k]))
        .with(series(by[3].0, 3, Mark::Line, &|k| -by[3].1[k]))
        .with(series(by[4].0, 2, Mark::Line, &|k| -by[4].1[k]))
        .with(series("truth", 0, Mark::Bold, &|k| -samples[k].adhesion))
}
