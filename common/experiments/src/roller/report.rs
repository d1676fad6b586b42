//! Tables and figures of the two tests.

use super::filter::{PadLaw, RigEstimate, Tuning, estimate};
use super::judge::{BOUND, Judgement, SETTLED_FROM_S, judge};
use super::rig::{NOMINAL_PAD_FRICTION, RADIUS_M, RigSample, RigSensors, Test, nominal_model, simulate};
use crate::plot::{Mark, Panel, Series, write_svg};
use crate::{Criterion, ExperimentError, Report};
use railgrip_vehicle::brake::FirstOrderFriction;
use std::path::Path;

/// Seed of rail and sensors.
const SEED: u64 = 2020;

/// Law (9) with the nominal friction as its level.
const FIRST_ORDER: PadLaw =
    PadLaw::FirstOrder(FirstOrderFriction { level: NOMINAL_PAD_FRICTION, time_s: 5.0 });

/// A test with the filter's estimates under both laws.
struct TestRun {
    samples: Vec<RigSample>,
    constant: Vec<RigEstimate>,
    first_order: Vec<RigEstimate>,
}

impl TestRun {
    fn new(test: Test) -> Self {
        let samples = simulate(test, SEED, RigSensors::RIG);
        let model = nominal_model(test);
        let constant = estimate(&model, &Tuning::PAPER, PadLaw::Constant, &samples);
        let first_order = estimate(&model, &Tuning::PAPER, FIRST_ORDER, &samples);
        Self { samples, constant, first_order }
    }

    fn judge(&self, estimates: &[RigEstimate]) -> Judgement {
        judge(&self.samples, |k| estimates[k].adhesion)
    }

    /// Smallest and largest adhesion utilised between two times while the protection acts, 5 % and 95 % quantiles.
    fn band(&self, from_s: f64, to_s: f64) -> (f64, f64) {
        let inside =
            self.samples.iter().filter(|sample| (from_s..to_s).contains(&sample.time_s) && sample.wsp_active);
        let mut values: Vec<f64> = inside.map(|sample| sample.adhesion.abs()).collect();
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values.get((share * values.len() as f64) as usize).copied().unwrap_or(f64::NAN);
        (at(0.05), at(0.95))
    }

    /// Root mean square error of pad friction from a time on, while the pads press.
    fn pad_rms(&self, estimates: &[RigEstimate], from_s: f64) -> f64 {
        let errors = self.samples.iter().zip(estimates).filter(|(sample, estimate)| {
            sample.time_s > from_s && estimate.pad_observable && sample.pressing_force_n > 3e3
        });
        let squares: Vec<f64> =
            errors.map(|(sample, estimate)| (sample.pad_friction - estimate.pad_friction).powi(2)).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    }
}

/// Fig. 4.
pub fn wsp_experiment(directory: &Path) -> Result<Report, ExperimentError> {
    let run = TestRun::new(Test::SlideProtection);
    let mut report = Report::default();
    let group = "slide protection";
    let (low, high) = run.band(42.0, 108.0);
    let table = &mut report.table;
    let remark = "5 % quantile of the rig's truth, 42–108 s; the paper's range is that of its plot, single dips included";
    table.push(group, "adhesion under protection, low end", "", Some(0.02), low, remark);
    let remark = "95 % quantile of the rig's truth, 42–108 s";
    table.push(group, "adhesion under protection, high end", "", Some(0.05), high, remark);
    common_rows(&mut report, group, &run, 45.0);
    let path = directory.join("schwarz-wsp.svg");
    write_svg(&path, 1, (1240, 260), &time_panels(&run, 0.13))?;
    report.files.push(path);
    Ok(report)
}

/// Figs. 5 and 6.
pub fn sanding_experiment(directory: &Path) -> Result<Report, ExperimentError> {
    let run = TestRun::new(Test::Sanding);
    let mut report = Report::default();
    sequence_rows(&mut report, &run);
    common_rows(&mut report, "sanding", &run, 8.0);
    let path = directory.join("schwarz-sanding.svg");
    write_svg(&path, 1, (1240, 260), &time_panels(&run, 0.13))?;
    report.files.push(path);
    let path = directory.join("schwarz-sanding-slip.svg");
    write_svg(&path, 1, (900, 330), &slip_panels(&run))?;
    report.files.push(path);
    Ok(report)
}

/// 0.1 → 0.05 → 0.1 → 0 between 4 s and 11 s: truth and estimate at each turn.
fn sequence_rows(report: &mut Report, run: &TestRun) {
    let deepest = run.samples.iter().position(|sample| sample.time_s > 6.3).unwrap_or(0);
    let end = run.samples.iter().position(|sample| sample.time_s > 11.0).unwrap_or(run.samples.len() - 1);
    let peak = |from: usize, to: usize, value: &dyn Fn(usize) -> f64| {
        (from..to).map(|k| value(k).abs()).fold(0.0, f64::max)
    };
    let low =
        |value: &dyn Fn(usize) -> f64| (deepest..deepest + 20).map(|k| value(k).abs()).sum::<f64>() / 20.0;
    let start = run.samples.iter().position(|sample| sample.time_s > SETTLED_FROM_S).unwrap_or(0);
    let truth = |k: usize| run.samples[k].adhesion;
    let ours = |k: usize| run.constant[k].adhesion;
    let rows = [
        ("first passage of the peak", 0.1, peak(start, deepest, &truth), peak(start, deepest, &ours)),
        ("deepest in the slide, mean over 0.1 s", 0.05, low(&truth), low(&ours)),
        ("second passage of the peak", 0.1, peak(deepest, end, &truth), peak(deepest, end, &ours)),
        ("after release, at 11 s", 0.0, truth(end).abs(), ours(end).abs()),
    ];
    for (what, paper, truth, ours) in rows {
        report.table.push(
            "sanding",
            what,
            "",
            Some(paper),
            ours,
            format!("estimated; truth of our rig {truth:.4}"),
        );
    }
}

