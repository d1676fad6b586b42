//! `railgrip gap calibrate`: from what reports said and what was at work to how probable such findings are.

use std::fs::File;
use std::path::{Path, PathBuf};

use railgrip_diagnosis::answer::schema::Report;
use railgrip_diagnosis::decide::learning::{self, Truth};
use railgrip_diagnosis::decide::posterior::Calibration;

use crate::CliError;
use crate::blind::Made;
use crate::output::say;
use crate::sealed::files::write;

/// Arguments of `railgrip gap calibrate`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Opened labels of simulated cases, as `gap blind --open-labels` writes them; may be repeated
    #[arg(long, value_name = "FILE", required = true)]
    labels: Vec<PathBuf>,
    /// Folder with a report NAME.json for each of these cases, in the order of the labels; may be repeated
    #[arg(long, value_name = "DIR", required = true)]
    reports: Vec<PathBuf>,
    /// What the cases are, for whoever reads the result
    #[arg(long, value_name = "WORDS", default_value = "simulated cases")]
    provenance: String,
    /// Where the calibration goes; without it, the calibration of this program is compared with the cases and not changed
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
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
    let mut cases = Vec::new();
    for (labels, reports) in args.labels.iter().zip(&args.reports) {
        read(labels, reports, &mut cases)?;
    }
    if cases.is_empty() {
        return Err(CliError::bad_input("no report of any of these cases was found"));
    }
    let calibration = match args.out {
        Some(_) => learning::learn(&cases, args.provenance.clone()),
        None => Calibration::shipped(),
    };
    for (report, _) in &mut cases {
        calibration.settle(report);
    }
    let agreement = learning::agreement(&cases);
    say(&format!(
        "{} cases, {} names: calibration error {:.3}, verdict sets hold the truth in {:.1} %, mean size {:.2}, \
         area of unknown {:.2}{}",
        cases.len(),
        agreement.names,
        agreement.calibration_error,
        100.0 * agreement.sets_hold,
        agreement.mean_size,
        agreement.unknown_area,
        if args.out.is_some() { " (on the cases that it was learnt from)" } else { "" },
    ));
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

/// The reports that exist of the cases of one file of labels.
fn read(labels: &Path, reports: &Path, cases: &mut Vec<(Report, Truth)>) -> Result<(), CliError> {
    let bad = |path: &Path, error: &dyn std::fmt::Display| {
        CliError::bad_input(format!("{}: {error}", path.display()))
    };
    let file = File::open(labels).map_err(|error| bad(labels, &error))?;
    let made: Vec<Made> =
        serde_json::from_reader(std::io::BufReader::new(file)).map_err(|error| bad(labels, &error))?;
    for made in &made {
        let path = reports.join(format!("{}.json", made.label.case));
        let Ok(file) = File::open(&path) else { continue };
        let report: Report =
            serde_json::from_reader(std::io::BufReader::new(file)).map_err(|error| bad(&path, &error))?;
        cases.push((report, made.truth()));
    }
    Ok(())
}
