//! `railgrip reference`: every key of a config, from the types that read it.

use crate::output::say;
use crate::{CliError, reload};

/// Print every key of a config, as Markdown.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {}

pub(crate) fn run(_args: &Args) -> Result<(), CliError> {
    say(&railgrip_settings::reference().map_err(CliError::failed)?);
    say(&reload::explained());
    Ok(())
}
