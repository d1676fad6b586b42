//! Adhesion from both sensors over time, slip and speed: Figs. 8 and 12 to 16.

use super::controller::Control;
use super::run::{Instant, Rail, Setup, simulate};
use crate::plot::{Mark, Panel, Series, write_svg};
use crate::{Criterion, ExperimentError, Report};
use railgrip_filter::models::bogie_rig::{BogieInputState, slip_based};
use railgrip_vehicle::bogie_rig::{BogieParameters, ContactLaw, RailCondition};
use rayon::prelude::*;
use std::path::Path;

/// Repetitions of a test; the paper repeats "at least twice".
const SEEDS: std::ops::Range<u64> = 2021..2024;

/// Speed of Figs. 12 to 15, m/s.
const SPEED_M_S: f64 = 1.388;

/// Width of a bin of slip, over which adhesion is averaged.
const BIN: f64 = 0.01;

/// Scatter of the paper's "around 0.4" and "almost half": half of the last digit that it gives, and what its Fig. 16
/// (0.45 at 0.69 m/s, "about") leaves at 1.388 m/s.
const ADHESION_SCATTER: f64 = 0.025;

/// Half a step of the scale on which the slip of a flat peak is read.
const SLIP_SCATTER: f64 = 0.03;

/// A test of section 4.1.1: speed held, brakes laid on slowly, let go at a slip.
fn setup(condition: RailCondition, v_m_s: f64, seed: u64) -> Setup {
    let mut parameters = BogieParameters::default();
    // Both calipers alike: with the pads of the other tests the wheelsets would slide one after the other, and what
    // link and shaft measure would belong to no single slip.
    parameters.brake.pad_friction = [0.4; 2];
    Setup {
        parameters,
        v_m_s,
        rail: Rail::Steady(condition),
        control: Control::Ramp {
            rate_nm_s: 25.0,
            release_at: if condition == RailCondition::Dry { 0.15 } else { 0.99 },
        },
        preset_torque_nm: 0.0,
        brake_from_s: 5.0,
        control_lag_s: 0.0,
        hold_s: f64::INFINITY,
        accuracy: 1.0,
        roughness: 0.5,
        end_s: 25.0,
        seed,
    }
}

fn tests(condition: RailCondition, v_m_s: f64) -> Vec<(Setup, Vec<Instant>)> {
    SEEDS.map(|seed| setup(condition, v_m_s, seed)).map(|setup| (setup.clone(), simulate(&setup))).collect()
}

/// Mean slip of both wheelsets as estimated, if the state tells it.
fn slip_of(instant: &Instant) -> Option<f64> {
    let estimate = &instant.estimate;
    estimate.state.tells_slip().then(|| -0.5 * (estimate.creepage[0] + estimate.creepage[1]))
}

/// Adhesion over slip while the brakes rise, filtered: means over bins of slip.
fn curve(runs: &[(Setup, Vec<Instant>)], adhesion: impl Fn(&Instant) -> f64) -> Vec<(f64, f64)> {
    let mut bins = vec![(0.0, 0.0); (1.0 / BIN) as usize + 1];
    for (setup, run) in runs {
        let rising = run.iter().filter(|i| i.sample.time_s > setup.brake_from_s && i.torque_nm > 0.0);
        for instant in rising {
            let Some(slip) = slip_of(instant) else { continue };
            let bin = (slip.clamp(0.0, 1.0) / BIN) as usize;
            bins[bin].0 += adhesion(instant);
            bins[bin].1 += 1.0;
        }
    }
    let filled = bins.iter().enumerate().filter(|(_, (_, count))| *count >= 2.0);
    filled.map(|(bin, (sum, count))| ((bin as f64 + 0.5) * BIN, sum / count)).collect()
}

/// Where a curve of bins peaks: over three bins at a time, weighted with what they hold above nine tenths of the best.
fn peak(curve: &[(f64, f64)]) -> (f64, f64) {
    let best = curve.iter().map(|(_, adhesion)| *adhesion).fold(0.0, f64::max);
    let near: Vec<_> = curve.iter().filter(|(_, adhesion)| *adhesion > 0.985 * best).collect();
    let weight: f64 = near.iter().map(|(_, adhesion)| adhesion - 0.98 * best).sum();
    let slip = near.iter().map(|(slip, adhesion)| slip * (adhesion - 0.98 * best)).sum::<f64>() / weight;
    (slip, best)
}

