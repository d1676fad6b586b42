//! `railgrip record`: what a running train measures and estimates, as files.
//!
//! `DIR/NAME.csv` holds the samples of a wagon or rig in the columns of a recording, so that every tool can take it as a run;
//! `DIR/estimates/NAME.csv` holds its estimates in the columns of `railgrip estimate`. When the time base of a wagon
//! begins again (a replay that loops, a new source), a new pair of files begins: `NAME-2.csv`, `NAME-3.csv`, ...

mod estimates;
mod wagon;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use railgrip_bus::{Bus, Lifecycle};
use railgrip_messages::{NO_WAGON, ProcessKind};

use crate::output::say;
use crate::train::{Train, TrainArgs};
use crate::{CliError, hold, runner};
use wagon::WagonRecorder;

/// How often the channels are emptied; their buffers hold several times as much.
const POLL: Duration = Duration::from_millis(20);
const CHECK_HOLDER_PERIOD: Duration = Duration::from_millis(500);

/// Write what a running train measures to recordings.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    train: TrainArgs,
    /// Folder for the recordings; created if it is missing
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// End by itself after so many seconds
    #[arg(long = "for", value_name = "SECONDS")]
    seconds: Option<f64>,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let span = match args.seconds.map(Duration::try_from_secs_f64) {
        None => None,
        Some(Ok(seconds)) => Some(seconds),
        Some(Err(_)) => return Err(CliError::bad_input("--for: allowed is a number of seconds, 0 or more")),
    };
    let train = args.train.load()?;
    hold::raise_file_limit();
    runner::run(None, |lifecycle| record(&train, args, span, lifecycle))
}

fn record(train: &Train, args: &Args, span: Option<Duration>, lifecycle: &Lifecycle) -> Result<(), CliError> {
    let bus = Bus::open(train.bus.clone(), ProcessKind::Record, NO_WAGON)?;
    let estimates = args.out.join("estimates");
    std::fs::create_dir_all(&estimates)
        .map_err(|error| CliError::bad_input(format!("{}: {error}", estimates.display())))?;
    let mut wagons = train
        .settings
        .wagons
        .iter()
        .map(|wagon| WagonRecorder::open(&bus, wagon.number, wagon.plant.kind(), &wagon.name, &args.out))
        .collect::<Result<Vec<_>, _>>()?;
    lifecycle.ready();
    tracing::info!(wagons = wagons.len(), out = %args.out.display(), "recording");
    let started = Instant::now();
    let mut checked = started;
    let mut outcome = Ok(());
    while !lifecycle.should_stop() && span.is_none_or(|span| started.elapsed() < span) {
        std::thread::sleep(POLL);
        wagons.iter_mut().try_for_each(WagonRecorder::take)?;
        lifecycle.beat();
        if checked.elapsed() >= CHECK_HOLDER_PERIOD {
            checked = Instant::now();
            outcome = bus.check_holder().map_err(CliError::from);
            if outcome.is_err() {
                break;
            }
        }
    }
    for wagon in wagons {
        say(&wagon.finish()?);
    }
    outcome
}
