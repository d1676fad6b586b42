//! `railgrip check`: everything that is wrong with a config at once, and what it means where nothing is.

use std::path::{Path, PathBuf};

use railgrip_health::access::Access;
use railgrip_settings::{Overrides, TrainSettings, mistakes};

use crate::output::say;
use crate::{CliError, logging};

/// Checks the text of a config as completely as a start of the train does.
///
/// # Errors
/// All mistakes, each in words of its own.
pub(crate) fn completely(
    file: &Path,
    text: &str,
    overrides: &Overrides,
) -> Result<TrainSettings, Vec<String>> {
    let found = mistakes(file, text, overrides);
    if !found.is_empty() {
        return Err(found.iter().map(ToString::to_string).collect());
    }
    let settings = TrainSettings::parse(file, text, overrides).map_err(|error| vec![error.to_string()])?;
    let more = [
        Access::check(&settings).err().map(|error| error.to_string()),
        logging::check(&settings.logging.level).err().map(|error| format!("{}: {error}", file.display())),
    ];
    let more: Vec<String> = more.into_iter().flatten().collect();
    if more.is_empty() { Ok(settings) } else { Err(more) }
}

/// Check a config: all mistakes at once.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// Config of a train
    #[arg(value_name = "CONFIG")]
    config: PathBuf,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let file = &args.config;
    let (_, text) = TrainSettings::text(Some(file))?;
    let settings = completely(file, &text, &Overrides::default()).map_err(|found| {
        let number = found.len();
        let noun = if number == 1 { "mistake" } else { "mistakes" };
        CliError::bad_input(format!("{number} {noun}\n{}", found.join("\n")))
    })?;
    let named = settings.wagons.iter().filter(|wagon| wagon.vehicle_number.is_some()).count();
    say(&format!(
        "{}: sound; train \"{}\", {} wagons, {named} of them with a vehicle number",
        file.display(),
        settings.name,
        settings.wagons.len()
    ));
    Ok(())
}
