//! `railgrip bench --transport`: how long a batch of samples takes from ingest to its estimates, beside a bare iceoryx2
//! ping of the same payload and wake-up, in turns in the same run.
//!
//! This process is holder and ingest; a real `railgrip estimator` and a bare receiver are its children.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use railgrip_bus::{Bus, BusConfig, EstimateSubscriber, Holder, SamplePublisher, bare, now};
use railgrip_messages::{ProcessKind, Sample, valid};
use railgrip_settings::{Overrides, TrainSettings};

use crate::output::say;
use crate::train::TrainArgs;
use crate::{CliError, hold};

/// Batches of one line, on each way.
const BATCHES: usize = 2000;
/// Batches before the count begins: caches and pages get warm.
const WARM_UP: usize = 200;
/// Time between two sends.
const PERIOD: Duration = Duration::from_micros(700);
const START_PATIENCE: Duration = Duration::from_secs(10);

/// Receive bare batches and print their ages (a part of `railgrip bench --transport`).
#[derive(Debug, clap::Args)]
pub(crate) struct PeerArgs {
    #[command(flatten)]
    train: TrainArgs,
    /// Batches to receive
    #[arg(long)]
    batches: usize,
}

/// The bare receiver.
pub(crate) fn peer(args: &PeerArgs) -> Result<(), CliError> {
    let train = args.train.load()?;
    let bus = Bus::open(train.bus, ProcessKind::Record, 0)?;
    let ages_ns = bare::receive(&bus, args.batches)?;
    ages_ns.iter().for_each(|age_ns| say(&age_ns.to_string()));
    Ok(())
}

/// One line of the table, µs.
#[derive(Debug, serde::Serialize)]
pub(crate) struct Line {
    samples_a_batch: usize,
    estimate_p50_us: f64,
    estimate_p99_us: f64,
    bare_p50_us: f64,
    bare_p99_us: f64,
    ratio_p50: f64,
}

/// Measures batches of 1 and of 10 samples.
pub(crate) fn run() -> Result<Vec<Line>, CliError> {
    let folder = std::env::temp_dir().join(format!("rgb{}", std::process::id()));
    let result = measure_in(&folder);
    let _ = std::fs::remove_dir_all(&folder);
    result
}

/// The table for people.
pub(crate) fn show(lines: &[Line]) {
    say("from ingest to estimate            p50 µs   p99 µs   bare ping p50 µs   p99 µs   ratio of p50");
    for line in lines {
        say(&format!(
            "batches of {:<3} samples            {:>7.1}  {:>7.1}            {:>7.1}  {:>7.1}        {:>7.2}",
            line.samples_a_batch,
            line.estimate_p50_us,
            line.estimate_p99_us,
            line.bare_p50_us,
            line.bare_p99_us,
            line.ratio_p50
        ));
    }
}

fn measure_in(folder: &Path) -> Result<Vec<Line>, CliError> {
    let overrides = Overrides { instance_dir: Some(folder.to_owned()), ..Overrides::default() };
    let settings = TrainSettings::load(None, &overrides)?;
    hold::raise_file_limit();
    let config = BusConfig::of(&settings);
    let holder = Holder::start(config.clone(), Duration::ZERO)?;
    let bus = Bus::open(config, ProcessKind::Ingest, 0)?;
    let lines = [1, 10].into_iter().map(|samples| line(&bus, folder, samples)).collect();
    drop((bus, holder));
    lines
}

fn line(bus: &Bus, folder: &Path, samples_a_batch: usize) -> Result<Line, CliError> {
    let publisher = bus.sample_publisher(1)?;
    let mut estimates = bus.estimate_subscriber(1)?;
    let sender = bare::BareSender::create(bus)?;
    let mut estimator = child(folder, &["estimator", "--wagon", "1"], Stdio::null())?;
    let count = (BATCHES + WARM_UP).to_string();
    let receiver = child(folder, &["bench-peer", "--batches", &count], Stdio::piped())?;
    let result = await_both(&publisher, &mut estimates, samples_a_batch)
        .and_then(|source| send_in_turns(source, &publisher, &mut estimates, &sender));
    let output = receiver.wait_with_output().map_err(CliError::failed)?;
    let _ = estimator.kill();
    let _ = estimator.wait();
    let estimate_ns = result?;
    let bare_ns =
        String::from_utf8_lossy(&output.stdout).lines().filter_map(|line| line.parse().ok()).collect();
    let (estimate, bare) = (percentiles_us("estimates", estimate_ns)?, percentiles_us("the ping", bare_ns)?);
    Ok(Line {
        samples_a_batch,
        estimate_p50_us: estimate.0,
        estimate_p99_us: estimate.1,
        bare_p50_us: bare.0,
        bare_p99_us: bare.1,
        ratio_p50: estimate.0 / bare.0,
    })
}

