//! Opening the seal.

use std::path::PathBuf;

use super::labels::{Labels, SCHEMA, sealed_folder, train_folder};
use crate::CliError;
use crate::sealed::{digest::digest_of_folder, seal::Sealed};

/// Arguments of `railgrip drill open`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folder that `drill make` filled
    #[arg(long)]
    out: PathBuf,
}

/// Checks labels against the published hash and trains against the labels, then lays salt and labels open.
pub(super) fn run(args: &Args) -> Result<(), CliError> {
    let sealed = Sealed::read(&sealed_folder(&args.out))?;
    sealed.check(&args.out)?;
    let labels: Labels = serde_json::from_str(sealed.labels()).map_err(CliError::failed)?;
    if labels.schema != SCHEMA {
        return Err(CliError::bad_input(format!("labels of form {}, known is {SCHEMA}", labels.schema)));
    }
    for made in &labels.trains {
        let folder = train_folder(&args.out, &made.label.train);
        if digest_of_folder(&folder)? != made.train_sha256 {
            let text = format!("the seal is broken: {} is not as it was made", folder.display());
            return Err(CliError::failed(text));
        }
    }
    sealed.open(&args.out)?;
    let faults = labels.trains.iter().filter(|made| made.label.fault.is_some()).count();
    crate::output::say(&format!(
        "the seal {} holds: {} trains, {faults} with a fault, {:.1} train-hours",
        sealed.digest(),
        labels.trains.len(),
        labels.trains.iter().map(|made| made.label.hours).sum::<f64>()
    ));
    Ok(())
}
