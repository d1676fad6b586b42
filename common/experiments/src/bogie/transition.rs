//! Water on a braked wheelset: Figs. 11 and 17.

use super::controller::Control;
use super::run::{Instant, Rail, Setup, simulate};
use crate::plot::{Mark, Panel, Series, write_svg};
use crate::{Criterion, ExperimentError, Report};
use railgrip_filter::models::bogie_rig::{RULE_DIFFERENCE, optimum_slip};
use railgrip_vehicle::bogie_rig::{BogieParameters, ContactLaw, RailCondition};
use rayon::prelude::*;
use std::path::Path;

/// Brakes on, s: the paper's.
pub(super) const BRAKE_S: f64 = 15.0;

/// Water, s: the paper's.
pub(super) const WATER_S: f64 = 50.0;

/// Seeds of every figure that is a mean; the first is drawn.
const SEEDS: std::ops::Range<u64> = 2021..2029;

/// Accuracy of the listener. Chosen; a classifier's own figure goes here.
const ACCURACY: f64 = 0.95;

pub(crate) fn setup(control: Control, accuracy: f64, seed: u64) -> Setup {
    let parameters = BogieParameters::default();
    let preset_torque_nm = 0.2 * parameters.wheelset_load_n[0] * parameters.wheel_radius_m;
    Setup {
        parameters,
        v_m_s: 2.9,
        // Chosen: water is all around the rollers after some turns; sliding wipes a quarter of it off.
        rail: Rail::Water { at_s: WATER_S, spread_s: 0.5, wiped: 0.25, wiping_j: 600.0 },
        control,
        preset_torque_nm,
        brake_from_s: BRAKE_S,
        control_lag_s: 0.25,
        // That of the dry stop from 2.76 m/s, for the same reason: the rig still turns when the water comes.
        hold_s: 26.0,
        accuracy,
        roughness: 1.0,
        end_s: 140.0,
        seed,
    }
}

/// What the water did.
#[derive(Clone, Copy, Debug, Default)]
struct Transition {
    /// Adhesion before the water (A).
    before: f64,
    /// Lowest adhesion within 3 s of it (B).
    lowest: f64,
    /// Largest slip after it (C).
    slip: f64,
    /// Time from the water to that slip, s.
    slip_after_s: f64,
    /// Time locked after the water, s.
    locked_s: f64,
    /// Adhesion 5 to 10 s after the water (D).
    after: f64,
    /// Torque before and lowest after, N m.
    torque_nm: (f64, f64),
    /// Share of the time from 3 s after the water, above 0.3 m/s, with slip below one and a half optimum slips.
    in_range: f64,
    /// Time from the water until "wet" was decided, s.
    decided_s: f64,
    /// Share of instants in which the rule of 0.2 kept the last decision.
    kept: f64,
    /// Share of windows that were heard right.
    heard_right: f64,
    /// Time from the brakes to the stop, s.
    stop_s: f64,
}

fn transition(setup: &Setup, run: &[Instant]) -> Transition {
    let p = &setup.parameters;
    let between = |from: f64, to: f64| {
        run.iter().filter(move |i| (WATER_S + from..WATER_S + to).contains(&i.sample.time_s))
    };
    let mean = |from: f64, to: f64, pick: &dyn Fn(&Instant) -> f64| {
        let values: Vec<f64> = between(from, to).map(pick).collect();
        values.iter().sum::<f64>() / values.len() as f64
    };
    let moving = |i: &&Instant| i.v_m_s > 0.3;
    let worst = between(0.0, 90.0).filter(moving).max_by(|a, b| a.slip_max().total_cmp(&b.slip_max()));
    let wet = ContactLaw::of(RailCondition::Wet);
    let late: Vec<&Instant> = between(3.0, 90.0).filter(moving).collect();
    let good =
        late.iter().filter(|i| i.slip_max() < 1.5 * optimum_slip(&wet, i.v_m_s, p.wheelset_load_n[0]).slip);
    let windows: Vec<bool> = run.iter().filter_map(|i| Some((i.heard? > 0.5) == (i.wetness < 0.5))).collect();
    Transition {
        before: mean(-3.0, 0.0, &|i| i.adhesion(p)),
        lowest: between(0.0, 3.0).map(|i| i.adhesion(p)).fold(1.0, f64::min),
        slip: worst.map_or(0.0, Instant::slip_max),
        slip_after_s: worst.map_or(0.0, |i| i.sample.time_s - WATER_S),
        locked_s: between(0.0, 90.0).filter(moving).filter(|i| i.slip_max() > 0.95).count() as f64 * 0.01,
        after: mean(5.0, 10.0, &|i| i.adhesion(p)),
        torque_nm: (
            mean(-3.0, 0.0, &|i| i.torque_nm),
            between(0.0, 3.0).map(|i| i.torque_nm).fold(1e9, f64::min),
        ),
        in_range: good.count() as f64 / late.len() as f64,
        decided_s: between(0.0, 90.0)
            .find(|i| i.decision.condition == RailCondition::Wet)
            .map_or(f64::NAN, |i| i.sample.time_s - WATER_S),
        kept: run.iter().filter(|i| i.decision.kept).count() as f64 / run.len() as f64,
        heard_right: windows.iter().filter(|right| **right).count() as f64 / windows.len() as f64,
        stop_s: run.last().map_or(0.0, |i| i.sample.time_s - BRAKE_S),
    }
}

