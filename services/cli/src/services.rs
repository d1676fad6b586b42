//! The processes of the data path, each as `up` or systemd starts it.

use railgrip_health::access::Access;
use railgrip_health::shared::Build;

use crate::reload::{Member, Role};
use crate::train::TrainArgs;
use crate::{CliError, runner, supervisor};

/// Bring samples onto the channels.
#[derive(Debug, clap::Args)]
pub(crate) struct IngestArgs {
    #[command(flatten)]
    train: TrainArgs,
}

/// Estimate one wagon.
#[derive(Debug, clap::Args)]
pub(crate) struct EstimatorArgs {
    #[command(flatten)]
    train: TrainArgs,
    /// Number of the wagon, 1 first
    #[arg(long, value_name = "N")]
    wagon: u32,
}

/// Listen to the microphone of one wagon.
#[derive(Debug, clap::Args)]
pub(crate) struct ListenerArgs {
    #[command(flatten)]
    train: TrainArgs,
    /// Number of the wagon, 1 first
    #[arg(long, value_name = "N")]
    wagon: u32,
}

/// Judge all wagons of a coupled train together.
#[derive(Debug, clap::Args)]
pub(crate) struct JudgeArgs {
    #[command(flatten)]
    train: TrainArgs,
}

/// Serve the indicators over HTTP.
#[derive(Debug, clap::Args)]
pub(crate) struct HealthArgs {
    #[command(flatten)]
    train: TrainArgs,
}

pub(crate) fn ingest(args: &IngestArgs) -> Result<(), CliError> {
    let train = args.train.load()?;
    let _span = tracing::info_span!("ingest").entered();
    runner::run(Some(Member::of(&args.train, &train, Role::Ingest)), |lifecycle| {
        railgrip_ingest::run(&train.settings, lifecycle)
    })
}

pub(crate) fn estimator(args: &EstimatorArgs) -> Result<(), CliError> {
    let train = args.train.load()?;
    if train.settings.wagon(args.wagon).is_none() {
        let count = train.settings.wagons.len();
        return Err(CliError::bad_input(format!("--wagon {}: allowed is 1 to {count}", args.wagon)));
    }
    let _span = tracing::info_span!("estimator", wagon = args.wagon).entered();
    runner::run(Some(Member::of(&args.train, &train, Role::Estimator(args.wagon))), |lifecycle| {
        railgrip_estimator::run(&train.settings, args.wagon, lifecycle)
    })
}

pub(crate) fn listener(args: &ListenerArgs) -> Result<(), CliError> {
    let train = args.train.load()?;
    let _span = tracing::info_span!("listener", wagon = args.wagon).entered();
    runner::run(Some(Member::of(&args.train, &train, Role::Listener(args.wagon))), |lifecycle| {
        railgrip_listener::run(&train.settings, args.wagon, lifecycle)
    })
}

pub(crate) fn judge(args: &JudgeArgs) -> Result<(), CliError> {
    let train = args.train.load()?;
    if !train.settings.judged_together {
        return Err(CliError::bad_input(
            "this train is not coupled: set [train] coupled = true, or [train] free = false in every vehicle file",
        ));
    }
    let _span = tracing::info_span!("judge").entered();
    runner::run(Some(Member::of(&args.train, &train, Role::Judge)), |lifecycle| {
        railgrip_judge::run(&train.settings, lifecycle)
    })
}

/// What the metrics say of this program.
const BUILD: Build = Build { version: env!("CARGO_PKG_VERSION"), commit: env!("RAILGRIP_COMMIT") };

pub(crate) fn health(args: &HealthArgs) -> Result<(), CliError> {
    let train = args.train.load()?;
    // Whoever calls by hand hears at once what is wrong. A supervisor shall try again: a certificate may be in the middle
    // of being replaced, and the rest of the train does not depend on it.
    if !supervisor::is_supervised() {
        Access::check(&train.settings).map_err(CliError::bad_input)?;
    }
    let _span = tracing::info_span!("health").entered();
    runner::run(Some(Member::of(&args.train, &train, Role::Health)), |lifecycle| {
        railgrip_health::run(&train.settings, lifecycle, BUILD)
    })
}