/// Figs. 8 and 12 to 16.
pub fn peak_experiment(directory: &Path) -> Result<Report, ExperimentError> {
    let mut report = Report::default();
    let mut runs = Vec::new();
    for (condition, wanted, at) in [(RailCondition::Dry, 0.4, 0.08), (RailCondition::Wet, 0.2, 0.15)] {
        let own = tests(condition, SPEED_M_S);
        peak_rows(&mut report, condition, &own, wanted, at);
        let path = directory.join(format!("shrestha-peak-{}.svg", condition.name()));
        write_svg(&path, 2, (620, 380), &slip_panels(condition, &own))?;
        report.files.push(path);
        runs.push(own);
    }
    sensor_rows(&mut report, &runs);
    let path = directory.join("shrestha-peak-sensors.svg");
    write_svg(&path, 1, (1000, 260), &sensor_panels(&runs[0][0]))?;
    report.files.push(path);
    speed_rows(directory, &mut report)?;
    Ok(report)
}

fn peak_rows(
    report: &mut Report,
    condition: RailCondition,
    runs: &[(Setup, Vec<Instant>)],
    wanted: f64,
    at: f64,
) {
    let name = format!("{} {SPEED_M_S} m/s", condition.name());
    let load = runs[0].0.parameters.wheelset_load_n[0];
    let law = ContactLaw::of(condition);
    let best = railgrip_filter::models::bogie_rig::optimum_slip(&law, SPEED_M_S, load);
    let p = &runs[0].0.parameters;
    let filtered = peak(&curve(runs, |i| -i.estimate.mu_w));
    let by_load_cell = peak(&curve(runs, |i| {
        slip_based::by_load_cell(i.sample.load_cell_n, i.sample.load_n).unwrap_or(f64::NAN)
    }));
    let by_torque = peak(&curve(runs, |i| {
        slip_based::by_torque(p, i.sample.shaft_torque_nm, i.sample.load_n).unwrap_or(f64::NAN)
    }));
    let table = &mut report.table;
    let remark = format!("filter, bins of slip {BIN}; our law: {:.3}", best.adhesion);
    table.push(&name, "peak adhesion", "", Some(wanted), filtered.1, remark);
    let remark = format!("filter; our law: {:.3}, within 2 % of its peak over a wide slip", best.slip);
    table.push(&name, "slip at the peak", "", Some(at), filtered.0, remark);
    table.push(
        &name,
        "peak adhesion, load cell alone",
        "",
        Some(wanted),
        by_load_cell.1,
        "(3) left, no filter",
    );
    let remark = "(3) right as printed: without loss and inertia";
    table.push(&name, "peak adhesion, torque alone", "", Some(wanted), by_torque.1, remark);
    report.criteria.push(Criterion {
        name: format!("{name}: peak adhesion within {ADHESION_SCATTER} of {wanted}"),
        figure: format!("{:.3}", filtered.1),
        met: (filtered.1 - wanted).abs() <= ADHESION_SCATTER,
    });
    report.criteria.push(Criterion {
        name: format!("{name}: slip at the peak within {SLIP_SCATTER} of {at}"),
        figure: format!("{:.3}", filtered.0),
        met: (filtered.0 - at).abs() <= SLIP_SCATTER,
    });
}

/// Standard deviation of the differences between neighbours, over √2: noise without what moves slowly.
fn jitter(values: &[f64]) -> f64 {
    let squares: f64 = values.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
    (squares / (2.0 * (values.len() - 1) as f64)).sqrt()
}

/// Adhesion from a sample by each way of (3): load cell, torque as printed, torque with inertia and loss.
fn three_ways(parameters: &BogieParameters, instant: &Instant) -> [f64; 3] {
    let (sample, estimate) = (&instant.sample, &instant.estimate);
    let speed = estimate.v_m_s / parameters.roller_radius_m;
    let acceleration = estimate.roller_acceleration_rad_s2;
    [
        slip_based::by_load_cell(sample.load_cell_n, sample.load_n),
        slip_based::by_torque(parameters, sample.shaft_torque_nm, sample.load_n),
        slip_based::by_torque_with_inertia(
            parameters,
            sample.shaft_torque_nm,
            speed,
            acceleration,
            sample.load_n,
        ),
    ]
    .map(|value| value.unwrap_or(f64::NAN))
}