fn all(control: Control, accuracy: f64) -> Vec<Transition> {
    let seeds: Vec<u64> = SEEDS.collect();
    seeds
        .into_par_iter()
        .map(|seed| {
            let setup = setup(control, accuracy, seed);
            transition(&setup, &simulate(&setup))
        })
        .collect()
}

fn mean(results: &[Transition], pick: impl Fn(&Transition) -> f64) -> f64 {
    let values: Vec<f64> = results.iter().map(pick).filter(|value| value.is_finite()).collect();
    values.iter().sum::<f64>() / values.len() as f64
}

/// Figs. 11 and 17.
pub fn transition_experiment(directory: &Path) -> Result<Report, ExperimentError> {
    let mut report = Report::default();
    let results = all(Control::Proposed, ACCURACY);
    proposed_rows(&mut report, &results);
    let load = BogieParameters::default().wheelset_load_n[0];
    let parameters = BogieParameters::default();
    let open = Control::Open { torque_nm: 0.34 * load * parameters.wheel_radius_m };
    for (name, control) in [("conventional", Control::CONVENTIONAL), ("no controller", open)] {
        let other = all(control, ACCURACY);
        let table = &mut report.table;
        table.push(
            name,
            "largest slip after the water",
            "",
            None,
            mean(&other, |r| r.slip),
            "mean over seeds",
        );
        table.push(name, "time locked after the water", "s", None, mean(&other, |r| r.locked_s), "");
        table.push(name, "time to stop", "s", None, mean(&other, |r| r.stop_s), "from the brakes on");
    }
    for accuracy in [0.7, 0.85, 1.0] {
        let other = all(Control::Proposed, accuracy);
        let group = format!("listener right in {accuracy}");
        let table = &mut report.table;
        table.push(
            &group,
            "largest slip after the water",
            "",
            None,
            mean(&other, |r| r.slip),
            "mean over seeds",
        );
        table.push(&group, "time locked after the water", "s", None, mean(&other, |r| r.locked_s), "");
        table.push(&group, "time to stop", "s", None, mean(&other, |r| r.stop_s), "from the brakes on");
        table.push(&group, "share of instants kept by the rule", "", None, mean(&other, |r| r.kept), "");
    }
    rule_rows(&mut report);
    let setup = setup(Control::Proposed, ACCURACY, SEEDS.start);
    let run = simulate(&setup);
    let path = directory.join("shrestha-transition.svg");
    write_svg(&path, 2, (620, 360), &control_panels(&setup, &run))?;
    report.files.push(path);
    let path = directory.join("shrestha-transition-heard.svg");
    write_svg(&path, 1, (900, 260), &heard_panels(&setup, &run))?;
    report.files.push(path);
    Ok(report)
}

