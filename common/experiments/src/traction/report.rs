//! Table and figures of the experiment.

use super::analysis::{CaseResult, CurvePoint, SECOND_ROUND_S, curve_points, fit_adhesion_peak, polach_n};
use super::run::{Case, SAMPLE_PERIOD_S};
use crate::plot::{Mark, Panel, Series, write_svg};
use crate::{Criterion, ExperimentError, Report, Table, bench};
use railgrip_filter::models::traction_rig::TractionState;
use railgrip_vehicle::traction_rig::Surface;
use rayon::prelude::*;
use std::path::Path;

/// Seed of the sensor noise.
const SEED: u64 = 2014;

/// Runs all tests and writes figures; the table comes back.
pub fn experiment(directory: &Path) -> Result<Report, ExperimentError> {
    let results: Vec<CaseResult> =
        Case::all().into_par_iter().map(|case| CaseResult::new(case, SEED)).collect();
    let mut report = Report::default();
    let mut fits = Vec::new();
    for surface in Surface::ALL {
        let own: Vec<&CaseResult> = results.iter().filter(|result| result.case.surface == surface).collect();
        let points: Vec<CurvePoint> = own[1..].iter().flat_map(|result| curve_points(result)).collect();
        let fit = fit_adhesion_peak(&own[0].case.rig(), &points);
        surface_rows(&mut report, surface, &own, fit);
        fits.push((surface, fit, points));
        let path = directory.join(format!("zhao-traction-{}.svg", surface.name()));
        write_svg(&path, 2, (620, 330), &time_panels(surface, &own))?;
        report.files.push(path);
    }
    for result in &results {
        case_rows(&mut report.table, result);
    }
    let path = directory.join("zhao-traction-average.svg");
    write_svg(&path, 2, (620, 420), &[average_panel(&results), curve_panel(&fits)])?;
    report.files.push(path);
    for time in bench::traction_filters(3000) {
        let remark = if time.name.contains("UKF") { "bound 20 µs" } else { "for comparison" };
        report.table.push("filters", time.name, "µs", None, time.step_ns * 1e-3, remark);
    }
    Ok(report)
}

fn surface_rows(report: &mut Report, surface: Surface, own: &[&CaseResult], fit: f64) {
    let paper = surface.adhesion_peak();
    let name = surface.name();
    let loaded = &own[1..];
    let samples: f64 = loaded.iter().map(|result| result.ukf_summary.seen_samples).sum();
    let weight: f64 = loaded.iter().map(|result| seen_weight(result)).sum();
    let seen = loaded.iter().map(|result| seen_weight(result) * seen_mean(result)).sum::<f64>() / weight;
    let plain =
        loaded.iter().map(|result| result.ukf_summary.adhesion_peak).sum::<f64>() / loaded.len() as f64;
    let by_ekf =
        loaded.iter().map(|result| result.ekf_summary.adhesion_peak).sum::<f64>() / loaded.len() as f64;
    let by_paper =
        loaded.iter().map(|result| result.paper_summary.adhesion_peak).sum::<f64>() / loaded.len() as f64;
    let table = &mut report.table;
    let remark = format!("cases 1–4, {samples:.0} samples not called unobservable, weighted with 1/σ²");
    table.push(name, "weighted mean μ0, filter", "", Some(paper), seen, remark);
    let remark = "cases 1–4, every sample counts the same, unobservable ones too: what the paper averages";
    table.push(name, "plain mean μ0, filter", "", Some(paper), plain, remark);
    table.push(name, "μ0 of the Polach fit", "", Some(paper), fit, "all (γ, F_γ) points of cases 1–4");
    table.push(name, "plain mean μ0, EKF", "", Some(paper), by_ekf, "same samples");
    let remark = "w_k, v_k as printed, read as standard deviations; voltage as random walk";
    table.push(name, "plain mean μ0, paper's noise", "", Some(paper), by_paper, remark);
    let bound = 0.1 * paper;
    for (what, value) in [("filter, weighted", seen), ("Polach fit", fit)] {
        report.criteria.push(Criterion {
            name: format!("{name}: μ0 by {what} within 10 % of {paper}"),
            figure: format!("{value:.4}"),
            met: (value - paper).abs() <= bound,
        });
    }
    report.criteria.push(Criterion {
        name: format!("{name}: case 0 is called unobservable"),
        figure: format!("seen in {:.0} % of the samples", 100.0 * own[0].ukf_summary.seen),
        met: own[0].state() == TractionState::Unobservable,
    });
}

