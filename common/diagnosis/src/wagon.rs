//! The diagnosis of a wagon's case from recordings to report, in the order in which it works.

use crate::answer::schema::Report;
use crate::answer::supplement::{Detail, Settings};
use crate::data::case::Case;
use crate::decide::criteria::Criteria;
use crate::decide::{evidence, selection};
use crate::fit::windows::Models;
use crate::write::{details, predictions, regime, report};
use railgrip_recording::Table;
use railgrip_vehicle::VehicleParameters;
use std::time::Instant;

/// What a diagnosis is told beside its case.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Name of the case for people.
    pub case: String,
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
    /// The prediction file of each holdout run: its name without ending, and the table.
    pub predictions: Vec<(String, Table)>,
    /// The vehicle with fitted nuisances and the effects found.
    pub vehicle: VehicleParameters,
}

/// Diagnoses a case. `progress` is told what has just been done; threads are those of the surrounding rayon pool.
pub fn diagnose(case: &Case, options: &Options, progress: &(dyn Fn(&'static str) + Sync)) -> Outcome {
    let started = Instant::now();
    let criteria = Criteria::default();

    // Calibrate: nuisances alone. Localise: free one place of the equations after the other.
    let base = selection::calibrate(case);
    let places = selection::localise(case, &base, &criteria);

    // Select: which effects of the library the recordings ask for.
    let selection = selection::select(case, base, places, &options.without, &criteria, progress);

    // Judge: whether they are the answer, a part of it, or none.
    progress("verdict");
    let judgement = evidence::judge(case, &selection, &criteria, options.seed);

    // Fit once more, on the windows by which the gap is defined.
    progress("fit on windows");
    let named = judgement.decision.names_effects().then_some(&selection.best.fitted);
    let models = Models::fit(case, &selection.base.fitted, named);

    // Write.
    progress("report");
    let [nominal, calibrated, extended] = &models.build();
    let three = [nominal, calibrated, extended];
    let fit = predictions::predict(case, &case.fit, three);
    let holdout = predictions::predict(case, &case.holdout, three);
    let (heat_map, regime) = regime::locate(case, calibrated, extended, criteria.report.region_share);
    let report = report::report(
        case,
        options.seed,
        &selection,
        &judgement,
        &models,
        [&fit, &holdout],
        regime,
        &criteria,
    );
    let mut detail = details::detail(case, &selection, &judgement, &models, &report, &criteria);
    detail.case = options.case.clone();
    detail.settings = settings(options, selection.best.tolerance);
    detail.heat_map = heat_map;
    details::add_runs(&mut detail, case, &fit, &holdout);
    detail.effect_curves =
        details::effect_curves(case, &selection, &models, calibrated, &report, criteria.report.widening);
    let tables = case.holdout.iter().zip(&holdout).filter_map(|(run, predicted)| {
        predictions::table(run, predicted).ok().map(|table| (run.name.clone(), table))
    });
    let predictions = tables.collect();
    let vehicle = models.vehicle();
    let report = Report { seconds: started.elapsed().as_secs_f64(), ..report };
    Outcome { report, detail, predictions, vehicle }
}

/// How to make the report again.
fn settings(options: &Options, tolerance: usize) -> Settings {
    Settings {
        version: options.version.clone(),
        command: options.command.clone(),
        seed: options.seed,
        without: options.without.clone(),
        more: vec![("tolerance level of the filter".into(), tolerance.to_string())],
    }
}
