//! `railgrip hold`: the process that creates the channels of a train and lives longest.

use std::time::{Duration, Instant};

use railgrip_bus::{BusConfig, BusError, Holder, Lifecycle};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use crate::reload::{Member, Role};
use crate::train::TrainArgs;
use crate::{CliError, runner, supervisor};

/// How long one attempt to become the holder takes.
const RETRY: Duration = Duration::from_millis(50);

/// Create the channels of a train and keep them.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    train: TrainArgs,
    /// Seconds to wait for an earlier holder of this train that is ending
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0)]
    patience: f64,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let train = args.train.load()?;
    let patience = Duration::try_from_secs_f64(args.patience)
        .map_err(|_| CliError::bad_input(format!("--patience {}: allowed is 0 or more", args.patience)))?;
    let _span = tracing::info_span!("holder").entered();
    raise_file_limit();
    runner::run(Some(Member::of(&args.train, &train, Role::Holder)), |lifecycle| {
        let Some(holder) = start(&train.bus, patience, lifecycle)? else { return Ok(()) };
        if !supervisor::is_of_up()
            && let Err(error) = train.settings.instance.begin_session()
        {
            tracing::warn!(%error, "wagons without a vehicle number cannot be told from others");
        }
        tracing::info!(channels = holder.channels(), dir = %train.settings.instance.dir.display(), "channels exist");
        holder.run(lifecycle)
    })
}

/// Tries until the time is over; `None` if asked to stop meanwhile.
fn start(bus: &BusConfig, patience: Duration, lifecycle: &Lifecycle) -> Result<Option<Holder>, BusError> {
    let deadline = Instant::now() + patience;
    while !lifecycle.should_stop() {
        match Holder::start(bus.clone(), RETRY.min(patience)) {
            Err(BusError::AlreadyHeld { .. }) if Instant::now() < deadline => {}
            result => return result.map(Some),
        }
    }
    Ok(None)
}

/// A channel takes about ten file descriptors; the usual soft limit of 1024 is too little for a long train.
pub(crate) fn raise_file_limit() {
    let limit = getrlimit(Resource::Nofile);
    let raised = Rlimit { current: limit.maximum, maximum: limit.maximum };
    if let Err(error) = setrlimit(Resource::Nofile, raised) {
        tracing::warn!(%error, "cannot raise the limit of open files");
    }
}
