//! `railgrip check`: everything that is wrong with a config at once, and what it means where nothing is.

use std::path::PathBuf;

use railgrip_health::access::Access;
use railgrip_settings::{Overrides, TrainSettings, mistakes};

use crate::CliError;
use crate::output::say;

/// Check a config: all mistakes at once.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Config of a train
    #[arg(value_name = "CONFIG")]
    config: PathBuf,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let file = &args.config;
    let text = std::fs::read_to_string(file)
        .map_err(|error| CliError::bad_input(format!("{}: {error}", file.display())))?;
    let found = mistakes(file, &text, &Overrides::default());
    if !found.is_empty() {
        let each: Vec<String> = found.iter().map(ToString::to_string).collect();
        let number = found.len();
        let noun = if number == 1 { "mistake" } else { "mistakes" };
        return Err(CliError::bad_input(format!("{number} {noun}\n{}", each.join("\n"))));
    }
    let settings = TrainSettings::load(Some(file), &Overrides::default())?;
    Access::check(&settings).map_err(CliError::bad_input)?;
    crate::logging::check(&settings.logging.level)?;
    let named = settings.wagons.iter().filter(|wagon| wagon.vehicle_number.is_some()).count();
    say(&format!(
        "{}: sound; train \"{}\", {} wagons, {named} of them with a vehicle number",
        file.display(),
        settings.name,
        settings.wagons.len()
    ));
    Ok(())
}
