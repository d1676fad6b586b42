//! The HTML report: self-contained, complete, and readable without colours. The pages are kept under the target folder
//! (`tmp/*.html`) for looking at.

#![allow(clippy::unwrap_used, clippy::print_stdout)]

mod german;
#[path = "../law_cases/mod.rs"]
mod law_cases;
mod samples;

use law_cases::{CreepTruth, Layout, PLAIN, brake, creep};
use railgrip_diagnosis::answer::schema::*;
use railgrip_diagnosis::answer::supplement::Detail;
use railgrip_diagnosis::html::{compare, render};
use railgrip_diagnosis::law_bench::{Options, Outcome, diagnose};
use railgrip_diagnosis::words::compare::{Named, changes};
use railgrip_diagnosis::words::{headline, summary};
use samples::{wagon_detail, wagon_report};
use std::path::Path;

fn keep(name: &str, page: &str) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    std::fs::write(folder.join(format!("{name}.html")), page).unwrap();
    println!("{}/{name}.html: {} kB", folder.display(), page.len() / 1024);
}

fn check_self_contained(page: &str) {
    for forbidden in ["http:", "https:", "<script", "<link", "<img", "@import", "src=", "NaN", "inf\""] {
        assert!(!page.contains(forbidden), "{forbidden}");
    }
    for needed in ["<!DOCTYPE html>", "lang=\"en\"", "prefers-color-scheme: dark", "@media print"] {
        assert!(page.contains(needed), "{needed}");
    }
    for unclear in ["d=\"\"", "window 0", "nuisance", "simulated cases"] {
        assert!(!page.contains(unclear), "{unclear}");
    }
    for svg in page.split("<svg").skip(1) {
        let head = svg.split('>').next().unwrap();
        assert!(
            head.contains("aria-label=") || head.contains("aria-hidden"),
            "a figure without words: {head}"
        );
    }
    assert!(page.len() < 1_500_000, "{} bytes", page.len());
}

fn bench(case: &law_cases::Simulated, without: &[&str]) -> Outcome {
    let folder = tempfile::tempdir().unwrap();
    case.write(folder.path());
    let without = without.iter().map(|id| (*id).to_owned()).collect();
    let command = "railgrip gap diagnose CASE --json report.json --html report.html".to_owned();
    diagnose(folder.path(), &Options { without, seed: 1, command, version: "railgrip 0.1.0".to_owned() })
        .unwrap()
}

#[test]
fn a_bench_with_an_effect() {
    let case = brake(11, Layout::Sweeps, 0.01, true, &|v, t, _| {
        (1.0 + 0.25 * (-v / 6.0).exp()) * (1.0 - 0.35 / (1.0 + (-(t - 260.0) / 25.0).exp()))
    });
    let outcome = bench(&case, &[]);
    let page = render(&outcome.report, &outcome.detail);
    keep("bench_brake", &page);
    check_self_contained(&page);
    for id in [
        "brake_fade",
        "brake_friction_speed",
        "How sure",
        "What to do",
        "Gap by operating range",
        "run0",
        "Seed",
        "Why this answer",
    ] {
        assert!(page.contains(id), "{id}");
    }
}

#[test]
fn a_creep_bench_whose_effect_is_unknown() {
    let truth = CreepTruth { level: &|w, v, _| (0.4 + 0.6 * (-0.6 * w).exp()) * (1.0 - 0.004 * v), ..PLAIN };
    let case = creep(12, Layout::Grid, 0.02, false, truth);
    let known = bench(&case, &[]);
    keep("bench_creep", &render(&known.report, &known.detail));
    let outcome = bench(&case, &["falling_friction"]);
    let page = render(&outcome.report, &outcome.detail);
    keep("bench_unknown", &page);
    check_self_contained(&page);
    assert_eq!(outcome.report.verdict, Verdict::Unknown, "{:?}", outcome.report.effects);
    assert!(page.contains("What is missing") && page.contains("Next run: "));
}

#[test]
fn a_bench_without_an_effect() {
    let outcome = bench(&creep(13, Layout::Scattered, 0.02, true, PLAIN), &[]);
    let page = render(&outcome.report, &outcome.detail);
    keep("bench_none", &page);
    check_self_contained(&page);
    assert!(page.contains("Nothing is missing"));
}

