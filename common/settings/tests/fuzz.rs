//! Config files that somebody, or something, has spoilt: each is read or refused with words, none makes the program panic.
//!
//! `PROPTEST_CASES=100000 cargo test --release -p railgrip-settings --test fuzz` looks for longer.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

use proptest::prelude::*;
use proptest::sample::{Index, select};
use railgrip_settings::{Overrides, TrainSettings, mistakes, vehicle};
use std::path::{Path, PathBuf};

/// One thing done to a text.
#[derive(Debug, Clone)]
enum Damage {
    Byte(Index, u8),
    Cut(Index),
    DropLine(Index),
    RepeatLine(Index),
    SwapLines(Index, Index),
    Value(Index, &'static str),
    Key(Index, &'static str),
}

const VALUES: [&str; 24] = [
    "0",
    "-1",
    "1e308",
    "-1e308",
    "nan",
    "inf",
    "-inf",
    "9223372036854775807",
    "-9223372036854775808",
    "\"\"",
    "\"\\u0000\"",
    "\"/\"",
    "\"../../..\"",
    "[]",
    "[[]]",
    "{}",
    "true",
    "1979-05-27",
    "\"\u{202e}\"",
    "0.1e-300",
    "[1, \"a\"]",
    "'''",
    "\"ä\"",
    "\"aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa\"",
];

fn damage() -> impl Strategy<Value = Damage> {
    let at = any::<Index>;
    prop_oneof![
        (at(), any::<u8>()).prop_map(|(place, byte)| Damage::Byte(place, byte)),
        at().prop_map(Damage::Cut),
        at().prop_map(Damage::DropLine),
        at().prop_map(Damage::RepeatLine),
        (at(), at()).prop_map(|(one, other)| Damage::SwapLines(one, other)),
        (at(), select(&VALUES[..])).prop_map(|(place, value)| Damage::Value(place, value)),
        (at(), select(vec!["", ".", "[", "[[wagon]]", "a.b.c", "\"\"", "=", "#"]))
            .prop_map(|(place, key)| Damage::Key(place, key)),
    ]
}

fn spoilt(text: &str, damages: &[Damage]) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for damage in damages {
        if lines.is_empty() {
            break;
        }
        match damage {
            Damage::Byte(place, byte) => {
                let mut bytes = lines.join("\n").into_bytes();
                if !bytes.is_empty() {
                    let at = place.index(bytes.len());
                    bytes[at] = *byte;
                }
                lines = String::from_utf8_lossy(&bytes).lines().map(str::to_owned).collect();
            }
            Damage::Cut(place) => lines.truncate(place.index(lines.len())),
            Damage::DropLine(place) => drop(lines.remove(place.index(lines.len()))),
            Damage::RepeatLine(place) => lines.push(lines[place.index(lines.len())].clone()),
            Damage::SwapLines(one, other) => {
                let (one, other) = (one.index(lines.len()), other.index(lines.len()));
                lines.swap(one, other);
            }
            Damage::Value(place, value) | Damage::Key(place, value) => {
                let with: Vec<usize> = (0..lines.len()).filter(|at| lines[*at].contains(" = ")).collect();
                if with.is_empty() {
                    continue;
                }
                let line = &mut lines[with[place.index(with.len())]];
                let (key, old) = line.split_once(" = ").unwrap();
                *line = if matches!(damage, Damage::Value(..)) {
                    format!("{key} = {value}")
                } else {
                    format!("{value} = {old}")
                };
            }
        }
    }
    lines.join("\n")
}

fn config_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config")
}

fn settings(cases: u32) -> ProptestConfig {
    let rng_seed = proptest::test_runner::RngSeed::Fixed(17);
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|text| text.parse().ok()).unwrap_or(cases);
    ProptestConfig { cases, rng_seed, failure_persistence: None, ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(settings(500))]

    #[test]
    fn no_config_makes_the_program_panic(
        which in select(vec!["railgrip.toml", "replay.toml"]),
        damages in prop::collection::vec(damage(), 1..6),
    ) {
        let file = config_folder().join(which);
        let text = spoilt(&std::fs::read_to_string(&file).unwrap(), &damages);
        if let Err(error) = TrainSettings::parse(&file, &text, &Overrides::default()) {
            let said = error.to_string();
            prop_assert!(said.contains(".toml") || said.contains("recordings"), "names no file: {}", said);
            prop_assert!(said.len() < 4000, "{} bytes of complaint", said.len());
        }
    }

    /// All mistakes at once: none where it is sound, and each in the file; what is absent is never read as zero.
    #[test]
    fn what_is_wrong_is_told_and_what_is_absent_is_no_zero(
        which in select(vec!["railgrip.toml", "replay.toml"]),
        damages in prop::collection::vec(damage(), 1..6),
    ) {
        let file = config_folder().join(which);
        let text = spoilt(&std::fs::read_to_string(&file).unwrap(), &damages);
        let found = mistakes(&file, &text, &Overrides::default());
        let lines = text.lines().count().max(1);
        for error in &found {
            prop_assert!(error.line().is_none_or(|line| (1..=lines + 1).contains(&line)), "{}", error);
        }
        let mut said: Vec<String> = found.iter().map(ToString::to_string).collect();
        said.sort();
        said.dedup();
        prop_assert_eq!(said.len(), found.len(), "told twice: {:?}", said);
        match TrainSettings::parse(&file, &text, &Overrides::default()) {
            Err(_) => prop_assert!(!found.is_empty(), "refused, and nothing is told"),
            Ok(settings) => {
                prop_assert!(found.is_empty(), "sound, and yet {:?}", said);
                let positive = [
                    settings.reporting.snapshot_period_s,
                    settings.reporting.health_rate_hz,
                    settings.http.refresh_s,
                    settings.http.stale_after_s,
                    settings.history.flush_s,
                    settings.history.event_days,
                    settings.notify.longest_pause_s,
                    settings.capability.full_deceleration_m_s2,
                    settings.diagnosis.time_limit_s,
                    settings.access.limits.burst,
                    settings.access.limits.head.as_secs_f64(),
                ];
                prop_assert!(positive.iter().all(|value| *value > 0.0), "{:?}", positive);
                prop_assert!(!settings.wagons.is_empty());
                for wagon in &settings.wagons {
                    let vehicle = &wagon.vehicle;
                    prop_assert!(vehicle.body.mass_kg > 0.0 && vehicle.wheelset.radius_m > 0.0);
                }
            }
        }
    }

    #[test]
    fn no_vehicle_makes_the_program_panic(damages in prop::collection::vec(damage(), 1..6)) {
        let file = config_folder().join("vehicle.toml");
        let text = spoilt(&std::fs::read_to_string(&file).unwrap(), &damages);
        if let Err(error) = vehicle::parse(&file, &text) {
            prop_assert!(!error.to_string().is_empty());
        }
    }

    #[test]
    fn no_text_makes_the_program_panic(text in "(\\PC|\\n|\\[|\\]|=|\"|schema = 1\\n|\\[train\\]\\n){0,80}") {
        let _ = TrainSettings::parse(Path::new("x.toml"), &text, &Overrides::default());
        let _ = vehicle::parse(Path::new("x.toml"), &text);
    }
}

#[test]
fn what_is_not_spoilt_is_read() {
    for which in ["railgrip.toml", "replay.toml"] {
        let file = config_folder().join(which);
        let text = spoilt(&std::fs::read_to_string(&file).unwrap(), &[]);
        TrainSettings::parse(&file, &text, &Overrides::default()).unwrap();
    }
}
