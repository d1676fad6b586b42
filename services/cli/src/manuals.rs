//! `railgrip manuals`: the manual pages, from the same descriptions as `--help`.

use std::path::PathBuf;

use crate::CliError;

/// Write the manual pages.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Folder for railgrip.1 and a page for each command; it is made if it is not there
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

pub(crate) fn run(args: &Args, command: clap::Command) -> Result<(), CliError> {
    let failed = |error| CliError::failed(format!("{}: {error}", args.out.display()));
    std::fs::create_dir_all(&args.out).map_err(failed)?;
    clap_mangen::generate_to(command, &args.out).map_err(failed)
}
