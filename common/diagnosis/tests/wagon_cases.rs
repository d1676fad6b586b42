//! The diagnosis on labelled cases beside the project.
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use railgrip_diagnosis::answer::schema::{Report, Verdict};
use railgrip_diagnosis::data::case::Case;
use railgrip_diagnosis::data::load;
use railgrip_diagnosis::wagon::{Options, diagnose};
use railgrip_requirements::LABELLED_CASES;

railgrip_requirements::tests! {
    fade_is_found_whatever_the_number_of_threads: [LABELLED_CASES],
    a_case_of_nuisances_alone_raises_no_alarm: [LABELLED_CASES],
}

fn open_case(name: &str) -> Case {
    let folder = LABELLED_CASES.path().join(name);
    let text = std::fs::read_to_string(folder.join("vehicle.toml")).expect("vehicle.toml");
    let mut case = load::load(&folder, toml::from_str(&text).expect("vehicle")).expect("case");
    // Three runs keep the test short.
    case.fit.truncate(3);
    // And the third holdout run is on wet rail, whose adhesion these three do not show.
    case.holdout.truncate(2);
    case
}

fn report(case: &Case, threads: usize) -> Report {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("pool");
    let options = Options { case: "open".into(), seed: 1, ..Options::default() };
    let outcome = pool.install(|| diagnose(case, &options, &|_| ()));
    Report { seconds: 0.0, ..outcome.report }
}

fn fade_is_found_whatever_the_number_of_threads() {
    let case = open_case("case00");
    let (one, two) = (report(&case, 1), report(&case, 2));
    println!("{:?} {:?}", one.verdict, one.effects);
    assert_eq!(one.effects[0].id, "brake_fade");
    assert!(one.gap.holdout.reduction > 0.5, "{:?}", one.gap.holdout);
    assert_eq!(one, two);
}

fn a_case_of_nuisances_alone_raises_no_alarm() {
    let case = open_case("case05");
    let report = report(&case, 2);
    println!("{:?} {:?}", report.verdict, report.candidates.first());
    assert_eq!(report.verdict, Verdict::None);
}
