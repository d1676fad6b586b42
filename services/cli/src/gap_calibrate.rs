//! `railgrip gap calibrate`: from what reports said and what was at work to how probable such findings are.

use std::fs::File;
use std::path::{Path, PathBuf};

use railgrip_diagnosis::answer::schema::{PosteriorSet, Report};
use railgrip_diagnosis::decide::learning::{self, Agreement, Truth};
use railgrip_diagnosis::decide::posterior::Calibration;
use railgrip_diagnosis::decide::test_run::{self, Taught, TestRun, TestWeights};
use railgrip_truth_plant::label::Gaps;
use railgrip_vehicle::effects;
use serde::Deserialize;
use serde_json::Value;

use crate::CliError;
use crate::blind::{Made, VISIBLE};
use crate::output::say;
use crate::sealed::files::write;

/// Arguments of `railgrip gap calibrate`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Opened labels of cases, as `gap blind --open-labels` writes them or as lists of `case`, `effects` and gaps; may be repeated
    #[arg(long, value_name = "FILE", required = true)]
    labels: Vec<PathBuf>,
    /// Folder with a report NAME.json for each of these cases, in the order of the labels; may be repeated
    #[arg(long, value_name = "DIR", required = true)]
    reports: Vec<PathBuf>,
    /// Learn this part anew and keep the rest of the program's calibration: failing (of names whose effects do not carry over), spread (of
    /// values), tests (runs beside the reports, NAME.designed.json and NAME.any.json of `gap settle`)
    #[arg(long, value_name = "PART")]
    only: Option<Part>,
    /// What the cases are, for whoever reads the result
    #[arg(long, value_name = "WORDS", default_value = "simulated cases")]
    provenance: String,
    /// Where the calibration goes; without it, the calibration of this program is compared with the cases and not changed
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// A part of a calibration that can be learnt alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Part {
    /// What it means for a name that its effects predict other runs no better.
    Failing,
    /// How far fitted values lie from true ones.
    Spread,
    /// How far a test moves probabilities.
    Tests,
}

/// Learns a calibration, or compares the program's own with cases that it was not learnt from.
pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    if args.labels.len() != args.reports.len() {
        return Err(CliError::bad_input(format!(
            "{} --labels and {} --reports: each file of labels needs its folder of reports",
            args.labels.len(),
            args.reports.len()
        )));
    }
    let (mut cases, mut tests) = (Vec::new(), Vec::new());
    for (labels, reports) in args.labels.iter().zip(&args.reports) {
        read(labels, reports, &mut cases, &mut tests)?;
    }
    if cases.is_empty() {
        return Err(CliError::bad_input("no report of any of these cases was found"));
    }
    if args.out.is_some() && args.only.is_none() {
        report_agreement(&learning::agreement_apart(&cases), cases.len(), " (told by what the others say)");
    }
    let provenance = || args.provenance.clone();
    let shipped = Calibration::shipped();
    let weights = |kept: &TestWeights| match tests.as_slice() {
        [] => kept.clone(),
        tests => TestWeights::fit(tests, &args.provenance),
    };
    let calibration = match (&args.out, args.only) {
        (None, _) => shipped,
        (Some(_), None) => {
            Calibration { tests: weights(&shipped.tests), ..learning::learn(&cases, provenance()) }
        }
        (Some(_), Some(Part::Failing)) => Calibration {
            names: learning::with_failing(&shipped.names, &cases),
            fails_provenance: Some(provenance()),
            ..shipped
        },
        (Some(_), Some(Part::Spread)) => {
            Calibration { spread: learning::spread(&cases, provenance()), ..shipped }
        }
        (Some(_), Some(Part::Tests)) => Calibration { tests: weights(&shipped.tests), ..shipped },
    };
    report_tests(&tests, &calibration.tests);
    for (report, _) in &mut cases {
        calibration.settle(report);
    }
    let from = if args.out.is_some() { " (on the cases that it was learnt from)" } else { "" };
    report_agreement(&learning::agreement(&cases), cases.len(), from);
    let (held, of) = learning::values_held(&cases);
    say(&format!("{of} values whose true ones are known: 90 % intervals hold {held}{from}"));
    if let Some(out) = &args.out {
        let text = toml::to_string_pretty(&calibration).map_err(CliError::failed)?;
        write(
            out,
            &format!(
                "# How findings become probabilities. Written by `railgrip gap calibrate`; not set by hand.\n{text}"
            ),
        )?;
    }
    Ok(())
}

/// One line about how well probabilities agree with what was at work.
fn report_agreement(agreement: &Agreement, cases: usize, from: &str) {
    say(&format!(
        "{cases} cases, {} names: calibration error {:.3}, log loss {}, area of right names {}; verdict sets hold the truth in {:.1} %, \
         mean size {:.2}, area of unknown {}{from}",
        agreement.names,
        agreement.calibration_error,
        told(agreement.log_loss),
        told(agreement.names_area),
        100.0 * agreement.sets_hold,
        agreement.mean_size,
        told(agreement.unknown_area),
    ));
}

/// A set this likely is sure.
const SURE: f64 = 0.8;