fn child(folder: &Path, words: &[&str], stdout: Stdio) -> Result<Child, CliError> {
    let program = std::env::current_exe().map_err(CliError::failed)?;
    let mut command = Command::new(program);
    command.args(words).arg("--instance").arg(folder).env("RAILGRIP_LOG", "warn");
    command.stdin(Stdio::null()).stdout(stdout).spawn().map_err(CliError::failed)
}

/// Samples of a wagon that rolls at 20 m/s.
struct Rolling {
    sequence: u64,
    batch: Vec<Sample>,
}

impl Rolling {
    fn next(&mut self) -> &[Sample] {
        let stamp = now();
        for sample in &mut self.batch {
            sample.sequence = self.sequence;
            sample.time_s = self.sequence as f64 * 1e-3;
            sample.acquired = stamp;
            // Samples of one batch must not look like one sample twice.
            sample.acquired.monotonic_ns = stamp.monotonic_ns + self.sequence % 16;
            self.sequence += 1;
        }
        &self.batch
    }
}

/// Sends until estimates come back: then the estimator is up. The receiver of the ping was started with it.
fn await_both(
    publisher: &SamplePublisher,
    estimates: &mut EstimateSubscriber,
    samples_a_batch: usize,
) -> Result<Rolling, CliError> {
    let sample = Sample {
        v_m_s: 20.0,
        wheel_speed_rad_s: [20.0 / 0.44, 20.0 / 0.44, 0.0, 0.0],
        wheelsets: 2,
        valid: valid::SPEED
            | valid::wheel_speed(0)
            | valid::wheel_speed(1)
            | valid::pressing_force(0)
            | valid::pressing_force(1)
            | valid::drive_torque(0)
            | valid::drive_torque(1),
        ..Sample::default()
    };
    let mut source = Rolling { sequence: 0, batch: vec![sample; samples_a_batch] };
    let started = Instant::now();
    while started.elapsed() < START_PATIENCE {
        publisher.publish(source.next())?;
        std::thread::sleep(Duration::from_millis(20));
        if estimates.receive(|_| {})? > 0 {
            std::thread::sleep(Duration::from_millis(500));
            return Ok(source);
        }
    }
    Err(CliError::failed("the estimator sends no estimates"))
}

fn send_in_turns(
    mut source: Rolling,
    publisher: &SamplePublisher,
    estimates: &mut EstimateSubscriber,
    sender: &bare::BareSender,
) -> Result<Vec<u64>, CliError> {
    let mut ages_ns = Vec::with_capacity(BATCHES);
    for round in 0..BATCHES + WARM_UP {
        publisher.publish(source.next())?;
        std::thread::sleep(PERIOD);
        estimates.receive(|batch| {
            if let Some(last) = batch.last()
                && round >= WARM_UP
            {
                ages_ns.push(last.published_monotonic_ns.saturating_sub(last.acquired.monotonic_ns));
            }
        })?;
        sender.send(source.next())?;
        std::thread::sleep(PERIOD);
    }
    Ok(ages_ns)
}

/// 50th and 99th percentile, µs.
fn percentiles_us(way: &str, mut ages_ns: Vec<u64>) -> Result<(f64, f64), CliError> {
    if ages_ns.len() < BATCHES / 2 {
        return Err(CliError::failed(format!(
            "only {} of {BATCHES} batches of {way} arrived",
            ages_ns.len()
        )));
    }
    ages_ns.sort_unstable();
    let at = |share: f64| ages_ns[((ages_ns.len() - 1) as f64 * share) as usize] as f64 * 1e-3;
    Ok((at(0.5), at(0.99)))
}
