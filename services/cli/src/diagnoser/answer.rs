//! What a diagnosis comes to, for people who read an alert.

use std::path::Path;
use std::process::ExitStatus;

use railgrip_diagnosis::answer::schema::Report;
use railgrip_diagnosis::data::lacks::{self, Lack};
use railgrip_diagnosis::data::load;
use railgrip_diagnosis::words::sentences;
use railgrip_health::alerts::diagnosis::{Diagnosis, Named};

/// The report that a diagnosis wrote.
pub(super) fn read(path: &Path) -> Option<Report> {
    serde_json::from_str(&std::fs::read_to_string(path).ok()?).ok()
}

/// What was found.
pub(super) fn found(case: &Path, report: &Report) -> Diagnosis {
    let named = |effect: &railgrip_diagnosis::answer::schema::FoundEffect| Named {
        id: effect.id.clone(),
        confidence: effect.confidence,
    };
    Diagnosis {
        verdict: report.verdict.name().to_owned(),
        words: sentences::headline(report),
        term: report.location.term.clone(),
        effects: report.effects.iter().map(named).collect(),
        lacks: lacks_of(case),
        has_page: true,
        seconds: report.seconds,
        recording: case.display().to_string(),
    }
}

/// A case that the diagnosis does not take, in its own words.
pub(super) fn refused(case: &Path, status: ExitStatus, said: &str) -> Diagnosis {
    let why = said.lines().rev().find(|line| !line.trim().is_empty());
    let why = why.map_or_else(|| format!("it ended with {status}"), |line| line.trim().to_owned());
    without_report(case, "refused", format!("The recording could not be diagnosed: {why}"), 0.0)
}

/// A diagnosis that took too long.
pub(super) fn given_up(case: &Path, seconds: f64) -> Diagnosis {
    let words = format!("The diagnosis was given up after {seconds:.0} s.");
    without_report(case, "given_up", words, seconds)
}

fn without_report(case: &Path, verdict: &str, words: String, seconds: f64) -> Diagnosis {
    Diagnosis {
        verdict: verdict.to_owned(),
        words,
        term: None,
        effects: Vec::new(),
        lacks: lacks_of(case),
        has_page: false,
        seconds,
        recording: case.display().to_string(),
    }
}

/// A recording from which nothing would follow: what it lacks, if that is grave.
pub(super) fn too_poor(case: &Path) -> Option<Diagnosis> {
    let grave = read_lacks(case).into_iter().find(|lack| lack.grave)?;
    let words = format!("The recording is too poor to be diagnosed: {}.", grave.words);
    Some(without_report(case, "too_poor", words, 0.0))
}

fn lacks_of(case: &Path) -> Vec<String> {
    read_lacks(case).into_iter().map(|lack| lack.words).collect()
}

/// What the recording does not show; nothing where it cannot be read, which is said elsewhere.
fn read_lacks(folder: &Path) -> Vec<Lack> {
    let vehicle = railgrip_settings::vehicle::load(&folder.join("vehicle.toml")).ok();
    let case = vehicle.and_then(|vehicle| load::load(folder, vehicle).ok());
    case.map_or_else(Vec::new, |case| lacks::of(&case))
}
