//! Making trains on disk.

use std::{
    fs,
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
};

use railgrip_truth_plant::train::{FaultWish, TrainOrder, TrainSpec, deck, files};

use super::labels::{Labels, Made, SCHEMA, sealed_folder, train_folder};
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
    /// Number of trains
    #[arg(long, default_value_t = 20)]
    trains: usize,
    /// Length of each train's day, h
    #[arg(long, default_value_t = 1.0)]
    hours: f64,
    /// Trains and faults follow from this; the salt of the seal does not
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Coupled trains only, of 4 to 64 wagons (default: four in five)
    #[arg(long, conflicts_with = "free")]
    coupled: bool,
    /// Single free wagons only
    #[arg(long)]
    free: bool,
    /// Samples a second: 20, 25, 50, 100 or 200. A bogie wagon takes about 18 MB an hour at 50
    #[arg(long, default_value_t = 50.0)]
    rate: f64,
    /// New folder for trains, truth, labels and seal
    #[arg(long)]
    out: PathBuf,
    /// Trains made at the same time (default: one a core)
    #[arg(long)]
    threads: Option<usize>,
}

pub(super) fn run(args: &Args) -> Result<(), CliError> {
    if args.trains == 0 {
        return Err(CliError::bad_input("--trains 0: at least one train is needed"));
    }
    let specs = specs(args)?;
    prepare(&args.out)?;
    let bar = progress("making trains", specs.len());
    let made = parallel(
        threads(args.threads),
        specs.len(),
        || true,
        |index| {
            let made = make(&args.out, &format!("train{index:04}"), specs[index].clone());
            bar.inc(1);
            made
        },
    );
    bar.finish_and_clear();
    let trains = made.into_iter().collect::<Result<Vec<Made>, CliError>>()?;
    if trains.len() != specs.len() {
        return Err(CliError::failed("a thread that made trains ended early"));
    }
    let labels = Labels { schema: SCHEMA.to_owned(), seed: args.seed, trains };
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

/// Draws all trains first: a wrong order is told before anything is written.
fn specs(args: &Args) -> Result<Vec<TrainSpec>, CliError> {
    let coupled = match (args.coupled, args.free) {
        (true, _) => Some(true),
        (_, true) => Some(false),
        _ => None,
    };
    let draw = |(seed, fault): (u64, FaultWish<'static>)| {
        let order =
            TrainOrder { coupled, hours: args.hours, rate_hz: args.rate, fault, ..TrainOrder::default() };
        TrainSpec::draw_to(seed, &order).map_err(CliError::bad_input)
    };
    deck(args.trains, args.seed, coupled).into_iter().map(draw).collect()
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
