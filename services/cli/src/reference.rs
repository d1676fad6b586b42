//! `railgrip reference`: every key of a config, from the types that read it.

use crate::CliError;
use crate::output::say;

/// Print every key of a config, as Markdown.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {}

pub(crate) fn run(_args: &Args) -> Result<(), CliError> {
    say(&railgrip_settings::reference().map_err(CliError::failed)?);
    Ok(())
}
