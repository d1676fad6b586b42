//! `railgrip acoustics`: train the network that tells dry from wet rail by ear, ask it about recordings, and make
//! rolling noise. Nothing here needs a running train.

mod classify;
mod files;
mod synthesise;
mod train;

use crate::CliError;

/// Tell dry from wet rail by rolling noise: train, classify, synthesise.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Train a model, on synthesised noise or on recordings of a rig, and judge it on what it never heard
    Train(train::Args),
    /// Tell for every second of WAV recordings whether the rail is dry or wet
    Classify(classify::Args),
    /// Make WAV recordings of rolling noise
    Synthesise(synthesise::Args),
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    match &args.command {
        Command::Train(args) => train::run(args),
        Command::Classify(args) => classify::run(args),
        Command::Synthesise(args) => synthesise::run(args),
    }
}
