//! Law-level cases: one law measured alone on a bench, and what the nominal law misses.
//!
//! A case is a folder with `bench.toml`, `fit/*.csv` and `holdout/*.csv`. [`diagnose`] reads it, calibrates the nuisances, tries every
//! candidate of [`library`] in several forms, and says which one the data ask for, with which parameters, and how far
//! the gap shrinks – or that something is missing that no candidate describes.
//!
//! # Glossary
//! * *form* – a formula for the dependence on one variable ([`forms`]); *candidate* – an id with several forms.
//! * *score* – squared error over sigma² that a candidate removes, less ln(points) for each parameter.
//! * *flexible discrepancy* – smooth functions of the variables, the yardstick of what could be explained ([`flexible`]).

mod apply;
mod chance;
mod error;
mod estimates;
mod figures;
mod fit;
mod flexible;
mod folds;
pub mod forms;
mod gaps;
mod input;
pub mod library;
mod model;
mod points;
mod search;
mod sigma;
mod verdict;
mod write_up;

pub use apply::Applied;
pub use error::BenchError;
pub use gaps::write_tables as write_predictions;
pub use input::Kind;
pub use points::Covariate;

use crate::answer::schema::Report;
use crate::answer::supplement::Detail;
use chance::Noise;
use folds::Folds;
use input::BenchCase;
use library::CandidateSpec;
use points::Spread;
use railgrip_recording::Table;
use search::{Bench, Found, Trial};
use std::path::Path;
use std::time::Instant;
use verdict::Judgement;

/// What a diagnosis of a bench is told beside its case.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Candidates to leave out.
    pub without: Vec<String>,
    /// Seed of the bootstraps.
    pub seed: u64,
    /// Program and version, for the report's settings.
    pub version: String,
    /// The command line, for the report's settings.
    pub command: String,
}

/// What a diagnosis gives.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// `report.json`.
    pub report: Report,
    /// What the HTML report shows beside it.
    pub detail: Detail,
    /// The prediction file of each holdout file: name without ending, and table. See [`write_predictions`].
    pub predictions: Vec<(String, Table)>,
    /// What was found, for a vehicle.
    pub applied: Applied,
}

/// Everything that was found out, ready to be written up.
struct Diagnosis {
    case: BenchCase,
    noise: Noise,
    sigma_source: &'static str,
    scheme: folds::Scheme,
    calibrated: Trial,
    found: Found,
    judgement: Judgement,
}

/// Diagnoses the case in `case_dir`.
///
/// # Errors
/// Everything that can be wrong with the input; nothing else fails.
pub fn diagnose(case_dir: &Path, options: &Options) -> Result<Outcome, BenchError> {
    let started = Instant::now();
    let case = input::load(case_dir)?;
    let library = chosen_library(case.kind, &options.without)?;
    let diagnosis = investigate(case, library, options.seed);
    write_up::write_up(&diagnosis, options, started)
}

/// Whether `case_dir` holds a law-level case.
pub fn is_bench(case_dir: &Path) -> bool {
    case_dir.join("bench.toml").is_file()
}

fn chosen_library(kind: Kind, without: &[String]) -> Result<Vec<&'static CandidateSpec>, BenchError> {
    let all = library::candidates(kind);
    let known: Vec<&str> =
        [Kind::Creep, Kind::Brake].into_iter().flat_map(library::candidates).map(|spec| spec.id).collect();
    for id in without {
        if !known.contains(&id.as_str()) && !is_wagon_effect(id) {
            return Err(BenchError::UnknownCandidate { id: id.clone(), allowed: known.join(", ") });
        }
    }
    Ok(all.iter().filter(|spec| without.iter().all(|id| id != spec.id)).collect())
}

/// Whether the catalogue of wagon effects has this id: leaving it out of a bench's library is idle, not wrong.
fn is_wagon_effect(id: &str) -> bool {
    railgrip_vehicle::effects::find(id).is_some()
}

fn investigate(case: BenchCase, library: Vec<&'static CandidateSpec>, seed: u64) -> Diagnosis {
    let points = case.fit.points.clone();
    let library: Vec<_> =
        library.into_iter().filter(|spec| Spread::of(&points, spec.covariate).is_some()).collect();
    let (mut noise, sigma_source) = sigma::estimate(&case, None);
    let variables = figures::variables(case.kind);
    let folds = Folds::of(&points, variables);
    let scheme = folds.scheme;
    let bench = |noise: Noise| Bench {
        kind: case.kind,
        nominal: case.nominal,
        points: &points,
        noise,
        library: library.clone(),
        folds: folds.clone(),
        seed,
    };
    let mut current = bench(noise);
    let mut calibrated = current.calibrated();
    let mut found = current.search(&calibrated);
    // Noise is judged around the best model; where that is much better than the calibrated one, everything is judged anew.
    if !found.effects.is_empty() {
        let (again, _) = sigma::estimate(&case, Some(&found.extended));
        if again.unit() < 0.85 * noise.unit() || again.sigma != noise.sigma {
            noise = again;
            current = bench(noise);
            calibrated = current.calibrated();
            found = current.search(&calibrated);
        }
    }
    let judgement = verdict::judge(&current, &calibrated, &found);
    Diagnosis { noise, sigma_source, scheme, calibrated, found, judgement, case }
}