/// Weight of a test in the mean of its surface: what its own sigma says.
fn seen_weight(result: &CaseResult) -> f64 {
    let summary = &result.ukf_summary;
    if summary.seen_samples > 0.0 { summary.seen / summary.adhesion_peak_sigma.powi(2) } else { 0.0 }
}

fn seen_mean(result: &CaseResult) -> f64 {
    if result.ukf_summary.seen_samples > 0.0 { result.ukf_summary.adhesion_peak_seen } else { 0.0 }
}

/// Why a test's plain mean lies beside the surface's μ0, and what the paper says of the same test.
fn explanation(result: &CaseResult) -> String {
    let summary = &result.ukf_summary;
    let base = result.case.surface == Surface::Base;
    if result.case.number == 0 {
        let paper =
            if base { "paper: \"very low and cannot be true\", not reliable without load" } else { "" };
        let joined = if base { "; " } else { "" };
        return format!(
            "; no figure: without load the force says nothing about μ0, its mean is the prior's{joined}{paper}"
        );
    }
    if result.state() == TractionState::Observable {
        return String::new();
    }
    let apart =
        (summary.adhesion_peak - result.case.surface.adhesion_peak()).abs() / summary.adhesion_peak_sigma;
    let paper = match base {
        true => "paper: \"oscillations quite significant\" in cases 1 to 3",
        false => "paper: follows the load, not μ0 alone",
    };
    format!(
        "; creepage mostly {:.2} %: there stiffness sets the force and μ0 hardly does; {apart:.1} of its own sigma beside; {paper}",
        100.0 * summary.creepage
    )
}

fn case_rows(table: &mut Table, result: &CaseResult) {
    let group = format!("{} case {}", result.case.surface.name(), result.case.number);
    let (ukf, ekf) = (&result.ukf_summary, &result.ekf_summary);
    let paper = (result.case.number > 0).then(|| result.case.surface.adhesion_peak());
    let remark = format!(
        "{}, seen in {:.0} %, ±{:.4}, R_L {} Ω{}",
        result.state().name(),
        100.0 * ukf.seen,
        ukf.adhesion_peak_sigma,
        result.case.load_resistance_ohm(),
        explanation(result)
    );
    table.push(&group, "mean μ0", "", paper, ukf.adhesion_peak, remark);
    table.push(&group, "mean μ0, EKF", "", paper, ekf.adhesion_peak, "");
    table.push(&group, "μ0 error, RMS", "", None, ukf.adhesion_peak_rms, "UKF");
    table.push(&group, "μ0 error, RMS, EKF", "", None, ekf.adhesion_peak_rms, "");
    let remark = "UKF; in the first acceleration μ0 is still the prior's, and the mean of its spread over the bent \
                  law lies beside the force";
    table.push(&group, "creep force error, RMS", "N", None, ukf.creep_force_rms_n, remark);
    let remark = format!("UKF; of {:.1} N in the mean", ukf.creep_force_late_n);
    let late = ukf.creep_force_rms_late_n;
    table.push(&group, format!("the same from {SECOND_ROUND_S} s on"), "N", None, late, remark);
    table.push(&group, "creep force error, RMS, EKF", "N", None, ekf.creep_force_rms_n, "");
    table.push(&group, "creepage error, RMS", "%", None, 100.0 * ukf.creepage_rms, "UKF");
    table.push(&group, "creepage, largest", "%", None, 100.0 * ukf.creepage_max, "truth");
    table.push(&group, "mean NIS", "", Some(7.0), ukf.nis, "theory: 7");
}

