//! The diagnosis of a wagon's case from recordings to report, in the order in which it works.
//!
//! # Why did a case get its verdict?
//! | question | place |
//! | --- | --- |
//! | which rule decided | `rule` in the report; the table [`RULES`](crate::decide::verdict::RULES), read from its top, then that of [`practice`](crate::decide::practice) |
//! | what the rule compared | [`Evidence`](crate::answer::schema::Evidence), gathered in [`evidence`](crate::decide::evidence) |
//! | with which limit, and why that one | [`criteria`](crate::decide::criteria) |
//! | why no effect, or no further one, was taken | `Stop` in [`acceptance`](crate::decide::acceptance), on the page under *To make this report again* |
//! | where the model errs | [`localise`](crate::predict::localise), on the page under *Where it lies* |
//! | how sure a named effect is | [`confidence`](crate::decide::confidence) |
//!
//! `cargo run --release -p railgrip-diagnosis --example explain CASE` prints all of it for one case.

use crate::answer::schema::{NaturalGap, Report, Verdict};
use crate::answer::supplement::{Detail, Settings};
use crate::data::align::Alignments;
use crate::data::case::{Case, Run};
use crate::data::lacks;
use crate::decide::criteria::Criteria;
use crate::decide::evidence::{self, Judgement};
use crate::decide::in_gap::{self, Search};
use crate::decide::selection::{self, Selection};
use crate::fit::windows::Models;
use crate::model::parameters::Built;
use crate::plan::{self, Limits, Plan, Settled};
use crate::predict::disturbances::DisturbanceModel;
use crate::predict::{natural, open_loop};
use crate::shown::{Shown, Trial};
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

