//! `railgrip map`: what the columns of a file may mean, as a `[mapping]` to begin with.

use std::path::PathBuf;

use railgrip_recording::{proposal, survey};

use crate::CliError;
use crate::output::say;

/// Propose a [mapping] for a recording with columns of its own.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Recording, CSV or Parquet
    #[arg(value_name = "FILE")]
    file: PathBuf,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let surveyed = survey(&args.file).map_err(CliError::bad_input)?;
    say(&proposal(&surveyed));
    Ok(())
}
