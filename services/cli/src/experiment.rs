//! `railgrip experiment`: the papers' experiments, each with its table and its figures.

use std::path::PathBuf;

use railgrip_experiments::{EXPERIMENTS, find, names};

use crate::CliError;
use crate::output::say;

/// Run a published experiment: table (CSV and Markdown) and figures (SVG).
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Name of the experiment; `--list` shows all
    #[arg(value_name = "NAME", required_unless_present = "list")]
    name: Option<String>,
    /// Directory for table and figures, created if need be
    #[arg(long, value_name = "DIR", default_value = "experiments")]
    out: PathBuf,
    /// Show the names of all experiments
    #[arg(long)]
    list: bool,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let name = match &args.name {
        Some(name) if !args.list => name,
        _ => {
            for experiment in EXPERIMENTS {
                say(&format!("{:<18} {}", experiment.name, experiment.about));
            }
            return Ok(());
        }
    };
    let experiment = find(name).ok_or_else(|| {
        CliError::bad_input(format!("experiment \"{name}\" is not known, known are {}", names()))
    })?;
    let report = experiment.run_into(&args.out).map_err(CliError::failed)?;
    say(&report.markdown(experiment.about));
    for file in &report.files {
        say(&format!("wrote {}", file.display()));
    }
    Ok(())
}
