//! Making trains on disk.

use std::{
    fs,
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
};

use railgrip_truth_plant::train::{TrainSpec, files};

use super::labels::{Labels, Made, SCHEMA, sealed_folder, train_folder};
use super::order::Order;
use crate::CliError;
use crate::sealed::{
    digest::digest_of_folder,
    files::cannot_write,
    parallel::{parallel, progress, threads},
    seal::{Sealed, random_salt},
};

/// Arguments of `railgrip drill make`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    order: Order,
    /// New folder for trains, truth, labels and seal
    #[arg(long)]
    out: PathBuf,
}

pub(super) fn run(args: &Args) -> Result<(), CliError> {
    // Draws all trains first: a wrong order is told before anything is written.
    let deck = args.order.deck()?;
    let specs = deck.into_iter().map(|card| args.order.draw(card)).collect::<Result<Vec<_>, _>>()?;
    prepare(&args.out)?;
    let bar = progress("making trains", specs.len());
    let made = parallel(
        threads(args.order.threads),
        specs.len(),
        || true,
        |index| {
            let made = make(&args.out, &format!("train{index:04}"), specs[index].clone());
            bar.inc();
            made
        },
    );
    bar.finish();
    let trains = made.into_iter().collect::<Result<Vec<Made>, CliError>>()?;
    if trains.len() != specs.len() {
        return Err(CliError::failed("a thread that made trains ended early"));
    }
    let labels = Labels { schema: SCHEMA.to_owned(), seed: args.order.seed, trains };
    let sealed = Sealed::new(random_salt()?, &labels)?;
    sealed.open(&sealed_folder(&args.out))?;
    sealed.publish(&args.out)?;
    crate::output::say(&format!(
        "{} trains in {}; keep {} away from who judges them",
        labels.trains.len(),
        args.out.join("trains").display(),
        sealed_folder(&args.out).display()
    ));
    Ok(())
}

/// A new folder, and in it one that only its owner may read.
fn prepare(out: &Path) -> Result<(), CliError> {
    if out.join("trains").exists() || sealed_folder(out).exists() {
        let text = format!("--out {}: holds trains already; name a new folder", out.display());
        return Err(CliError::bad_input(text));
    }
    let sealed = sealed_folder(out);
    fs::create_dir_all(&sealed).map_err(|error| cannot_write(&sealed, &error))?;
    fs::set_permissions(&sealed, fs::Permissions::from_mode(0o700))
        .map_err(|error| cannot_write(&sealed, &error))
}

fn make(out: &Path, name: &str, spec: TrainSpec) -> Result<Made, CliError> {
    let folder = train_folder(out, name);
    let truth = sealed_folder(out).join("truth").join(name);
    let label = files::write_train(name, &folder, &truth, spec).map_err(CliError::failed)?;
    Ok(Made { label, train_sha256: digest_of_folder(&folder)? })
}