/// Lines about what tests do to the probability of the truth, and how often what is sure after them is right.
fn report_tests(tests: &[Taught], weights: &TestWeights) {
    if tests.is_empty() {
        return;
    }
    let mean = |of: &dyn Fn(&Taught) -> f64| tests.iter().map(of).sum::<f64>() / tests.len() as f64;
    let before = |(_, sets, right): &Taught| test_run::truth(sets, right);
    let after = |taught: &Taught| weights.of_truth(taught);
    let log = |p: f64| p.max(test_run::LEAST).ln();
    let sure = |is_right: bool| {
        let is = |(test, sets, right): &&Taught| {
            let after = test.reweigh(sets, weights);
            after.iter().zip(right).any(|(set, right)| set.p >= SURE && *right == is_right)
        };
        tests.iter().filter(is).count()
    };
    say(&format!(
        "{} tests: probability of the truth, mean {:.2} before and {:.2} after, logarithm {:.2} and {:.2}; sets at {SURE} and more after them: {} right, {} \
         wrong ({:.1} errors a window, log-odds {:.2} by what is explained and {:.2} by what is left, allowance {:.2})",
        tests.len(),
        mean(&before),
        mean(&after),
        mean(&|taught| log(before(taught))),
        mean(&|taught| log(after(taught))),
        sure(true),
        sure(false),
        weights.per_window,
        weights.explains,
        weights.leaves,
        weights.allowance,
    ));
}

/// What `gap settle` wrote of a test, as far as is learnt from it.
#[derive(Debug, Deserialize)]
struct Told {
    before: Vec<PosteriorSet>,
    test: TestRun,
}

/// The reports that exist of the cases of one file of labels, and the tests beside them.
fn read(
    labels: &Path,
    reports: &Path,
    cases: &mut Vec<(Report, Truth)>,
    tests: &mut Vec<Taught>,
) -> Result<(), CliError> {
    let bad = |path: &Path, error: &dyn std::fmt::Display| {
        CliError::bad_input(format!("{}: {error}", path.display()))
    };
    let file = File::open(labels).map_err(|error| bad(labels, &error))?;
    let listed: Vec<Value> =
        serde_json::from_reader(std::io::BufReader::new(file)).map_err(|error| bad(labels, &error))?;
    for (index, label) in listed.into_iter().enumerate() {
        let (case, truth) = truth(label)
            .map_err(|error| bad(labels, &format!("label {} from the top: {error}", index + 1)))?;
        for kind in ["designed", "any"] {
            let path = reports.join(format!("{case}.{kind}.json"));
            let Ok(file) = File::open(&path) else { continue };
            let told: Told =
                serde_json::from_reader(std::io::BufReader::new(file)).map_err(|error| bad(&path, &error))?;
            let right = told.before.iter().map(|set| truth.is(set)).collect();
            tests.push((told.test, told.before, right));
        }
        let path = reports.join(format!("{case}.json"));
        let Ok(file) = File::open(&path) else { continue };
        let report: Report =
            serde_json::from_reader(std::io::BufReader::new(file)).map_err(|error| bad(&path, &error))?;
        cases.push((report, truth));
    }
    Ok(())
}

/// A label that says no more than what was at work and how far it showed.
#[derive(Debug, Deserialize)]
struct Plain {
    case: String,
    effects: Vec<String>,
    #[serde(default)]
    unknown: bool,
    gap_calibrated: Gaps,
    gap_without_the_effect: Gaps,
}

/// Name of a labelled case, and what was at work.
fn truth(label: Value) -> Result<(String, Truth), serde_json::Error> {
    if label.get("label").is_some() {
        let made: Made = serde_json::from_value(label)?;
        return Ok((made.label.case.clone(), made.truth()));
    }
    let plain: Plain = serde_json::from_value(label)?;
    let salience = plain.gap_calibrated.fit / plain.gap_without_the_effect.fit;
    let (known, nameless): (Vec<String>, Vec<String>) =
        plain.effects.into_iter().partition(|id| effects::find(id).is_some());
    let unknown = plain.unknown || !nameless.is_empty();
    let visible = (unknown || !known.is_empty()) && salience >= VISIBLE;
    Ok((plain.case, Truth { effects: known, hidden: Vec::new(), unknown, visible, values: Vec::new() }))
}

/// A figure; a dash where there is nothing to tell it from.
fn told(value: f64) -> String {
    if value.is_finite() { format!("{value:.2}") } else { "–".to_owned() }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn plain_labels_tell_known_unknown_and_what_cannot_be_seen() {
        let label = |effects: &[&str], fit: f64| {
            json!({"case": "case07", "effects": effects, "gap_calibrated": {"fit": fit, "holdout": 3.0},
                   "gap_without_the_effect": {"fit": 2.0, "holdout": 2.0}})
        };
        let (case, one) = truth(label(&["brake_lag"], 4.0)).unwrap();
        assert_eq!(
            (case.as_str(), one.effects, one.unknown),
            ("case07", vec!["brake_lag".to_owned()], false)
        );
        assert!(one.visible);
        let (_, other) = truth(label(&["of_no_catalogue"], 2.1)).unwrap();
        assert!(other.unknown && other.effects.is_empty() && !other.visible);
        assert!(!truth(label(&[], 2.0)).unwrap().1.visible);
        let complaint = truth(json!({"case": "case07"})).unwrap_err().to_string();
        assert!(complaint.contains("effects"), "{complaint}");
    }
}
