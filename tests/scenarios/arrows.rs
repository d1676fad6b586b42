//! What may depend on what. Reads `cargo metadata`; a dependency that the table does not allow fails the test.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::collections::BTreeMap;
use std::process::Command;

use serde_json::Value;

/// A row of the table.
type Row = (&'static str, &'static [&'static str]);

/// Member → the members that it may use. Development dependencies count too, but for [`FOR_TESTS`].
const ALLOWED: &[Row] = &[
    ("railgrip-messages", &[]),
    ("railgrip-vehicle", &[]),
    ("railgrip-recording", &[]),
    ("railgrip-fieldbus", &["railgrip-recording"]),
    ("railgrip-indicators", &["railgrip-messages"]),
    ("railgrip-causes", &[]),
    ("railgrip-words", &[]),
    ("railgrip-acoustics", &[]),
    ("railgrip-classifier", &["railgrip-acoustics"]),
    ("railgrip-history", &[]),
    ("railgrip-mqtt", &[]),
    ("railgrip-truth-plant", &["railgrip-recording"]),
    ("railgrip-simulation", &["railgrip-vehicle", "railgrip-recording"]),
    ("railgrip-filter", &["railgrip-vehicle"]),
    ("railgrip-diagnosis", &["railgrip-filter", "railgrip-vehicle", "railgrip-recording", "railgrip-words"]),
    (
        "railgrip-settings",
        &[
            "railgrip-vehicle",
            "railgrip-fieldbus",
            "railgrip-filter",
            "railgrip-simulation",
            "railgrip-indicators",
            "railgrip-recording",
            "railgrip-acoustics",
        ],
    ),
    (
        "railgrip-experiments",
        &[
            "railgrip-vehicle",
            "railgrip-filter",
            "railgrip-simulation",
            "railgrip-acoustics",
            "railgrip-classifier",
            "railgrip-recording",
        ],
    ),
    ("railgrip-bus", &["railgrip-messages", "railgrip-settings"]),
];

/// Services use what is common, never each other.
const SERVICES: &[&str] =
    &["railgrip-ingest", "railgrip-estimator", "railgrip-health", "railgrip-judge", "railgrip-listener"];
/// Members that may use everything.
const EVERYTHING: &[&str] = &["railgrip-cli", "railgrip-tests"];
/// Members that know no network, no channel and no runtime, directly or not.
const PURE: &[&str] = &[
    "railgrip-vehicle",
    "railgrip-simulation",
    "railgrip-filter",
    "railgrip-indicators",
    "railgrip-causes",
    "railgrip-words",
    "railgrip-diagnosis",
    "railgrip-truth-plant",
    "railgrip-recording",
    "railgrip-fieldbus",
    "railgrip-acoustics",
    "railgrip-classifier",
    "railgrip-experiments",
];
/// What a pure member must not use.
const IMPURE: &[&str] = &["tokio", "axum", "iceoryx2", "railgrip-bus"];
/// What says what a test needs: any member's tests may use it, nothing else.
const TEST_HELPER: &str = "railgrip-requirements";
/// What the tests of a member may use beyond that, and its code must not: the plant that judges the diagnosis makes cases for
/// its tests.
const FOR_TESTS: &[(&str, &str)] = &[("railgrip-diagnosis", "railgrip-truth-plant")];
/// The only member that may use the iceoryx2 runtime.
const TRANSPORT: &str = "railgrip-bus";

type Arrows = BTreeMap<String, Vec<String>>;

fn arrows_of_the_workspace() -> Arrows {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned());
    let output = Command::new(cargo)
        .args(["metadata", "--format-version", "1", "--no-deps", "--manifest-path"])
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/../Cargo.toml"))
        .output()
        .expect("cargo metadata");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let packages = metadata["packages"].as_array().expect("packages");
    let name = |value: &Value| value["name"].as_str().expect("name").to_owned();
    packages
        .iter()
        .map(|package| {
            let member = name(package);
            let for_tests = |used: &Value| {
                let helper = name(used);
                let exempt = FOR_TESTS.contains(&(member.as_str(), helper.as_str()));
                used["kind"] == "dev" && (helper == TEST_HELPER || exempt)
            };
            let uses = package["dependencies"].as_array().expect("dependencies").iter();
            let counted = uses.filter(|used| !for_tests(used)).map(name).collect();
            (member, counted)
        })
        .collect()
}

/// Every forbidden arrow, in words.
fn violations(arrows: &Arrows) -> Vec<String> {
    let mut found = Vec::new();
    for (member, uses) in arrows {
        for used in uses {
            let internal = arrows.contains_key(used);
            if (internal && !allowed(member, used)) || (PURE.contains(&member.as_str()) && is_impure(used)) {
                found.push(format!("{member} must not use {used}"));
            }
            if used == "iceoryx2" && member != TRANSPORT && !EVERYTHING.contains(&member.as_str()) {
                found.push(format!("{member} must not use iceoryx2, only {TRANSPORT} may"));
            }
        }
        if !known(member) {
            found.push(format!("{member} is not in the table of arrows"));
        }
    }
    found
}

fn known(member: &str) -> bool {
    ALLOWED.iter().any(|(name, _)| *name == member)
        || SERVICES.contains(&member)
        || EVERYTHING.contains(&member)
        || member == TEST_HELPER
}

fn is_impure(used: &str) -> bool {
    IMPURE.contains(&used)
}

fn allowed(member: &str, used: &str) -> bool {
    if EVERYTHING.contains(&member) {
        return used != "railgrip-tests";
    }
    if SERVICES.contains(&member) {
        return ALLOWED.iter().any(|(name, _)| *name == used);
    }
    ALLOWED.iter().any(|(name, may_use)| *name == member && may_use.contains(&used))
}

#[test]
fn every_arrow_points_the_allowed_way() {
    let arrows = arrows_of_the_workspace();
    let count: usize =
        arrows.values().map(|uses| uses.iter().filter(|used| arrows.contains_key(*used)).count()).sum();
    println!("{} members, {count} arrows between them", arrows.len());
    assert!(arrows.len() >= 15, "members are missing: {:?}", arrows.keys());
    assert_eq!(violations(&arrows), Vec::<String>::new());
}

#[test]
fn the_check_itself_finds_forbidden_arrows() {
    let good = arrows_of_the_workspace();
    let forbidden = [
        ("railgrip-vehicle", "railgrip-filter"),
        ("railgrip-truth-plant", "railgrip-vehicle"),
        ("railgrip-health", "railgrip-estimator"),
        ("railgrip-messages", "railgrip-bus"),
        ("railgrip-filter", "tokio"),
        ("railgrip-ingest", "iceoryx2"),
        ("railgrip-bus", "railgrip-cli"),
        ("railgrip-diagnosis", "railgrip-requirements"),
        ("railgrip-diagnosis", "railgrip-truth-plant"),
        ("railgrip-health", "railgrip-requirements"),
        ("railgrip-requirements", "railgrip-vehicle"),
    ];
    for (member, used) in forbidden {
        let mut arrows = good.clone();
        arrows.get_mut(member).expect("member").push(used.to_owned());
        let found = violations(&arrows);
        assert!(
            found.iter().any(|text| text.contains(member) && text.contains(used)),
            "{member} → {used} not found"
        );
    }
    let mut arrows = good;
    arrows.insert("railgrip-novelty".into(), vec![]);
    assert!(!violations(&arrows).is_empty(), "a member outside the table must be noticed");
}