fn proposed_rows(report: &mut Report, results: &[Transition]) {
    let group = "proposed controller";
    let count = results.len();
    let table = &mut report.table;
    let mut row = |what: &str, unit: &'static str, paper: Option<f64>, value: f64, remark: &str| {
        table.push(group, what, unit, paper, value, remark);
    };
    row(
        "adhesion before the water (A)",
        "",
        Some(0.4),
        mean(results, |r| r.before),
        "paper: its dry peak of Fig. 13 at 1.388 m/s; at this speed its Fig. 16 lies between 0.40 and 0.35",
    );
    row("lowest adhesion within 3 s (B)", "", None, mean(results, |r| r.lowest), "mean over seeds");
    row("largest slip (C)", "", None, mean(results, |r| r.slip), "mean over seeds");
    let worst = results.iter().map(|r| r.slip).fold(0.0, f64::max);
    row("largest slip of any seed", "", None, worst, &format!("{count} seeds"));
    row("time to the largest slip", "s", None, mean(results, |r| r.slip_after_s), "");
    row(
        "adhesion 5 to 10 s after (D)",
        "",
        Some(0.2),
        mean(results, |r| r.after),
        "paper: its wet peak of Fig. 15",
    );
    row("torque before", "N m", None, mean(results, |r| r.torque_nm.0), "a wheelset");
    row("lowest torque within 3 s", "N m", None, mean(results, |r| r.torque_nm.1), "a wheelset");
    let remark = "share of time from 3 s after, slip below 1.5 optimum slips";
    row("slip in the desired range", "", None, mean(results, |r| r.in_range), remark);
    row("time locked after the water", "s", Some(0.0), mean(results, |r| r.locked_s), "");
    row(
        "time until \"wet\" is decided",
        "s",
        Some(1.0),
        mean(results, |r| r.decided_s),
        "paper: one window of 1 s; a window heard wrong costs another",
    );
    row("share of windows heard right", "", None, mean(results, |r| r.heard_right), "asked for: 0.95");
    row("share of instants kept by the rule", "", None, mean(results, |r| r.kept), "difference above 0.2");
    let locked = results.iter().map(|r| r.locked_s).fold(0.0, f64::max);
    let in_range = mean(results, |r| r.in_range);
    let fall = mean(results, |r| r.after / r.before);
    for (name, figure, met) in [
        (
            "no wheelset locks for longer than 0.5 s in any seed",
            format!("{locked:.2} s at the most"),
            locked <= 0.5,
        ),
        (
            "the slip is kept in the desired range for 90 % of the time",
            format!("{in_range:.3}"),
            in_range >= 0.9,
        ),
        ("adhesion falls to about half", format!("to {fall:.2}"), (0.4..=0.7).contains(&fall)),
    ] {
        report.criteria.push(Criterion { name: name.into(), figure, met });
    }
}

/// What the rule of 0.2 can tell at all: the largest difference between the two curves.
fn rule_rows(report: &mut Report) {
    let load = BogieParameters::default().wheelset_load_n[0];
    let [dry, wet] = RailCondition::ALL.map(ContactLaw::of);
    for v in [0.69, 1.388, 2.9, 4.14] {
        let difference = |slip: f64| dry.adhesion(slip, v, load) - wet.adhesion(slip, v, load);
        let slips: Vec<f64> = (1..1000).map(|k| f64::from(k) * 1e-3).collect();
        let largest = slips.iter().map(|slip| difference(*slip)).fold(0.0, f64::max);
        let told = slips.iter().filter(|slip| difference(**slip) > RULE_DIFFERENCE).count() as f64 * 1e-3;
        let remark = format!("dry and wet curves are further apart over a slip range of {told:.3}");
        report.table.push(
            "rule of 0.2",
            format!("largest difference of the curves at {v} m/s"),
            "",
            Some(RULE_DIFFERENCE),
            largest,
            remark,
        );
    }
}

