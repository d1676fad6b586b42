//! The report in German: nothing of it stays English, neither on the pages nor in what the library can say of itself.

use super::law_cases::{CreepTruth, Layout, PLAIN, Simulated, brake, creep};
use super::{bench, keep, later_report, samples};
use railgrip_diagnosis::html::{compare, render};
use railgrip_diagnosis::words::compare::Named;
use railgrip_diagnosis::words::format::plain;
use railgrip_diagnosis::words::{headline, parameters, summary};
use railgrip_vehicle::effects;
use railgrip_words::{Language, german, speak};
use std::collections::BTreeSet;

/// Words that no German text has.
const ENGLISH: [&str; 24] = [
    "the",
    "and",
    "of",
    "with",
    "not",
    "since",
    "until",
    "wheelset",
    "wheelsets",
    "friction",
    "braking",
    "speed",
    "model",
    "which",
    "is",
    "are",
    "that",
    "by",
    "from",
    "to",
    "what",
    "gap",
    "runs",
    "chance",
];
/// Texts that are the same in both languages: names, symbols, and words that German has, too.
const SAME: [&str; 12] = [
    "nominal",
    "Nominal",
    "Parameter",
    "Version",
    "Format",
    "p",
    "in report.json: effects",
    "in report.json: unknown",
    "in report.json: none",
    "Position",
    "railgrip 0.1.0",
    "k A",
];

fn in_german<T>(render: impl FnOnce() -> T) -> T {
    speak(Language::German, render)
}

/// What is read or heard on a page: text between tags and the attributes that hold words; without style and code.
fn texts(page: &str) -> BTreeSet<String> {
    let body = page.split_once("<title>").unwrap().1;
    let mut found = BTreeSet::new();
    let mut inside_code = false;
    let mut inside_style = false;
    for piece in body.split('<').skip(1) {
        let (tag, text) = piece.split_once('>').unwrap_or((piece, ""));
        match tag.split(' ').next().unwrap_or_default() {
            "code" => inside_code = true,
            "/code" => inside_code = false,
            "style" => inside_style = true,
            "/style" => inside_style = false,
            _ => {}
        }
        if !inside_code && !inside_style {
            found.insert(text.trim().to_owned());
        }
        for name in [" aria-label=\"", " title=\"", " data-label=\""] {
            let value = tag.split_once(name).and_then(|(_, rest)| rest.split_once('"'));
            found.extend(value.map(|(value, _)| value.trim().to_owned()));
        }
    }
    found.retain(|text| text.chars().any(char::is_alphabetic));
    found
}

/// Fails with what is left of English on a German page. `names` come from files and stay.
fn no_english(name: &str, render: impl Fn() -> String, names: &[&str]) {
    let page = in_german(&render);
    keep(&format!("{name}_de"), &page);
    assert!(page.contains("lang=\"de\""));
    let (english, german) = (texts(&render()), texts(&page));
    assert!(german.len() > 30, "{} texts", german.len());
    let of_file =
        |text: &String| SAME.contains(&text.as_str()) || names.iter().any(|name| text.starts_with(name));
    // Formulas and units are letters without a word of four.
    let word = |text: &String| text.split(|c: char| !c.is_alphabetic()).any(|word| word.chars().count() > 3);
    let same: Vec<&String> =
        english.intersection(&german).filter(|text| word(text) && !of_file(text) && !formula(text)).collect();
    assert_eq!(same, Vec::<&String>::new(), "{name}: the same in both languages");
    let left: Vec<&String> = german
        .iter()
        .filter(|text| !of_file(text))
        .filter(|text| text.split(|c: char| !c.is_alphabetic()).any(|word| ENGLISH.contains(&word)))
        .collect();
    assert_eq!(left, Vec::<&String>::new(), "{name}: English words are left");
}

/// Laws are written alike in both languages.
fn formula(text: &str) -> bool {
    text.contains(" = ") || text.contains("exp(")
}

#[test]
fn no_word_of_a_report_is_left_in_english() {
    let wagon = (samples::wagon_report(), samples::wagon_detail());
    let runs = ["dry_stop", "wet_stop", "run", "case00", "bench", "may", "june", "holdout"];
    no_english("wagon", || render(&wagon.0, &wagon.1), &runs);
    let fade = brake(11, Layout::Sweeps, 0.01, true, &|v, t, _| {
        (1.0 + 0.25 * (-v / 6.0).exp()) * (1.0 - 0.35 / (1.0 + (-(t - 260.0) / 25.0).exp()))
    });
    let truth = CreepTruth { level: &|w, v, _| (0.4 + 0.6 * (-0.6 * w).exp()) * (1.0 - 0.004 * v), ..PLAIN };
    let falling = creep(12, Layout::Grid, 0.02, false, truth);
    let none = creep(13, Layout::Scattered, 0.02, true, PLAIN);
    let benches: [(&str, &Simulated, &[&str]); 4] = [
        ("bench_brake", &fade, &[]),
        ("bench_creep", &falling, &[]),
        ("bench_unknown", &falling, &["falling_friction"]),
        ("bench_none", &none, &[]),
    ];
    for (name, case, without) in benches {
        let outcome = bench(case, without);
        let case = outcome.detail.case.clone();
        let names: Vec<&str> = runs.iter().copied().chain([case.as_str()]).collect();
        no_english(name, || render(&outcome.report, &outcome.detail), &names);
        let text = in_german(|| summary(&outcome.report, &outcome.detail));
        assert!(!text.contains(" the ") && text.contains("Wie sicher: "), "{text}");
    }
    let later = later_report();
    let (may, june) = (Named { name: "may", report: &wagon.0 }, Named { name: "june", report: &later });
    no_english("compared", || compare::render(may, june), &runs);
}

#[test]
fn figures_are_written_as_german_does() {
    let report = samples::wagon_report();
    assert_eq!(
        in_german(|| headline(&report)),
        "Beläge verlieren 8\u{a0}% ihrer Reibung je 100 K (7–9), sobald die Scheibe wärmer als etwa 20 °C ist: \
         Abweichung auf nur vorhergesagten Fahrten 8,34 → 3,31."
    );
}

/// Whatever the catalogue can name, ask for or measure.
#[test]
fn every_effect_is_told_in_german() {
    let mut unknown: Vec<String> = Vec::new();
    let mut ask = |text: &str| {
        if german(text).is_none() {
            unknown.push(text.to_owned());
        }
    };
    for (spec, _) in effects::all() {
        ask(&plain(spec.id));
        ask(&plain(spec.term.name()));
        ask(spec.separated_by);
        spec.parameters.iter().for_each(|parameter| ask(&parameters::name(parameter.name)));
        let words = ["times", "mean", "beyond", "else", "within", "always"];
        if spec.equation.split(' ').any(|part| words.contains(&part.trim_matches(','))) {
            ask(spec.equation);
        }
    }
    assert_eq!(unknown, Vec::<String>::new(), "without German");
}