fn common_rows(report: &mut Report, group: &str, run: &TestRun, pads_from_s: f64) {
    let (constant, first) = (run.judge(&run.constant), run.judge(&run.first_order));
    let table = &mut report.table;
    table.push(
        group,
        "largest error outside protection events",
        "",
        Some(BOUND),
        constant.largest_outside,
        "bound",
    );
    table.push(
        group,
        "longest time with error above 0.02",
        "s",
        Some(0.1),
        constant.longest_above_s,
        "bound",
    );
    table.push(group, "largest error in protection events", "", None, constant.largest_inside, "");
    table.push(group, "RMS error, pad law (8)", "", None, constant.rms, "");
    table.push(group, "RMS error, pad law (9)", "", None, first.rms, "level 0.35, t_μ 5 s");
    let pads = [run.pad_rms(&run.constant, pads_from_s), run.pad_rms(&run.first_order, pads_from_s)];
    table.push(
        group,
        "pad friction RMS error, law (8)",
        "",
        None,
        pads[0],
        "the paper could only judge by eye",
    );
    table.push(group, "pad friction RMS error, law (9)", "", None, pads[1], "");
    let held = run.constant.iter().filter(|estimate| !estimate.pad_observable).count() as f64;
    let share = held / run.constant.len() as f64;
    table.push(
        group,
        "share of samples with pad friction held and flagged",
        "",
        None,
        share,
        "pads off, (17) has no solution",
    );
    report.criteria.push(Criterion {
        name: format!("{group}: error of adhesion at most 0.02 outside protection events"),
        figure: format!("{:.4}", constant.largest_outside),
        met: constant.largest_outside <= BOUND,
    });
    report.criteria.push(Criterion {
        name: format!("{group}: a jump is followed within 0.1 s"),
        figure: format!("{:.3} s above 0.02 at the longest", constant.longest_above_s),
        met: constant.longest_above_s <= 0.1,
    });
}

/// Every so many samples are drawn.
const DRAWN: usize = 4;

/// Figs. 4 and 5: speeds, pressing force, adhesion and pad friction over time.
fn time_panels(run: &TestRun, adhesion_top: f64) -> Vec<Panel> {
    let end = run.samples.last().map_or(1.0, |sample| sample.time_s);
    let series = |label: &str, colour: usize, pick: &dyn Fn(usize) -> f64| {
        let points =
            (0..run.samples.len()).step_by(DRAWN).map(|k| (run.samples[k].time_s, pick(k))).collect();
        Series::new(label, colour, Mark::Line, points)
    };
    let panel = |title: &str, label: &'static str| Panel::new(title, "time, s", label).x(0.0, end);
    let (samples, constant, first) = (&run.samples, &run.constant, &run.first_order);
    vec![
        panel("Speeds", "km/h")
            .with(series("wheelset r ω", 2, &|k| 3.6 * RADIUS_M * samples[k].wheel_speed_rad_s))
            .with(series("roller v", 0, &|k| 3.6 * samples[k].v_m_s)),
        panel("Pressing force", "F, kN").with(series("", 1, &|k| 1e-3 * samples[k].pressing_force_n)),
        panel("Adhesion utilised", "|μ_W|")
            .y(-0.01, adhesion_top)
            .with(series("estimated", 2, &|k| -constant[k].adhesion))
            .with(series("simulated rig", 0, &|k| -samples[k].adhesion)),
        panel("Pad friction (gaps: pads off, held)", "μ_B")
            .y(0.25, 0.45)
            .with(series("law (9)", 5, &|k| {
                if first[k].pad_observable { first[k].pad_friction } else { f64::NAN }
            }))
            .with(series("law (8)", 2, &|k| {
                if constant[k].pad_observable { constant[k].pad_friction } else { f64::NAN }
            }))
            .with(series("truth", 0, &|k| samples[k].pad_friction)),
    ]
}

/// Fig. 6: adhesion over slip, error over slip.
fn slip_panels(run: &TestRun) -> Vec<Panel> {
    let from = (SETTLED_FROM_S / super::rig::SAMPLE_PERIOD_S) as usize;
    let dots = |label: &str, colour: usize, pick: &dyn Fn(usize) -> f64| {
        let points =
            (from..run.samples.len()).step_by(2).map(|k| (-run.samples[k].creepage, pick(k))).collect();
        Series::new(label, colour, Mark::Dots, points)
    };
    let bound = Series::new("0.02", 3, Mark::Line, vec![(-0.01, BOUND), (0.5, BOUND)]);
    vec![
        Panel::new("Adhesion over slip", "slip", "|μ_W|")
            .x(-0.01, 0.5)
            .y(-0.01, 0.13)
            .with(dots("estimated", 2, &|k| -run.constant[k].adhesion))
            .with(dots("simulated rig", 0, &|k| -run.samples[k].adhesion)),
        Panel::new("Absolute error over slip", "slip", "|error|")
            .x(-0.01, 0.5)
            .y(0.0, 0.06)
            .with(dots("", 1, &|k| (run.constant[k].adhesion - run.samples[k].adhesion).abs()))
            .with(bound),
    ]
}