/// Fig. 17 (a) to (d).
fn control_panels(setup: &Setup, run: &[Instant]) -> Vec<Panel> {
    let p = &setup.parameters;
    let points =
        |pick: &dyn Fn(&Instant) -> f64| run.iter().map(|i| (i.sample.time_s, pick(i))).collect::<Vec<_>>();
    let rim = |i: &Instant| p.wheel_radius_m * i.truth.state.wheel_speed_rad_s[0];
    let (from, to) = (WATER_S - 4.0, WATER_S + 10.0);
    let panel = |title: &str, label: &'static str| Panel::new(title, "time, s", label);
    let top = p.wheelset_load_n[0] * p.wheel_radius_m * 0.5;
    let phases = [("after water", 1, 0.0, 0.0), ("recovery", 3, 0.0, 0.0), ("after recovery", 5, 0.0, 0.0)];
    let turn = (run.iter().filter(|i| (WATER_S..WATER_S + 5.0).contains(&i.sample.time_s)))
        .max_by(|a, b| a.slip_max().total_cmp(&b.slip_max()))
        .map_or(WATER_S + 1.0, |i| i.sample.time_s);
    let spans = [(WATER_S - 1.0, turn), (turn, turn + 1.0), (turn + 1.0, WATER_S + 10.0)];
    let mut path =
        Panel::new("(d) adhesion over slip, leading wheelset's slip", "slip", "adhesion").y(0.0, 0.45);
    for ((name, colour, ..), (begin, end)) in phases.into_iter().zip(spans) {
        let inside = run.iter().filter(|i| (begin..end).contains(&i.sample.time_s));
        let points = inside.map(|i| (-i.estimate.creepage[0], -i.estimate.mu_w)).collect();
        path = path.with(Series::new(name, colour, Mark::Line, points));
    }
    vec![
        panel("Fig. 17 (a) speeds: wheelset (blue) and rollers (black)", "m/s")
            .x(0.0, run.last().map_or(to, |last| last.sample.time_s))
            .with(Series::new("wheelset", 1, Mark::Line, points(&rim)))
            .with(Series::new("rollers", 0, Mark::Line, points(&|i| i.v_m_s))),
        panel("(b) slip (blue) and brake effort over its largest (orange)", "slip; effort")
            .x(from, to)
            .y(-0.05, 1.0)
            .with(Series::new("effort", 5, Mark::Line, points(&|i| i.torque_nm / top)))
            .with(Series::new("slip", 1, Mark::Line, points(&|i| i.estimate.slip().unwrap_or(f64::NAN)))),
        panel("(c) speeds around the water", "m/s")
            .x(from, to)
            .with(Series::new("wheelset", 1, Mark::Line, points(&rim)))
            .with(Series::new("rollers", 0, Mark::Bold, points(&|i| i.v_m_s))),
        path,
    ]
}

/// Fig. 11 and the decision.
fn heard_panels(setup: &Setup, run: &[Instant]) -> Vec<Panel> {
    let steps = |value: &dyn Fn(f64) -> f64| {
        let mut last = f64::NAN;
        let mut points = Vec::new();
        for instant in run {
            if let Some(heard) = instant.heard {
                points.push((instant.sample.time_s - 1.0, value(heard)));
                last = value(heard);
            }
            if last.is_finite() && instant.heard.is_some() {
                points.push((instant.sample.time_s, last));
            }
        }
        points
    };
    let end = run.last().map_or(1.0, |last| last.sample.time_s);
    let condition = |i: &Instant| f64::from(u8::from(i.decision.condition == RailCondition::Wet));
    vec![
        Panel::new(
            "Fig. 11: output for dry and wet, windows of 1 s (simulated listener)",
            "time, s",
            "probability",
        )
        .x(0.0, end)
        .y(-0.05, 1.05)
        .with(Series::new("dry", 5, Mark::Line, steps(&|p| p)))
        .with(Series::new("wet", 1, Mark::Line, steps(&|p| 1.0 - p))),
        Panel::new("Condition decided (thick) and water in truth (thin)", "time, s", "0 dry, 1 wet")
            .x(0.0, end)
            .y(-0.05, 1.05)
            .with(Series::new(
                "truth",
                0,
                Mark::Line,
                run.iter().map(|i| (i.sample.time_s, i.wetness)).collect(),
            ))
            .with(Series::new(
                "decided",
                2,
                Mark::Bold,
                run.iter().map(|i| (i.sample.time_s, condition(i))).collect(),
            )),
        Panel::new("Adhesion: decided, and in truth", "time, s", "adhesion")
            .x(0.0, end)
            .y(-0.02, 0.5)
            .with(Series::new(
                "decided",
                2,
                Mark::Line,
                run.iter().map(|i| (i.sample.time_s, i.decision.adhesion)).collect(),
            ))
            .with(Series::new(
                "truth",
                0,
                Mark::Line,
                run.iter().map(|i| (i.sample.time_s, i.adhesion(&setup.parameters))).collect(),
            )),
    ]
}