/// Panels (a) to (d) of the paper's Figs. 9 to 11.
fn time_panels(surface: Surface, own: &[&CaseResult]) -> Vec<Panel> {
    let name = surface.name();
    let panel = |letter: &str, what: &str, label: &'static str| {
        Panel::new(format!("({letter}) {what}, {name}"), "time, s", label).x(0.0, 35.0)
    };
    let peak = surface.adhesion_peak();
    let mut panels = [
        panel("a", "generator current", "I_dc, A"),
        panel("b", "creepage", "γ, %"),
        panel("c", "creep force of one wheel", "F_γ, N"),
        panel("d", "friction coefficient", "μ0").y(0.0, 2.5 * peak),
    ];
    for result in own {
        let label = format!("case {}", result.case.number);
        let series = |pick: &dyn Fn(usize) -> f64| {
            let every = 50;
            let points = (0..result.run.len()).step_by(every).map(|k| (k as f64 * SAMPLE_PERIOD_S, pick(k)));
            Series::new(label.clone(), result.case.number, Mark::Line, points.collect())
        };
        let ukf = &result.ukf;
        panels[0].series.push(series(&|k| result.run[k].sample.generator_current_a));
        panels[1].series.push(series(&|k| 100.0 * ukf[k].creepage));
        panels[2].series.push(series(&|k| ukf[k].creep_force_n));
        // What the filter does not claim to know is not drawn as if it did.
        panels[3].series.push(series(&|k| match ukf[k].state {
            TractionState::Weak | TractionState::Observable => ukf[k].adhesion_peak,
            _ => f64::NAN,
        }));
    }
    let top = own[1..].iter().map(|result| result.ukf_summary.creepage_max).fold(0.0, f64::max);
    panels[1].y_range = Some((-0.1 * 100.0 * top, 115.0 * top));
    let force = 1.2 * peak * 2000.0;
    panels[2].y_range = Some((-0.4 * force, force));
    panels.into()
}

/// Fig. 12: mean μ0 of each case.
fn average_panel(results: &[CaseResult]) -> Panel {
    let mut panel =
        Panel::new("Plain mean of the estimated μ0 by case, 1 σ (grey: paper)", "load case", "μ0")
            .x(-0.2, 4.4)
            .y(0.0, 0.36);
    for (colour, surface) in Surface::ALL.into_iter().enumerate() {
        let own: Vec<_> = results.iter().filter(|result| result.case.surface == surface).collect();
        let points =
            own.iter().skip(1).map(|result| (result.case.number as f64, result.ukf_summary.adhesion_peak));
        let paper = vec![(0.0, surface.adhesion_peak()), (4.4, surface.adhesion_peak())];
        let mut reference = Series::new("", 0, Mark::Line, paper);
        reference.colour = plotters::style::RGBColor(170, 170, 170);
        panel.series.push(reference);
        panel.series.push(Series::new(surface.name(), colour + 1, Mark::Bold, points.collect()));
        let bars = own.iter().skip(1).map(|result| {
            let (x, summary) = (result.case.number as f64, &result.ukf_summary);
            let (low, high) = (
                summary.adhesion_peak - summary.adhesion_peak_sigma,
                summary.adhesion_peak + summary.adhesion_peak_sigma,
            );
            Series::new("", colour + 1, Mark::Line, vec![(x, low), (x, high)])
        });
        panel.series.extend(bars);
    }
    panel
}

/// Fig. 13: creep curves with the fitted law.
fn curve_panel(fits: &[(Surface, f64, Vec<CurvePoint>)]) -> Panel {
    let mut panel =
        Panel::new("(γ, F_γ) of the filter and Polach's law fitted to it", "creepage γ, %", "F_γ / F_N")
            .x(0.0, 4.0)
            .y(0.0, 0.36);
    for (colour, (surface, fit, points)) in fits.iter().enumerate() {
        let rig = Case { surface: *surface, number: 4 }.rig();
        let load = rig.parameters.drivetrain.normal_load_n;
        let dots = points.iter().map(|point| (100.0 * point.creepage, point.creep_force_n / load)).collect();
        let law = (0..=400).map(|k| {
            let creepage = f64::from(k) * 1e-4;
            (100.0 * creepage, polach_n(&rig, creepage, 1.0, *fit) / load)
        });
        panel.series.push(Series::new("", colour + 1, Mark::Dots, dots));
        let label = format!("{}: law fitted, μ0 = {fit:.3}; points: filter", surface.name());
        panel.series.push(Series::new(label, colour + 1, Mark::Bold, law.collect()));
    }
    panel
}