/// Fig. 8 and what the inertia terms are worth.
fn sensor_rows(report: &mut Report, runs: &[Vec<(Setup, Vec<Instant>)>]) {
    let all = || runs.iter().flatten();
    let table = &mut report.table;
    let noise = |from: f64, to: f64, way: usize| {
        let each: Vec<f64> = all()
            .map(|(setup, run)| {
                let inside = run.iter().filter(|i| {
                    let since = i.sample.time_s - setup.brake_from_s;
                    (from..to).contains(&since) && i.estimate.v_m_s.is_finite()
                });
                jitter(&inside.map(|i| three_ways(&setup.parameters, i)[way]).collect::<Vec<_>>())
            })
            .collect();
        each.iter().sum::<f64>() / each.len() as f64
    };
    for (what, from, to) in [("slip near zero", -3.0, 0.0), ("braking", 1.5, 3.0)] {
        let (cell, torque) = (noise(from, to, 0), noise(from, to, 1));
        table.push("sensors", format!("jitter of adhesion, load cell, {what}"), "", None, cell, "one sigma");
        table.push("sensors", format!("jitter of adhesion, torque, {what}"), "", None, torque, "one sigma");
        let calm = from < 0.0;
        let (name, met) = if calm {
            ("with little slip the load cell scatters more than the torque (Fig. 8)", cell > torque)
        } else {
            ("in braking the torque jitters more than the load cell (Fig. 8)", torque > cell)
        };
        let figure = format!("{cell:.4} and {torque:.4}");
        report.criteria.push(Criterion { name: name.into(), figure, met });
    }
    let table = &mut report.table;
    let ways = ["(3), load cell", "(3), torque as printed", "torque with inertia and loss"];
    // Away from steady state: the second around the release.
    let rms = |pick: &dyn Fn(&Setup, &Instant) -> f64| {
        let squares: Vec<f64> = all()
            .flat_map(|(setup, run)| {
                let last = run.last().map_or(0.0, |last| last.sample.time_s);
                let moving = run.iter().filter(move |i| {
                    i.sample.time_s > last - 1.0 && i.estimate.state != BogieInputState::Starting
                });
                moving.map(|i| (pick(setup, i) - i.adhesion(&setup.parameters)).powi(2)).collect::<Vec<_>>()
            })
            .collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    };
    for (way, name) in ways.into_iter().enumerate() {
        let error = rms(&|setup, instant| three_ways(&setup.parameters, instant)[way]);
        table.push(
            "sensors",
            format!("error around the release, {name}"),
            "",
            None,
            error,
            "RMS against truth",
        );
    }
    let error = rms(&|_, instant| -instant.estimate.mu_w);
    table.push("sensors", "error around the release, filter", "", None, error, "RMS against truth");
    let (sum, count) = all().flat_map(|(_, run)| run).fold((0.0, 0.0), |(sum, count), instant| {
        (sum + instant.estimate.nis, count + f64::from(instant.estimate.nis_dof))
    });
    table.push("sensors", "mean NIS a value, filter", "", Some(1.0), sum / count, "theory: 1");
}

/// Fig. 16: 32 to 192 rpm of the rollers in steps of 32, which the paper counts as 0.69 m/s each.
fn speed_rows(directory: &Path, report: &mut Report) -> Result<(), ExperimentError> {
    let speeds: Vec<f64> = (1..=6).map(|k| 0.69 * f64::from(k)).collect();
    let found: Vec<(f64, f64)> = speeds
        .par_iter()
        .map(|v| (*v, peak(&curve(&tests(RailCondition::Dry, *v), |i| -i.estimate.mu_w)).1))
        .collect();
    for (v, adhesion) in &found {
        let paper = if *v < 0.7 {
            Some(0.45)
        } else if *v > 4.0 {
            Some(0.35)
        } else {
            None
        };
        let name = format!("{v:.2} m/s");
        report.table.push("speed, dry", format!("peak adhesion at {name}"), "", paper, *adhesion, "filter");
        if let Some(paper) = paper {
            report.criteria.push(Criterion {
                name: format!("peak at {name} within {ADHESION_SCATTER} of {paper}"),
                figure: format!("{adhesion:.3}"),
                met: (adhesion - paper).abs() <= ADHESION_SCATTER,
            });
        }
    }
    let falls = found.windows(2).all(|pair| pair[1].1 < pair[0].1);
    report.criteria.push(Criterion {
        name: "peak adhesion falls from speed to speed".into(),
        figure: found.iter().map(|(_, adhesion)| format!("{adhesion:.3}")).collect::<Vec<_>>().join(", "),
        met: falls,
    });
    let load = BogieParameters::default().wheelset_load_n[0];
    let law = ContactLaw::of(RailCondition::Dry);
    let line = (10..450)
        .map(|k| f64::from(k) * 0.01)
        .map(|v| (v, railgrip_filter::models::bogie_rig::optimum_slip(&law, v, load).adhesion));
    let ring = |(x, y): (f64, f64), wide: f64, high: f64| {
        (0..40).map(move |k| f64::from(k) * 0.157).map(move |a| (x + wide * a.cos(), y + high * a.sin()))
    };
    let panel = Panel::new(
        "Fig. 16: peak adhesion over speed, dry (rings: ours, dots: the paper's 0.45 and 0.35)",
        "roller speed, m/s",
        "peak adhesion",
    )
    .x(0.0, 4.5)
    .y(0.3, 0.5)
    .with(Series::new("our law", 6, Mark::Line, line.collect()))
    .with(Series::new("filter", 1, Mark::Bold, found.clone()))
    .with(Series::new("", 1, Mark::Dots, found.iter().flat_map(|at| ring(*at, 0.03, 0.003)).collect()))
    .with(Series::new(
        "",
        2,
        Mark::Dots,
        [(0.69, 0.45), (4.14, 0.35)].into_iter().flat_map(|at| ring(at, 0.015, 0.0015)).collect(),
    ));
    let path = directory.join("shrestha-peak-speed.svg");
    write_svg(&path, 1, (760, 420), &[panel])?;
    report.files.push(path);
    Ok(())
}

