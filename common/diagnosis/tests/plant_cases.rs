//! Diagnoses of cases that the truth plant makes here: a wagon by other equations than the diagnosis knows, so that these tests
//! stand in a clone of the project alone. Each case is short: three runs to fit on and two to predict.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use railgrip_diagnosis::answer::schema::{PosteriorSet, Report, Verdict};
use railgrip_diagnosis::data::case::Case;
use railgrip_diagnosis::data::load;
use railgrip_diagnosis::plan::{Limits, Plan};
use railgrip_diagnosis::wagon::{Options, plan, settle};
use railgrip_truth_plant::departure::Departures;
use railgrip_truth_plant::departures::Kind;
use railgrip_truth_plant::plant::Plant;
use railgrip_truth_plant::random::Stream;
use railgrip_truth_plant::sheet::Sheet;
use railgrip_truth_plant::wagon::{Nuisances, TrueWagon};
use railgrip_truth_plant::{files, programme};
use railgrip_vehicle::VehicleParameters;

/// Runs of the programme that a short case keeps, by name.
const KEPT: [&str; 4] = ["dry_steps", "dry_stop", "wet_stop", "dry_partial"];

/// A run that tests what the others leave open.
const TEST: &str = "wet_steps";

/// Diagnoses a short case of the plant with the departure `id` at this strength.
fn report(seed: u64, departure: Option<(&str, f64)>, without: &[&str]) -> Report {
    planned(seed, departure, without).0
}

/// A case of the plant and a run of its programme that the case lacks.
fn case_and_test(seed: u64, departure: Option<(&str, f64)>) -> (Case, Case) {
    let sheet = Sheet::draw(&mut Stream::new(seed, "sheet", 0), false, false);
    let nuisances = Nuisances::draw(&mut Stream::new(seed, "nuisances", 0));
    let wagon = TrueWagon::new(&sheet, &nuisances);
    let departures = departure.map(|(id, strength)| {
        let kind = Kind::of(id).expect("a departure of the plant");
        kind.draw(strength, &mut Stream::new(seed, id, 0), &sheet).0
    });
    let mut plant = Plant::new(&sheet, &wagon, Departures(departures.into_iter().collect()), seed);
    let orders = programme::orders(&sheet, seed);
    let mut drive = |is: &dyn Fn(&str) -> bool| -> Vec<_> {
        let chosen = orders.iter().zip(0..).filter(|(order, _)| is(order.name));
        chosen.map(|(order, index)| plant.drive(order, index)).collect()
    };
    let runs = drive(&|name| KEPT.contains(&name));
    let test = drive(&|name| name == TEST);

    let [folder, beside] = [(); 2].map(|()| tempfile::tempdir().expect("folder"));
    files::write_case(folder.path(), &sheet.to_toml(), &runs).expect("case");
    files::write_case(beside.path(), &sheet.to_toml(), &test).expect("test");
    let vehicle: VehicleParameters = toml::from_str(&sheet.to_toml()).expect("vehicle");
    let case = load::load(folder.path(), vehicle.clone()).expect("runs");
    (case, load::load_test(&beside.path().join("fit"), vehicle).expect("a test"))
}

/// The same, with the run that would be next.
fn planned(seed: u64, departure: Option<(&str, f64)>, without: &[&str]) -> (Report, Option<Plan>) {
    let (case, _) = case_and_test(seed, departure);
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

/// A run that the diagnosis has not seen: the model of the right cause predicts it best, and the cause becomes likelier. The same run of
/// a wagon without any leaves none the answer.
#[test]
fn a_test_run_speaks_for_the_cause_and_for_no_other() {
    let settled = |departure: Option<(&str, f64)>| {
        let (case, test) = case_and_test(1, departure);
        let options = Options { case: "plant".into(), seed: 1, ..Options::default() };
        let (_, settled) = settle(&case, &test, &options, &|_| ());
        let settled = settled.expect("an answer");
        println!("{departure:?}: {}", settled.words);
        settled
    };
    let p = |sets: &[PosteriorSet], is: &dyn Fn(&PosteriorSet) -> bool| -> f64 {
        sets.iter().filter(|set| is(set)).map(|set| set.p).sum()
    };
    let late = settled(Some(("brake_lag", 1.0)));
    let holds = |set: &PosteriorSet| set.effects.iter().any(|id| id == "brake_lag") && !set.unknown;
    assert_eq!((late.verdict, late.effects[0].id.as_str()), (Verdict::Effects, "brake_lag"));
    assert!(p(&late.posterior, &holds) > p(&late.before, &holds));
    let gap = |effects: &[&str]| {
        let model = late.test.models.iter().position(|model| model.effects == effects).expect("a model");
        late.gaps[model]
    };
    assert!(gap(&["brake_lag"]) < 0.8 * gap(&[]), "{:?}", late.gaps);

    let sound = settled(None);
    let nothing = |set: &PosteriorSet| set.effects.is_empty() && !set.unknown;
    assert_eq!((sound.verdict, sound.effects.len()), (Verdict::None, 0));
    assert!(p(&sound.posterior, &nothing) > p(&sound.before, &nothing) - 0.02);
}
