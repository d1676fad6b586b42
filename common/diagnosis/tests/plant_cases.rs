//! Diagnoses of cases that the truth plant makes here: a wagon by other equations than the diagnosis knows, so that these tests
//! stand in a clone of the project alone. Each case is short: three runs to fit on and two to predict.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use railgrip_diagnosis::answer::schema::{Report, Verdict};
use railgrip_diagnosis::data::load;
use railgrip_diagnosis::plan::{Limits, Plan};
use railgrip_diagnosis::wagon::{Options, plan};
use railgrip_truth_plant::departure::Departures;
use railgrip_truth_plant::departures::Kind;
use railgrip_truth_plant::plant::Plant;
use railgrip_truth_plant::random::Stream;
use railgrip_truth_plant::sheet::Sheet;
use railgrip_truth_plant::wagon::{Nuisances, TrueWagon};
use railgrip_truth_plant::{files, programme};

/// Runs of the programme that a short case keeps, by name.
const KEPT: [&str; 4] = ["dry_steps", "dry_stop", "wet_stop", "dry_partial"];

/// Diagnoses a short case of the plant with the departure `id` at this strength.
fn report(seed: u64, departure: Option<(&str, f64)>, without: &[&str]) -> Report {
    planned(seed, departure, without).0
}

/// The same, with the run that would be next.
fn planned(seed: u64, departure: Option<(&str, f64)>, without: &[&str]) -> (Report, Option<Plan>) {
    let sheet = Sheet::draw(&mut Stream::new(seed, "sheet", 0), false, false);
    let nuisances = Nuisances::draw(&mut Stream::new(seed, "nuisances", 0));
    let wagon = TrueWagon::new(&sheet, &nuisances);
    let departures = departure.map(|(id, strength)| {
        let kind = Kind::of(id).expect("a departure of the plant");
        kind.draw(strength, &mut Stream::new(seed, id, 0), &sheet).0
    });
    let mut plant = Plant::new(&sheet, &wagon, Departures(departures.into_iter().collect()), seed);
    let orders = programme::orders(&sheet, seed);
    let kept = orders.iter().zip(0..).filter(|(order, _)| KEPT.contains(&order.name));
    let runs: Vec<_> = kept.map(|(order, index)| plant.drive(order, index)).collect();

    let folder = tempfile::tempdir().expect("folder");
    files::write_case(folder.path(), &sheet.to_toml(), &runs).expect("case");
    let vehicle = toml::from_str(&sheet.to_toml()).expect("vehicle");
    let case = load::load(folder.path(), vehicle).expect("runs");
    let without = without.iter().map(|id| (*id).to_owned()).collect();
    let options = Options { case: "plant".into(), without, seed: 1, ..Options::default() };
    let limits = Limits { v_max_m_s: None, rails: Vec::new(), length_s: 60.0 };
    let (outcome, plan) = plan(&case, &options, &limits, &|_| ());
    let report = outcome.report;
    let effects: Vec<_> = report.effects.iter().map(|effect| (&effect.id, effect.confidence)).collect();
    let gap = &report.gap.holdout;
    println!(
        "{departure:?} without {:?}: {:?} by {:?}, {effects:?}, term {:?}; holdout {:.2}, {:.2}, {:.2}; {:.1} s",
        options.without,
        report.verdict,
        report.rule,
        report.location.term,
        gap.nominal,
        gap.calibrated,
        gap.extended,
        report.seconds
    );
    (report, plan)
}

#[test]
fn a_wagon_with_tolerances_alone_has_no_effect() {
    let report = report(1, None, &[]);
    assert_eq!(report.verdict, Verdict::None);
    assert_eq!(report.rule, "nothing_beyond_chance");
    assert!(report.effects.is_empty() && report.unexplained.is_none() && report.location.term.is_none());
}

#[test]
fn a_late_brake_is_named_and_the_gap_closes() {
    let (report, plan) = planned(1, Some(("brake_lag", 1.0)), &[]);
    assert_eq!(report.verdict, Verdict::Effects);
    assert_eq!(report.rule, "effects_explain_gap");
    let named: Vec<&str> = report.effects.iter().map(|effect| effect.id.as_str()).collect();
    assert_eq!(named, ["brake_lag"]);
    assert_eq!(report.location.term.as_deref(), Some("brake_actuation"));
    // The same wagon without the effect has a gap of 1.9 on these runs: nearly all that can be closed is closed.
    let gap = &report.gap.holdout;
    assert!(gap.calibrated > 4.0 && gap.extended < 2.2, "{gap:?}");
    assert!(gap.by_signal.values().all(|signal| signal.reduction() > 0.3), "{gap:?}");
    // The next run brakes: one that coasts tells nothing of a brake. What rails gave each run of the recordings once was asked of it.
    let plan = plan.expect("a finding has rivals");
    println!("{plan:?}");
    assert_eq!(plan.separates[0], ["brake_lag"]);
    assert!(plan.separates.len() >= 2 && plan.run.phases.iter().any(|phase| phase.brake_demand > 0.0));
    assert!(plan.entropy_after <= plan.entropy_after_random && plan.entropy_after < plan.entropy_before);
}

#[test]
fn a_fading_brake_that_the_library_lacks_is_unknown_in_the_right_term() {
    let report = report(1, Some(("brake_fade", 1.0)), &["brake_fade"]);
    assert_eq!(report.verdict, Verdict::Unknown);
    assert_eq!(report.location.term.as_deref(), Some("brake_friction"));
    assert!(report.effects.is_empty());
    let rest = report.unexplained.expect("what is missing");
    assert!(rest.term == "brake_friction" && !rest.curve.is_empty(), "{rest:?}");
    assert_eq!(report.gap.holdout.extended, report.gap.holdout.calibrated);
}
