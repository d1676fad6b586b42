//! Beyond the paper: both tests with the rig's sensors and with those of a train (0.03 rad/s, 0.03 m/s, pads 0.15 s
//! late), over [`SEEDS`], by the paper's extended filter with its matrices (20), by the same filter with the best single
//! tuning we know for the sensors, by the product's filters `imm` and `default`, and by fixed-interval smoothing.
//!
//! The comparison is fair: every filter sees the same samples of one wheel speed, one roller speed and one pressing
//! force, believes the same inertia (5 % off) and prompt pads, and is told the same sigmas of the sensors, but for (20),
//! whose R is the paper's. None was tuned on these seeds.

use super::filter::{PadLaw, Tuning, estimate, smoothed};
use super::judge::{BOUND, Judgement, judge};
use super::noise::product_adhesion;
use super::rig::{RigSample, RigSensors, Test, nominal_model, simulate};
use crate::plot::{Mark, Panel, Series, write_svg};
use crate::{Criterion, ExperimentError, Report};
use rayon::prelude::*;
use std::path::Path;

/// Seeds of rail and sensors; the tunings were chosen on others.
const SEEDS: [u64; 5] = [77, 78, 79, 80, 81];

/// The filters in the order of the table.
const NAMES: [&str; 5] = [
    "paper's EKF, (20)",
    "paper's EKF, one tuning for the sensors",
    "filter \"imm\"",
    "filter \"default\"",
    "one tuning, smoothed",
];

/// One tuning for all situations: fast enough to follow a jump in about 0.1 s, R as the sensors are.
fn one_tuning(sensors: &RigSensors) -> Tuning {
    Tuning { q: [1e1, 1e-5, 1e-4, 5e-3], r: [sensors.wheel_speed_rad_s.powi(2), sensors.speed_m_s.powi(2)] }
}

/// Adhesion by every filter on one run.
struct Run {
    samples: Vec<RigSample>,
    adhesion: [Vec<f64>; NAMES.len()],
}

impl Run {
    fn new(test: Test, sensors: &RigSensors, seed: u64) -> Result<Self, ExperimentError> {
        let samples = simulate(test, seed, *sensors);
        let model = nominal_model(test);
        let one = one_tuning(sensors);
        let pick = |estimates: Vec<super::filter::RigEstimate>| -> Vec<f64> {
            estimates.iter().map(|estimate| estimate.adhesion).collect()
        };
        let adhesion = [
            pick(estimate(&model, &Tuning::PAPER, PadLaw::Constant, &samples)),
            pick(estimate(&model, &one, PadLaw::Constant, &samples)),
            product_adhesion("imm", test, sensors, &samples)?,
            product_adhesion("default", test, sensors, &samples)?,
            pick(smoothed(&model, &one, &samples)?),
        ];
        Ok(Self { samples, adhesion })
    }

    fn judge(&self, filter: usize) -> Judgement {
        judge(&self.samples, |k| self.adhesion[filter][k])
    }
}

/// Table and figure.
pub fn experiment(directory: &Path) -> Result<Report, ExperimentError> {
    let mut report = Report::default();
    let mut panels = Vec::new();
    let tests = [(Test::SlideProtection, "slide protection"), (Test::Sanding, "sanding")];
    let sensors = [("rig's sensors", RigSensors::RIG), ("train's sensors", RigSensors::SERVICE)];
    for (test, name) in tests {
        for (kind, sensors) in &sensors {
            let runs: Vec<Run> =
                SEEDS.par_iter().map(|seed| Run::new(test, sensors, *seed)).collect::<Result<_, _>>()?;
            let group = format!("{name}, {kind}");
            rows(&mut report, &group, &runs, *kind == "rig's sensors");
            if *kind == "train's sensors" {
                panels.push(panel(name, &runs[0]));
            }
        }
    }
    let path = directory.join("schwarz-beyond.svg");
    write_svg(&path, 1, (1240, 360), &panels)?;
    report.files.push(path);
    Ok(report)
}

