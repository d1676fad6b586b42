//! `railgrip payloads`: the layouts of what travels on the channels, for publishers and subscribers in other languages.

mod layout;

use crate::CliError;
use crate::output::say;

/// Print the payloads for other languages.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// A header for C and C++
    #[arg(long, conflicts_with = "python", required_unless_present = "python")]
    c: bool,
    /// A module for Python
    #[arg(long)]
    python: bool,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    say(&if args.c { layout::c_header() } else { layout::python_module() });
    Ok(())
}