/// Diagnoses a case. `progress` is told the id of each candidate when it has been fitted, and each later part when it begins; threads are
/// those of the surrounding rayon pool.
pub fn diagnose(case: &Case, options: &Options, progress: &(dyn Fn(&'static str) + Sync)) -> Outcome {
    diagnose_and(case, options, progress, |_, _, _, _| ()).0
}

/// Diagnoses a case and designs the run that best tells apart what is left open; `None` where nothing is.
pub fn plan(
    case: &Case,
    options: &Options,
    limits: &Limits,
    progress: &(dyn Fn(&'static str) + Sync),
) -> (Outcome, Option<Plan>) {
    let started = Instant::now();
    let (outcome, plan) = diagnose_and(case, options, progress, |case, selection, report, criteria| {
        progress("plan");
        plan::plan(case, selection, report, limits, criteria)
    });
    let plan = plan.flatten().map(|plan| Plan { seconds: started.elapsed().as_secs_f64(), ..plan });
    (outcome, plan)
}

/// Diagnoses a case and says what a test run, which the diagnosis has not seen, makes of what is left open. `test` has it among its fitted
/// runs.
pub fn settle(
    case: &Case,
    test: &Case,
    options: &Options,
    progress: &(dyn Fn(&'static str) + Sync),
) -> (Outcome, Option<Settled>) {
    diagnose_and(case, options, progress, |case, selection, report, criteria| {
        progress("test");
        plan::settle((case, test), selection, report, options.seed, criteria)
    })
}

/// Diagnoses a case, and does something more with what was weighed: at the samples that are left when dense recordings are thinned, and
/// where something is wrong there that has no name, at more of them.
fn diagnose_and<T>(
    case: &Case,
    options: &Options,
    progress: &(dyn Fn(&'static str) + Sync),
    more: impl Fn(&Case, &Selection, &Report, &Criteria) -> T,
) -> (Outcome, Option<T>) {
    let started = Instant::now();
    let mut criteria = Criteria::default();
    let cut = case.within(criteria.pursuit.longest_s);
    let case = cut.as_ref().unwrap_or(case);
    let is_thinned = case.thinned(criteria.pursuit.rate_hz).is_some();
    let is_settled = |report: &Report| !is_thinned || report.verdict != Verdict::Unknown;
    let (outcome, done) = answer(case, options, &criteria, progress, |case, selection, report, criteria| {
        is_settled(report).then(|| more(case, selection, report, criteria))
    });
    let (mut outcome, done) = match is_settled(&outcome.report) {
        true => (outcome, done),
        false => {
            criteria.pursuit.rate_hz = criteria.report.rate_hz;
            let more = |case: &Case, selection: &Selection, report: &Report, criteria: &Criteria| {
                Some(more(case, selection, report, criteria))
            };
            answer(case, options, &criteria, progress, more)
        }
    };
    outcome.report.seconds = started.elapsed().as_secs_f64();
    (outcome, done)
}

/// Diagnoses a case by some criteria, and does something more with what was weighed.
fn answer<T>(
    case: &Case,
    options: &Options,
    criteria: &Criteria,
    progress: &(dyn Fn(&'static str) + Sync),
    more: impl FnOnce(&Case, &Selection, &Report, &Criteria) -> T,
) -> (Outcome, T) {
    let alignments = Alignments::default();

    // Thin: what is to be found shows at 25 samples a second. The gap is that of all samples.
    let recorded = case;
    let thinned = case.thinned(criteria.pursuit.rate_hz);
    let case = thinned.as_ref().unwrap_or(case);

    // Calibrate: fit the nuisances alone. All that follows is measured against this model.
    progress("calibration");
    let mut base = selection::calibrate(case);

    // Listen: take the noise of the sensors from the recordings, and calibrate again if it is not as the vehicle file says.
    let heard = selection::heard(&base, criteria);
    let case = heard.as_ref().unwrap_or(case);
    if heard.is_some() {
        base = selection::calibrate_again(case, &base);
    }

    // Localise: let one place of the equations err after the other. Where that gains most, the model is wrong, whatever the
    // cause; a cause that cannot act there will have to explain itself.
    progress("places");
    let places = selection::localise(&base, criteria);

    // Select: which effects of the library the recordings ask for. Each must gain more than chance and more than a mere
    // mending of the one before it; `selection.stop` says why no further one was taken.
    let mut selection =
        selection::select((case, &alignments), base, places, &options.without, criteria, progress);

    // A filter takes what is slow for pads that drift. On the windows of the gap it is told from them: effects that gained too
    // little are looked at there, and further ones.
    let calibrated = Models::calibrated(case, &selection.base.fitted);
    let [_, right, _] = calibrated.build();
    let enough = match case.is_coupled() {
        true => f64::INFINITY,
        false => natural_gap_of(case, &case.fit, &right, options.seed),
    };
    let search = Search {
        case,
        alignments: &alignments,
        calibrated: &calibrated,
        enough,
        without: &options.without,
        criteria,
    };
    if !case.is_coupled() {
        progress("gap");
        if let Some(faint) = in_gap::first(case, &selection, &calibrated, criteria) {
            selection.take_faint(faint, criteria);
        }
        if let Some(alone) = search.alone(&selection) {
            selection.take_further((case, &alignments), alone, criteria);
        }
        while let Some(further) = search.further(&selection)
            && selection.take_further((case, &alignments), further, criteria)
        {}
    }

    // Judge: are they the answer, a part of it, or none? What they leave, and what a free curve would explain beside them or
    // instead of them, goes through the table of rules. Here a case becomes `unknown`.
    progress("verdict");
    let mut judgement = evidence::judge(&selection, criteria, options.seed);

    // Fit once more, on the windows by which the gap is defined and to more samples than a choice needs: the verdict stands,
    // the numbers of the report are these.
    progress("fit on windows");
    let (coarse, like_heard) =
        (case, |finer: &Case| Case { noise: case.noise, notes: case.notes.clone(), ..finer.clone() });
    let is_coarse = thinned.is_some() && criteria.pursuit.rate_hz < criteria.report.rate_hz;
    let finer =
        is_coarse.then(|| like_heard(recorded.thinned(criteria.report.rate_hz).as_ref().unwrap_or(recorded)));
    let case = finer.as_ref().unwrap_or(coarse);
    let calibrated = match &finer {
        Some(finer) => calibrated.on_samples_of(finer),
        None => calibrated,
    };
    let fitted = |judgement: &Judgement, selection: &Selection| {
        let named = judgement.decision.names_effects().then_some(&selection.best.fitted);
        calibrated.extended_by(case, named)
    };
    let mut models = fitted(&judgement, &selection);
    // A further effect whose strength may be none and without which the gap is the same is none, however sure a filter is.
    while !case.is_coupled()
        && let Some(idle) = in_gap::idle(case, &selection, &models, criteria)
        && selection.drop_effect((coarse, &alignments), idle, criteria)
    {
        judgement = evidence::judge(&selection, criteria, options.seed);
        models = fitted(&judgement, &selection);
    }

    // Predict: what is shown is the gap of all samples.
    let thin = case;
    let dense = thinned.is_some().then(|| like_heard(recorded));
    let case = dense.as_ref().unwrap_or(case);
    let tried = &selection.best.fitted;
    let mut shown = Shown::new(case, models, judgement.decision.names_effects().then_some(tried));

    // In practice: is the gap what a right model would leave on these very runs, with the noise that was heard, drifting pads and
    // gusts? That of a coupled wagon is mostly its couplers.
    let natural = (!case.is_coupled()).then(|| natural_gap(case, &shown.built[1], options.seed));
    if let Some(natural) = natural {
        let trial = Trial { case, fitted: thin, calibrated: &calibrated, natural, criteria };
        shown = trial.revise(&mut judgement, tried, shown);
    }

    // Write: the report, what is shown beside it, predictions of the three models, the vehicle file.
    progress("report");
    let outcome = written(case, options, &selection, &judgement, &shown, natural, criteria);
    let more = more(case, &selection, &outcome.report, criteria);
    (outcome, more)
}

/// Writes down what was found.
fn written(
    case: &Case,
    options: &Options,
    selection: &Selection,
    judgement: &Judgement,
    shown: &Shown,
    natural: Option<NaturalGap>,
    criteria: &Criteria,
) -> Outcome {
    let ([_, calibrated, extended], models) = (&shown.built, &shown.models);
    let answer = match shown.named.and_then(|fitted| fitted.shape.effects.first()) {
        Some(effect) => {
            Some(regime::Answer { term: effect.spec.term, variable: regime::variable_of(effect.spec.id) })
        }
        None => judgement.missing.as_ref().map(|missing| regime::Answer {
            term: missing.discrepancy.term,
            variable: Some(missing.discrepancy.covariate),
        }),
    };
    let (heat_map, regime) = regime::locate(case, calibrated, extended, criteria.report.region_share, answer);
    let predicted = [&shown.fit[..], &shown.holdout[..]];
    let (seed, widening) = (options.seed, criteria.report.widening);
    let report =
        report::report(case, seed, selection, judgement, models, predicted, natural, regime, criteria);
    let mut detail = details::detail(case, selection, judgement, models, &report, criteria);
    detail.case = options.case.clone();
    detail.settings = settings(options, selection);
    detail.heat_map = heat_map;
    details::add_runs(&mut detail, case, &shown.fit, &shown.holdout);
    detail.effect_curves = details::effect_curves(case, selection, models, calibrated, &report, widening);
    let lacks = lacks::of(case).into_iter().map(|lack| format!("the recordings show little: {}", lack.words));
    let coupled = case.is_coupled().then(|| COUPLED.to_owned());
    let notes: Vec<String> = case.notes.iter().cloned().chain(lacks).chain(coupled).collect();
    detail.notes.extend(notes.iter().cloned());
    let predictions = predictions::tables(&case.holdout, &shown.holdout).unwrap_or_default();
    Outcome { report: Report { notes, ..report }, detail, predictions, vehicle: models.vehicle() }
}

/// The gap that the calibrated model would leave if it were right.
fn natural_gap(case: &Case, calibrated: &Built, seed: u64) -> NaturalGap {
    let of = |runs: &[Run]| natural_gap_of(case, runs, calibrated, seed);
    NaturalGap { fit: of(&case.fit), holdout: (!case.holdout.is_empty()).then(|| of(&case.holdout)) }
}

/// The same of some runs.
fn natural_gap_of(case: &Case, runs: &[Run], calibrated: &Built, seed: u64) -> f64 {
    let disturbances = DisturbanceModel::default();
    open_loop::Tally::total(&natural::tallies(case, runs, calibrated, &disturbances, seed)).gap()
}

/// What is said of a wagon that does not run alone.
const COUPLED: &str = "the wagon is coupled: forces of its couplers were estimated along with it, so that resistance, grade and \
     other forces on the body cannot be named, and the gap of the vehicle speed is mostly theirs";

/// How to make the report again.
fn settings(options: &Options, selection: &Selection) -> Settings {
    Settings {
        version: options.version.clone(),
        command: options.command.clone(),
        seed: options.seed,
        without: options.without.clone(),
        more: vec![
            ("Why no further effect was tried or taken".into(), selection.stop.words().into()),
            (
                "Error of the model that the filter allows for (0 none, 3 most)".into(),
                selection.best.tolerance.to_string(),
            ),
        ],
    }
}
