//! `railgrip bench --source`: a million samples through each live source, by a real ingest into real estimators. Each sample
//! arrives, or the run says under which name it was counted; the processor time stands beside that of the same train whose samples
//! come without an ingest.

mod config;
mod kill;
mod report;
mod senders;

use std::time::{Duration, Instant};

use crate::bench_up::{self, Up};
use crate::{CliError, process_figures as figures};
use config::{Kind, Kinds, RATE_HZ, WAGONS};
use report::{Ledger, Line};
use senders::Sender;

pub(crate) use report::{Report, show};

/// Until the first sample, and after the last: heartbeats carry the counts once a second.
const SETTLE: Duration = Duration::from_millis(2500);
/// Processor time is not watched in the first and last moments.
const EDGE: Duration = Duration::from_secs(1);

/// What to measure.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct Options {
    /// Measure what arrives of a million samples from a live source instead: stdin, tcp, udp, mqtt, can (a log), trdp, external, or all
    #[arg(long, value_name = "KIND", num_args = 0..=1, default_missing_value = "all", value_parser = Kind::named)]
    source: Option<Kinds>,
    /// Samples of each source
    #[arg(long, value_name = "NUMBER", requires = "source", default_value_t = 1_000_000)]
    samples: u32,
    /// Kill ingest so often meanwhile; where it reads a log or is not there, nobody is killed
    #[arg(long, value_name = "TIMES", requires = "source", default_value_t = 0)]
    kills: u32,
}

impl Options {
    /// True if this is what to measure.
    pub fn wanted(&self) -> bool {
        self.source.is_some()
    }
}

/// Measures the sources one after another.
pub(crate) fn run(options: &Options) -> Result<Report, CliError> {
    let kinds = match options.source {
        Some(Kinds::One(kind)) => vec![kind],
        _ => Kind::ALL.to_vec(),
    };
    let ticks = (options.samples / WAGONS as u32).max(RATE_HZ);
    // What everything but the source costs, and nobody loses anything.
    let reference = measure(Kind::External, ticks, 0)?;
    let mut lines = Vec::new();
    for kind in kinds {
        if let Some(missing) = kind.missing() {
            lines.push(Line::skipped(kind.name(), missing));
        } else if kind == Kind::External {
            lines.push(reference.clone());
        } else {
            lines.push(measure(kind, ticks, options.kills)?);
        }
    }
    Ok(Report {
        wagons: WAGONS,
        samples_a_second_and_wagon: RATE_HZ,
        reference_cpu_percent: reference.cpu_percent,
        lines,
    })
}

fn measure(kind: Kind, ticks: u32, kills: u32) -> Result<Line, CliError> {
    let place = config::Place::free(kind)?;
    let mut up = Up::start("rgs", |folder| config::prepare(kind, &place, folder, ticks), kind.input())?;
    let mut sender = senders::open(kind, &place, &mut up)?;
    let there = |process| bench_up::count(&up, process);
    let ingests = usize::from(kind != Kind::External);
    up.wait("the processes of the train do not come up", || {
        there("estimator") == WAGONS && there("ingest") == ingests
    })?;
    std::thread::sleep(SETTLE);
    let lasts = Duration::from_millis(u64::from(ticks) * 1000 / u64::from(RATE_HZ));
    let kills = if kind.can_lose_ingest() { kills } else { 0 };
    let watched = lasts.saturating_sub(EDGE * 2).max(EDGE);
    let id = up.id();
    let (sent, groups, cpu_percent) = std::thread::scope(|scope| {
        let watching = scope.spawn(move || {
            std::thread::sleep(EDGE);
            figures::watch(id, watched)
        });
        let killing = scope.spawn(move || kill::ingest(id, kills, lasts));
        let sent = send(&mut *sender, ticks);
        let watched = watching.join().map_err(|_| CliError::failed("watching the processes has failed"))?;
        killing.join().map_err(|_| CliError::failed("killing ingest has failed"))?;
        Ok::<_, CliError>((sent?, watched.0, watched.1))
    })?;
    let ledger = Ledger::settled(&up, SETTLE)?;
    drop(sender);
    let ingest = groups.iter().find(|group| group.role == "ingest").map_or(0.0, |group| group.cpu_percent);
    Ok(Line::new(kind.name(), sent, kills, &ledger, cpu_percent, ingest))
}

/// Sends a sample of every wagon in each tick, in step with the clock; says how many.
fn send(sender: &mut dyn Sender, ticks: u32) -> Result<u64, CliError> {
    let began = Instant::now();
    let mut sent = 0;
    for tick in 0..ticks {
        let due = began + Duration::from_secs(1) / RATE_HZ * tick;
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        sent += sender.send(tick)?;
    }
    Ok(sent)
}