fn rows(report: &mut Report, group: &str, runs: &[Run], fine: bool) {
    let judged: Vec<Judgement> = (0..NAMES.len())
        .map(|filter| Judgement::pooled(&runs.iter().map(|run| run.judge(filter)).collect::<Vec<_>>()))
        .collect();
    for (name, judged) in NAMES.iter().zip(&judged) {
        let share = 100.0 * judged.share_above;
        let remark = format!("{} seeds; share of samples above {BOUND}: {share:.2} %", runs.len());
        report.table.push(group, format!("RMS error, {name}"), "", None, judged.rms, remark);
        let what = format!("largest error outside protection events, {name}");
        let remark = verdict(judged.largest_outside <= BOUND, fine);
        report.table.push(group, what, "", Some(BOUND), judged.largest_outside, remark);
        let longest = judged.longest_above_s;
        let remark = verdict(longest <= 0.1, fine);
        report.table.push(
            group,
            format!("longest time above {BOUND}, {name}"),
            "s",
            Some(0.1),
            longest,
            remark,
        );
    }
    let [paper, one, imm, default, smooth] = [0, 1, 2, 3, 4].map(|filter| judged[filter]);
    let mut criterion = |text: &str, figure: String, met: bool| {
        report.criteria.push(Criterion { name: format!("{group}: {text}"), figure, met });
    };
    let rms = |better: f64, worse: f64| format!("RMS {better:.5} against {worse:.5}");
    criterion("imm beats the paper's EKF with (20)", rms(imm.rms, paper.rms), imm.rms < paper.rms);
    criterion("imm beats the paper's EKF with one tuning", rms(imm.rms, one.rms), imm.rms < one.rms);
    if fine {
        criterion(
            "imm: error at most 0.02 outside protection events",
            format!("{:.4}", imm.largest_outside),
            imm.largest_outside <= BOUND,
        );
    } else {
        // The paper's bound is one for a rig's sensors: of a hundred thousand noisy samples the worst lies beyond it.
        let share = 100.0 * imm.share_above;
        let all = if imm.largest_outside <= BOUND { "all are" } else { "not all, as the paper's bound asks" };
        criterion(
            "imm: 99.5 % of the samples within 0.02",
            format!(
                "{all}: {share:.2} % beyond, the largest outside protection events {:.4}",
                imm.largest_outside
            ),
            imm.share_above <= 0.005,
        );
    }
    criterion(
        "imm: a jump is followed within 0.1 s",
        format!("{:.3} s above {BOUND} at the longest", imm.longest_above_s),
        imm.longest_above_s <= 0.1,
    );
    if !fine {
        let best = one.rms.min(paper.rms);
        criterion("the default filter beats both", rms(default.rms, best), default.rms < best);
        criterion(
            "smoothing a record takes at least 40 % of its filter's error away",
            rms(smooth.rms, one.rms),
            smooth.rms < 0.6 * one.rms,
        );
    }
}

/// Whether the paper's bound, which it states for a rig's sensors, is met.
fn verdict(met: bool, fine: bool) -> &'static str {
    match (met, fine) {
        (true, _) => "bound met",
        (false, true) => "bound not met",
        (false, false) => {
            "bound not met; the paper states it for a rig's sensors, here noise alone moves a wheel by 0.03 rad/s"
        }
    }
}

fn panel(name: &str, run: &Run) -> Panel {
    let samples = &run.samples;
    let series = |label: &str, colour: usize, mark: Mark, pick: &dyn Fn(usize) -> f64| {
        let points = (0..samples.len()).step_by(4).map(|k| (samples[k].time_s, pick(k))).collect();
        Series::new(label, colour, mark, points)
    };
    let by = |filter: usize, colour: usize| {
        series(NAMES[filter], colour, Mark::Line, &|k| -run.adhesion[filter][k])
    };
    let (from, to) = if name == "sanding" { (2.0, 46.0) } else { (40.0, 84.0) };
    Panel::new(format!("Adhesion utilised with the sensors of a train: {name}"), "time, s", "|μ_W|")
        .x(from, to)
        .y(-0.02, 0.14)
        .with(by(1, 5))
        .with(by(3, 3))
        .with(by(4, 2))
        .with(by(2, 1))
        .with(series("truth", 0, Mark::Bold, &|k| -samples[k].adhesion))
}
