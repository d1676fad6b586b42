//! `railgrip drill --trains N`: many trains under the watch, and the score of its alerts.

use std::path::PathBuf;
use std::sync::Mutex;

use railgrip_causes::WagonFile;
use railgrip_judge::believed;
use railgrip_truth_plant::train::{TrainSpec, files};

use super::drive::drive;
use super::order::Order;
use super::plot;
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
    #[command(flatten)]
    order: Order,
    /// Leave out trains with more wagons, which take longest
    #[arg(long, default_value_t = 64)]
    most_wagons: usize,
    /// Only the train of this number in alerts.txt, from 0, drawn as among all of them
    #[arg(long, value_name = "NUMBER")]
    only: Option<usize>,
    /// Folder for score.md, alerts.txt, delay.svg and confusion.svg
    #[arg(long)]
    out: Option<PathBuf>,
}

/// Runs the drill. The watch gets readings and the files of the wagons, nothing else.
pub(super) fn run(args: &Args) -> Result<(), CliError> {
    let Some(out) = &args.out else { return Err(CliError::bad_input("--out DIR is missing")) };
    let deck = args.order.deck()?;
    let chosen: Vec<usize> =
        (0..deck.len()).filter(|index| args.only.is_none_or(|only| only == *index)).collect();
    if let Some(only) = args.only.filter(|_| chosen.is_empty()) {
        return Err(CliError::bad_input(format!("--only {only}: there are {} trains, from 0", deck.len())));
    }
    let bar = progress("driving trains", chosen.len());
    let score = Mutex::new(Ok((Score::default(), String::new())));
    parallel(
        threads(args.order.threads),
        chosen.len(),
        || true,
        |place| {
            let index = chosen[place];
            let driven = args.order.draw(deck[index]).and_then(|spec| one(index, spec, args.most_wagons));
            bar.inc();
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
    bar.finish();
    let (score, lines) = score.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner)?;
    let only = args.only.map_or_else(String::new, |only| format!(" --only {only}"));
    let command = format!("railgrip drill {} --most-wagons {}{only}", args.order.words(), args.most_wagons);
    let text = markdown(&score, &command);
    write(&out.join("score.md"), &text)?;
    write(&out.join("alerts.txt"), &lines)?;
    plot::delays(&score, &out.join("delay.svg"))?;
    plot::confusion(&score, &out.join("confusion.svg"))?;
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