#[test]
fn a_wagon_case_with_traces() {
    let (report, detail) = (wagon_report(), wagon_detail());
    let page = render(&report, &detail);
    keep("wagon", &page);
    check_self_contained(&page);
    assert_eq!(
        headline(&report),
        "Pads lose 8\u{a0}% of their friction per 100 K (7–9) once the disc is above about 20 °C: holdout gap 8.34 → 3.31."
    );
    for needed in [
        "front wheelset speed",
        "The worst window",
        "95 % interval 55 % to 66 %",
        "disc temperature",
        "front wheelset locks at 24.1 s of wet_stop.wet",
        "The seconds 20 to 30 of run wet_stop.wet",
        "disc above 140\u{a0}°C",
        "This explains the gap.",
        "<th scope=\"row\">tolerances alone</th>",
    ] {
        assert!(page.contains(needed), "{needed}");
    }
}

#[test]
fn text_from_files_cannot_become_markup() {
    let detail = Detail { case: "<script>alert(1)</script>".to_owned(), ..wagon_detail() };
    assert!(!render(&wagon_report(), &detail).contains("<script"));
}

#[test]
fn the_summary_says_the_same_in_markdown() {
    let text = summary(&wagon_report(), &wagon_detail());
    println!("{text}");
    for needed in [
        "# case00: effects",
        "| holdout | 19.0 | 8.34 | 3.31 |",
        "Decided by the rule `effects_explain_gap`: The effects explain more than chance, and nothing that they leave asks for another cause.",
        "| tolerances alone | 9.28 | | | |",
        "`brake_fade` (confidence 0.94",
        "loss of friction 8\u{a0}% per 100 K (7–9)",
        "How sure: Very likely that brake fade is at work",
        "What to do:\n1. ",
    ] {
        assert!(text.contains(needed), "{needed}");
    }
}

#[test]
fn the_report_reads_back_as_it_was_written() {
    let report = wagon_report();
    let json = serde_json::to_string(&report).unwrap();
    assert!(json.starts_with(
        "{\"schema\":\"railgrip.gap.report/1\",\"verdict\":\"effects\",\"rule\":\"effects_explain_gap\",\"where\":{\"term\":\"brake_friction\""
    ));
    assert_eq!(serde_json::from_str::<Report>(&json).unwrap(), report);
}

/// The report of a later day: the pads fade more, and something is missing beside them.
fn later_report() -> Report {
    let mut report = wagon_report();
    report.verdict = Verdict::EffectsAndUnknown;
    let moved = ParameterEstimate::new(1.2e-3, [1.1e-3, 1.3e-3]);
    report.effects[0].parameters.insert("alpha_per_k".to_owned(), moved);
    report.gap.holdout.extended = 4.4;
    report.unexplained =
        Some(Unexplained { gap: 4.0, term: "adhesion".to_owned(), terms: Vec::new(), curve: Vec::new() });
    report
}

#[test]
fn two_reports_are_compared_in_words_and_on_a_page() {
    let (may, june, none) = (wagon_report(), later_report(), {
        let report = wagon_report();
        Report { verdict: Verdict::None, effects: Vec::new(), ..report }
    });
    let [may, june, none] =
        [("may", &may), ("june", &june), ("new pads", &none)].map(|(name, report)| Named { name, report });
    let table: [(Named<'_>, Named<'_>, &[&str]); 4] = [
        (
            may,
            june,
            &[
                "Brake fade has changed: loss of friction from 8\u{a0}% per 100 K (7–9) to 12\u{a0}% per 100 K (11–13).",
                "Something unknown is new, in the adhesion between wheel and rail.",
            ],
        ),
        (
            may,
            may,
            &[
                "Brake fade is as before, within the intervals: pads lose 8\u{a0}% of their friction per 100 K (7–9) once the disc is above about 20 °C.",
            ],
        ),
        (
            june,
            none,
            &[
                "Brake fade is gone; before, pads lose 12\u{a0}% of their friction per 100 K (11–13) once the disc is above about 20 °C.",
                "What was missing in the adhesion between wheel and rail is no longer.",
            ],
        ),
        (none, none, &["Neither report finds anything missing: tolerances and noise explain both."]),
    ];
    for (first, second, said) in table {
        assert_eq!(changes(first, second), said);
    }
    let page = compare::render(may, june);
    keep("compared", &page);
    check_self_contained(&page);
    for needed in ["may → june", "<b>yes</b>", "8.34", "4.40"] {
        assert!(page.contains(needed), "{needed}");
    }
}
