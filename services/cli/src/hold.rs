//! `railgrip hold`: the process that creates the channels of a train and lives longest.

use std::time::Duration;

use railgrip_bus::{BusError, Holder};
use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use crate::train::TrainArgs;
use crate::{CliError, runner};

/// Create the channels of a train and keep them.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    train: TrainArgs,
    /// Wait so many seconds for an earlier holder of this train that is about to leave
    #[arg(long, value_name = "SECONDS", default_value_t = 1.0)]
    patience: f64,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let train = args.train.load()?;
    let patience = Duration::try_from_secs_f64(args.patience)
        .map_err(|_| CliError::bad_input(format!("--patience {}: allowed is 0 or more", args.patience)))?;
    let _span = tracing::info_span!("holder").entered();
    raise_file_limit();
    runner::run(|lifecycle| {
        let holder = Holder::start(train.bus, patience)?;
        tracing::info!(channels = holder.channels(), dir = %train.settings.instance.dir.display(), "channels exist");
        holder.run(lifecycle);
        Ok::<(), BusError>(())
    })
}

/// A channel takes about ten file descriptors; the usual soft limit of 1024 is too little for a long train.
pub(crate) fn raise_file_limit() {
    let limit = getrlimit(Resource::Nofile);
    let raised = Rlimit { current: limit.maximum, maximum: limit.maximum };
    if let Err(error) = setrlimit(Resource::Nofile, raised) {
        tracing::warn!(%error, "cannot raise the limit of open files");
    }
}
