//! The command line of railgrip: one binary, one module a subcommand.
//!
//! `up` supervises; `hold`, `ingest`, `estimator` and `health` are the processes that it (or systemd) starts; the rest
//! are tools. Exit codes: 0 done, 1 failed, 2 bad input or config.

mod acoustics;
mod bench;
mod bench_acoustics;
mod bench_gap;
mod bench_history;
mod bench_http;
mod bench_line;
mod bench_source;
mod bench_train;
mod bench_transport;
mod bench_unscented;
mod bench_up;
mod blind;
mod check;
mod check_files;
mod completions;
mod diagnoser;
mod drill;
mod error;
mod estimate;
mod estimate_columns;
mod estimate_sheet;
mod experiment;
mod gap;
mod gap_calibrate;
mod gap_compare;
mod gap_plan;
mod gap_prepare;
mod gap_settle;
mod gap_shared;
mod history;
mod hold;
mod load;
mod local_http;
mod logging;
mod manuals;
mod map;
mod output;
mod own_effects;
mod payloads;
mod process_figures;
mod record;
mod reference;
mod reload;
mod runner;
mod sealed;
mod services;
mod simulate;
mod simulate_rig;
mod status;
mod supervisor;
mod token;
mod train;
mod up;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{CommandFactory, Parser, Subcommand};

pub use error::CliError;

/// Version and the commit that the program is built from.
const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), " (commit ", env!("RAILGRIP_COMMIT"), ")");

/// Brake friction and adhesion of every wagon of a train, live and from recordings.
#[derive(Debug, Parser)]
#[command(name = "railgrip", version = VERSION, propagate_version = true, max_term_width = 120)]
struct Cli {
    /// File with effects of your own: the diagnosis tries them, vehicle files may name them [env: RAILGRIP_EFFECTS]
    #[arg(long, value_name = "FILE", global = true)]
    effects: Option<PathBuf>,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Start a whole train, supervised: holder, ingest, one estimator a wagon, HTTP service
    ///
    /// On SIGHUP it reads its config again, checked as at a start: what can be taken over is, the other processes that are touched
    /// start again one after another, and a config that is wrong changes nothing. `railgrip reference` says which key does what.
    Up(up::Args),
    /// Create the channels of a train and keep them (started first, lives longest)
    Hold(hold::Args),
    /// Bring samples onto the channels
    Ingest(services::IngestArgs),
    /// Estimate one wagon
    Estimator(services::EstimatorArgs),
    /// Listen to the microphone of one wagon
    Listener(services::ListenerArgs),
    /// Judge all wagons of a coupled train together
    Judge(services::JudgeArgs),
    /// Diagnose by itself what the model does not explain on a running train
    Diagnoser(diagnoser::Args),
    /// Serve the indicators over HTTP
    Health(services::HealthArgs),
    /// Check a config: all mistakes at once
    Check(check::Args),
    /// Propose a [mapping] for a recording with columns of its own
    Map(map::Args),
    /// Print the payloads of the channels for C, C++ or Python
    Payloads(payloads::Args),
    /// Print completions for a shell
    Completions(completions::Args),
    /// Print every key of a config, with what it takes and its default
    Reference(reference::Args),
    /// Write the manual pages
    Manuals(manuals::Args),
    /// Show what the HTTP service of a running train says
    Status(status::Args),
    /// Make, list and end tokens of the HTTP service
    Token(token::Args),
    /// Export what a train remembers to CSV or Parquet
    History(history::Args),
    /// Write what a running train measures to recordings
    Record(record::Args),
    /// Estimate adhesion and pad friction of a recording
    Estimate(estimate::Args),
    /// Run a published experiment, with its table and its figures
    Experiment(experiment::Args),
    /// Tell dry from wet rail by rolling noise: train, classify, synthesise
    Acoustics(acoustics::Args),
    /// Measure the speed of the parts on this machine
    Bench(bench::Args),
    /// The other end of `railgrip bench --transport`
    #[command(hide = true)]
    BenchPeer(bench_transport::PeerArgs),
    /// Diagnose the gap between simulator and recordings
    Gap(gap::Args),
    /// Make sealed trains with faults, to judge alarms with
    Drill(drill::Args),
    /// Turn a scenario into recordings, with the truth beside them
    Simulate(simulate::Args),
}

impl Command {
    fn run(self) -> Result<(), CliError> {
        match self {
            Self::Up(args) => up::run(&args),
            Self::Hold(args) => hold::run(&args),
            Self::Ingest(args) => services::ingest(&args),
            Self::Estimator(args) => services::estimator(&args),
            Self::Listener(args) => services::listener(&args),
            Self::Judge(args) => services::judge(&args),
            Self::Diagnoser(args) => diagnoser::run(&args),
            Self::Health(args) => services::health(&args),
            Self::Check(args) => check::run(&args),
            Self::Map(args) => map::run(&args),
            Self::Payloads(args) => payloads::run(&args),
            Self::Completions(args) => {
                completions::run(&args, &mut Cli::command());
                Ok(())
            }
            Self::Reference(args) => reference::run(&args),
            Self::Manuals(args) => manuals::run(&args, Cli::command()),
            Self::Status(args) => status::run(&args),
            Self::Token(args) => token::run(&args),
            Self::History(args) => history::run(&args),
            Self::Record(args) => record::run(&args),
            Self::Estimate(args) => estimate::run(&args),
            Self::Experiment(args) => experiment::run(&args),
            Self::Acoustics(args) => acoustics::run(&args),
            Self::Bench(args) => bench::run(&args),
            Self::BenchPeer(args) => bench_transport::peer(&args),
            Self::Gap(args) => gap::run(&args),
            Self::Drill(args) => drill::run(&args),
            Self::Simulate(args) => simulate::run(&args),
        }
    }
}

/// Entry point of the binary.
#[must_use]
pub fn main() -> ExitCode {
    let cli = Cli::parse();
    let done = own_effects::read(cli.effects.as_deref()).and_then(|()| cli.command.run());
    match done.and_then(|()| output::whole()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            output::complain(&error);
            error.exit_code()
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;

    #[test]
    fn the_command_tree_is_consistent() {
        super::Cli::command().debug_assert();
    }

    #[test]
    fn the_version_names_the_commit() {
        let (version, commit) = super::VERSION.split_once(" (commit ").expect("a commit");
        let commit = commit.strip_suffix(')').expect("an end");
        let is_hash = commit.len() >= 7 && commit.bytes().all(|byte| byte.is_ascii_hexdigit());
        assert_eq!(version, env!("CARGO_PKG_VERSION"));
        assert!(is_hash || commit == "unknown", "{commit}");
    }
}
