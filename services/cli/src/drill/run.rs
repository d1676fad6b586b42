//! `railgrip drill --trains N`: many trains under the watch, and the score of its alerts.

use std::path::PathBuf;
use std::sync::Mutex;

use railgrip_causes::WagonFile;
use railgrip_truth_plant::train::{TrainOrder, TrainSpec, deck, files};

use super::believed::believed;
use super::drive::drive;
use super::report::markdown;
use super::score::Score;
use crate::CliError;
use crate::sealed::{
    files::write,
    parallel::{parallel, progress, threads},
};

/// Arguments of a drill.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Number of trains
    #[arg(long, default_value_t = 20)]
    trains: usize,
    /// Length of each train's day, h
    #[arg(long, default_value_t = 1.0)]
    hours: f64,
    /// Trains and faults follow from this
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Coupled trains only, of 4 to 64 wagons (default: four in five)
    #[arg(long, conflicts_with = "free")]
    coupled: bool,
    /// Single free wagons only
    #[arg(long)]
    free: bool,
    /// Leave out trains with more wagons, which take longest
    #[arg(long, default_value_t = 64)]
    most_wagons: usize,
    /// Samples a second: 20, 25, 50, 100 or 200
    #[arg(long, default_value_t = 50.0)]
    rate: f64,
    /// Folder for score.md and alerts.txt
    #[arg(long)]
    out: Option<PathBuf>,
    /// Trains at the same time (default: one a core)
    #[arg(long)]
    threads: Option<usize>,
}

/// Runs the drill. The watch gets readings and the files of the wagons, nothing else.
pub(super) fn run(args: &Args) -> Result<(), CliError> {
    let Some(out) = &args.out else { return Err(CliError::bad_input("--out DIR is missing")) };
    let coupled = match (args.coupled, args.free) {
        (true, _) => Some(true),
        (_, true) => Some(false),
        _ => None,
    };
    let deck = deck(args.trains, args.seed, coupled);
    let bar = progress("driving trains", deck.len());
    let score = Mutex::new(Ok((Score::default(), String::new())));
    parallel(
        threads(args.threads),
        deck.len(),
        || true,
        |index| {
            let (seed, fault) = deck[index];
            let order =
                TrainOrder { coupled, hours: args.hours, rate_hz: args.rate, fault, ..TrainOrder::default() };
            let driven = TrainSpec::draw_to(seed, &order)
                .map_err(CliError::bad_input)
                .and_then(|spec| one(index, spec, args.most_wagons));
            bar.inc(1);
            let mut score = score.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            match (driven, &mut *score) {
                (Ok(Some(driven)), Ok((score, lines))) => {
                    lines.push_str(&super::report::lines(&driven));
                    score.take(&driven);
                }
                (Err(error), whole @ Ok(_)) => *whole = Err(error),
                _ => {}
            }
        },
    );
    bar.finish_and_clear();
    let (score, lines) = score.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner)?;
    let kind = if args.free {
        " --free"
    } else if args.coupled {
        " --coupled"
    } else {
        ""
    };
    let command = format!(
        "railgrip drill --trains {} --hours {} --seed {}{kind} --most-wagons {}",
        args.trains, args.hours, args.seed, args.most_wagons
    );
    let text = markdown(&score, &command);
    write(&out.join("score.md"), &text)?;
    write(&out.join("alerts.txt"), &lines)?;
    crate::output::say(&text);
    Ok(())
}

/// One train, unless it has too many wagons.
fn one(index: usize, spec: TrainSpec, most: usize) -> Result<Option<super::drive::Driven>, CliError> {
    if spec.wagons.len() > most {
        return Ok(None);
    }
    // The watch reads what a recording's folder would hold, so that nothing else can reach it.
    let file = |wagon| -> Result<WagonFile, CliError> {
        let text = files::vehicle_toml(wagon, &spec);
        let vehicle = toml::from_str(&text).map_err(CliError::failed)?;
        Ok(believed(&vehicle))
    };
    let believed = spec.wagons.iter().map(file).collect::<Result<Vec<_>, _>>()?;
    Ok(Some(drive(&format!("train{index:04}"), spec, believed)))
}
