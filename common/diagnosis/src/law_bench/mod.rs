//! Law-level cases: one law measured alone on a bench, and what the nominal law misses.
//!
//! A case is a folder with `bench.toml`, `fit/*.csv` and `holdout/*.csv`. [`diagnose`] reads it ([`data`]), calibrates the
//! nuisances, tries every candidate of the [`model`] in several forms ([`fit`]), decides which of them the points ask for
//! ([`decide`]), and says how far the gap shrinks ([`write`]) – or that something is missing that no candidate describes.
//!
//! # Glossary
//! * *shape* – a formula for the dependence on one variable; *candidate* – an effect that can be named, in several shapes.
//! * *score* – squared error over sigma² that a candidate removes, less ln(points) for each parameter.
//! * *rank* – mean of the score and of the squared error that it removes on left-out data.
//! * *discrepancy* – a smooth function of one variable or two, no candidate: the yardstick of what could be explained.
//! * *structure* – what discrepancies still explain of what a model leaves.
//! * *excess* – squared error of the calibrated model beyond noise.

mod data;
mod decide;
mod fit;
pub mod model;
mod outcome;
mod predict;
mod write;

pub use data::case::Kind;
pub use data::error::LawCaseError;
pub use data::point::Covariate;
pub use outcome::{Options, Outcome};
pub use write::predictions::write_predictions;
pub use write::vehicle::Applied;

use data::case::LawCase;
use data::load;
use data::point::Spread;
use decide::criteria::Criteria;
use decide::evidence;
use decide::selection::Search;
use decide::verdict;
use fit::left_out::Folds;
use fit::noise::{self, Noise};
use model::candidates::{self, CandidateSpec};
use std::path::Path;
use std::time::Instant;
use write::findings::{self, Findings};
use write::report;

/// Diagnoses the case in `case_dir`.
///
/// # Errors
/// Everything that can be wrong with the input; nothing else fails.
pub fn diagnose(case_dir: &Path, options: &Options) -> Result<Outcome, LawCaseError> {
    let started = Instant::now();
    let case = load::load(case_dir)?;
    let library = chosen_library(case.kind, &options.without)?;
    let findings = investigate(case, library, options.seed);
    report::write(&findings, options, started)
}

/// Whether `case_dir` holds a law-level case.
pub fn is_law_case(case_dir: &Path) -> bool {
    case_dir.join("bench.toml").is_file()
}

fn chosen_library(kind: Kind, without: &[String]) -> Result<Vec<&'static CandidateSpec>, LawCaseError> {
    let all = candidates::candidates(kind);
    let known: Vec<&str> =
        [Kind::Creep, Kind::Brake].into_iter().flat_map(candidates::candidates).map(|spec| spec.id).collect();
    for id in without {
        if !known.contains(&id.as_str()) && !is_wagon_effect(id) {
            return Err(LawCaseError::UnknownCandidate { id: id.clone(), allowed: known.join(", ") });
        }
    }
    Ok(all.iter().filter(|spec| without.iter().all(|id| id != spec.id)).collect())
}

/// Whether the catalogue of wagon effects has this id: leaving it out of a bench's library is idle, not wrong.
fn is_wagon_effect(id: &str) -> bool {
    railgrip_vehicle::effects::find(id).is_some()
}

/// Noise, calibration, selection, evidence, verdict.
fn investigate(case: LawCase, library: Vec<&'static CandidateSpec>, seed: u64) -> Findings {
    let criteria = Criteria::default();
    let points = case.fit.points.clone();
    let library: Vec<_> =
        library.into_iter().filter(|spec| Spread::of(&points, spec.covariate).is_some()).collect();
    let (mut noise, sigma_source) = noise::estimate(&case, None, &criteria);
    let folds = Folds::of(&points, case.kind.variables(), &criteria);
    let scheme = folds.scheme;
    let search_at = |noise: Noise| Search {
        kind: case.kind,
        nominal: case.nominal,
        points: &points,
        noise,
        library: library.clone(),
        folds: folds.clone(),
        seed,
        criteria: &criteria,
    };
    let mut search = search_at(noise);
    let mut calibrated = search.calibrated();
    let mut selection = search.select(&calibrated);
    // Noise is judged around the best model; where that is much better than the calibrated one, everything is judged again.
    if !selection.effects.is_empty() {
        let (again, _) = noise::estimate(&case, Some(&selection.extended), &criteria);
        if again.unit() < criteria.judge_again_below * noise.unit() || again.sigma != noise.sigma {
            noise = again;
            search = search_at(noise);
            calibrated = search.calibrated();
            selection = search.select(&calibrated);
        }
    }
    let gathered = evidence::gather(&search, &calibrated, &selection);
    let rule = verdict::decide(&gathered.evidence, &criteria);
    Findings {
        noise,
        sigma_source,
        scheme,
        calibrated,
        selection,
        rule,
        recovered: 1.0 - gathered.evidence.share_left,
        structure_score: gathered.structure_score,
        structure_threshold: gathered.structure_threshold,
        missing: findings::missing(rule, gathered),
        criteria,
        case,
    }
}