/// Figs. 12 and 13, or 14 and 15.
fn slip_panels(condition: RailCondition, runs: &[(Setup, Vec<Instant>)]) -> Vec<Panel> {
    let (first, second) = if condition == RailCondition::Dry { (12, 13) } else { (14, 15) };
    let name = condition.name();
    let run = &runs[0].1;
    let over_time = |label: &str, colour: usize, pick: &dyn Fn(&Instant) -> f64| {
        Series::new(label, colour, Mark::Line, run.iter().map(|i| (i.sample.time_s, pick(i))).collect())
    };
    let (slip_top, top) = if condition == RailCondition::Dry { (0.2, 0.5) } else { (1.0, 0.3) };
    let time =
        Panel::new(format!("Fig. {first}: adhesion and slip over time, {name}"), "time, s", "adhesion; slip")
            .y(-0.05, if condition == RailCondition::Dry { 0.5 } else { 1.05 })
            .with(over_time("slip", 2, &|i| slip_of(i).unwrap_or(f64::NAN)))
            .with(over_time("adhesion, filter", 1, &|i| -i.estimate.mu_w));
    let dots = runs.iter().flat_map(|(setup, run)| {
        run.iter()
            .filter(|i| i.sample.time_s > setup.brake_from_s && i.torque_nm > 0.0)
            .filter_map(|i| Some((slip_of(i)?, i.sample.load_cell_n / i.sample.load_n)))
    });
    let load = BogieParameters::default().wheelset_load_n[0];
    let law = ContactLaw::of(condition);
    let line = (0..=200).map(|k| f64::from(k) * slip_top / 200.0);
    let slip = Panel::new(
        format!("Fig. {second}: adhesion over slip, {name} (dots: load cell)"),
        "slip",
        "adhesion",
    )
    .x(-0.01, slip_top)
    .y(0.0, top)
    .with(Series::new("", 0, Mark::Dots, dots.collect()))
    .with(Series::new(
        "our law",
        6,
        Mark::Line,
        line.map(|s| (s, law.adhesion(s, SPEED_M_S, load))).collect(),
    ))
    .with(Series::new("filter, means", 1, Mark::Bold, curve(runs, |i| -i.estimate.mu_w)));
    vec![time, slip]
}

/// Fig. 8.
fn sensor_panels((setup, run): &(Setup, Vec<Instant>)) -> Vec<Panel> {
    let way = |label: &str, colour: usize, way: usize| {
        let points = run.iter().map(|i| (i.sample.time_s, three_ways(&setup.parameters, i)[way])).collect();
        Series::new(label, colour, Mark::Line, points)
    };
    let truth = run.iter().map(|i| (i.sample.time_s, i.adhesion(&setup.parameters))).collect();
    let filter = run.iter().map(|i| (i.sample.time_s, -i.estimate.mu_w)).collect();
    let slip = run.iter().map(|i| (i.sample.time_s, slip_of(i).unwrap_or(f64::NAN))).collect();
    vec![
        Panel::new("Fig. 8: adhesion by (3) from both sensors, dry", "time, s", "adhesion")
            .y(-0.05, 0.5)
            .with(way("torque", 5, 1))
            .with(way("load cell", 1, 0)),
        Panel::new("Adhesion by the filter", "time, s", "adhesion")
            .y(-0.05, 0.5)
            .with(Series::new("filter", 2, Mark::Line, filter))
            .with(Series::new("truth", 0, Mark::Line, truth)),
        Panel::new("Slip", "time, s", "slip").y(-0.02, 0.2).with(Series::new("", 3, Mark::Line, slip)),
    ]
}
