//! Judge: one process a coupled train. It lays the samples of all wagons side by side ([`align`]), lets the watch of
//! `railgrip_causes` look at them, and publishes what is wrong: one verdict a fault, with its cause and its place.
//!
//! A coupled wagon cannot be judged alone, because couplers hand force on. The same watch judges trains from files
//! (`railgrip drill`), so that live and offline say the same. What it has learnt of each wheelset outlives the process
//! ([`memory`]): a successor goes on with the same alerts and the same past.

pub mod align;
mod believed;
mod memory;
mod told;

pub use believed::believed;

use align::Aligner;
use memory::Memory;
use railgrip_bus::{
    Bus, BusConfig, BusError, HeartbeatPublisher, Lifecycle, SampleSubscriber, VerdictPublisher, now,
};
use railgrip_causes::{TrainWatch, WagonFile};
use railgrip_messages::{Checked, Heartbeat, NO_WAGON, ProcessKind};
use railgrip_settings::TrainSettings;
use std::time::{Duration, Instant};

/// Channels are looked at this often; each holds half a second and more.
const POLL: Duration = Duration::from_millis(50);
/// Time between two looks at the holder.
const HOLDER_CHECK: Duration = Duration::from_millis(500);
/// Time between two heartbeats, and between two messages while nothing changes.
const SECOND: Duration = Duration::from_secs(1);

/// Runs until asked to stop.
///
/// # Errors
/// Channels that cannot be used, or a holder that is gone.
pub fn run(settings: &TrainSettings, lifecycle: &Lifecycle) -> Result<(), BusError> {
    let bus = Bus::open(BusConfig::of(settings), ProcessKind::Judge, NO_WAGON)?;
    let mut judge = Judge::open(&bus, settings)?;
    judge.resume();
    judge.beat()?;
    judge.tell()?;
    lifecycle.ready();
    tracing::info!(wagons = judge.samples.len(), "judge has started");
    let mut checked = Instant::now();
    while !lifecycle.should_stop() {
        judge.round()?;
        if checked.elapsed() >= HOLDER_CHECK {
            checked = Instant::now();
            bus.check_holder()?;
        }
        lifecycle.beat();
        std::thread::sleep(POLL);
    }
    judge.memory.keep(&judge.watch);
    tracing::info!(received = judge.received, late = judge.aligner.late, "judge stops");
    Ok(())
}

/// The ends of the channels, the watch, and the timers.
struct Judge {
    samples: Vec<SampleSubscriber>,
    verdicts: VerdictPublisher,
    heartbeats: HeartbeatPublisher,
    aligner: Aligner,
    files: Vec<WagonFile>,
    watch: TrainWatch,
    memory: Memory,
    /// What is added to the time of the samples so that the watch's goes on; `None` until the first instant.
    shift_s: Option<f64>,
    /// Time at which the watch goes on, s; 0 for one that begins.
    from_s: f64,
    started: Instant,
    told: Option<Instant>,
    beaten: Option<Instant>,
    /// Verdicts told, raised and standing: what makes a message due at once.
    known: (usize, usize),
    sequence: u64,
    beats: u64,
    received: u64,
    refused: u64,
    /// Values that no train shows, as far as that was said.
    doubted: u64,
    instants: u64,
    step_ns: u64,
}

impl Judge {
    fn open(bus: &Bus, settings: &TrainSettings) -> Result<Self, BusError> {
        let wagons = &settings.wagons;
        let files: Vec<WagonFile> = wagons.iter().map(|wagon| believed(&wagon.vehicle)).collect();
        Ok(Self {
            samples: wagons
                .iter()
                .map(|wagon| bus.sample_subscriber(wagon.number))
                .collect::<Result<_, BusError>>()?,
            verdicts: bus.verdict_publisher()?,
            heartbeats: bus.heartbeat_publisher()?,
            aligner: Aligner::new(wagons.len()),
            watch: TrainWatch::new(files.clone()),
            files,
            memory: Memory::of(settings),
            shift_s: None,
            from_s: 0.0,
            started: Instant::now(),
            told: None,
            beaten: None,
            known: (0, 0),
            sequence: 0,
            beats: 0,
            received: 0,
            refused: 0,
            doubted: 0,
            instants: 0,
            step_ns: 0,
        })
    }

    /// Goes on from what a predecessor had learnt, if it was of this train.
    fn resume(&mut self) {
        if let Some((watch, age_s)) = self.memory.restore(&self.files) {
            // A clock that was set back since makes no time run backwards.
            self.from_s = watch.time_s() + age_s.max(1.0);
            self.doubted = watch.doubted();
            self.watch = watch;
        }
    }

    fn round(&mut self) -> Result<(), BusError> {
        let now_s = self.started.elapsed().as_secs_f64();
        let (aligner, received, refused) = (&mut self.aligner, &mut self.received, &mut self.refused);
        for (wagon, samples) in self.samples.iter_mut().enumerate() {
            samples.receive(|batch| {
                let now = now();
                for sample in batch {
                    match sample.validated(now) {
                        Ok(sample) => {
                            *received += 1;
                            aligner.push(wagon, &sample, now_s);
                        }
                        Err(_) => *refused += 1,
                    }
                }
            })?;
        }
        let begun = Instant::now();
        let (watch, shift_s, instants) = (&mut self.watch, &mut self.shift_s, &mut self.instants);
        let (before, from_s) = (*instants, self.from_s);
        self.aligner.drain(now_s, |at_s, readings| {
            *instants += 1;
            let shift_s = *shift_s.get_or_insert(if from_s > 0.0 { from_s - at_s } else { 0.0 });
            watch.take(at_s + shift_s, readings);
        });
        if let Some(each_ns) = (begun.elapsed().as_nanos() as u64).checked_div(self.instants - before) {
            self.step_ns = each_ns;
        }
        let alerts = self.watch.alerts();
        let standing = alerts.iter().filter(|alert| alert.cleared_t_s.is_none()).count();
        let due = |since: Option<Instant>| since.is_none_or(|since| since.elapsed() >= SECOND);
        if (alerts.len(), standing) != self.known || due(self.told) {
            self.known = (alerts.len(), standing);
            self.tell()?;
        }
        self.memory.keep_in_time(&self.watch);
        if due(self.beaten) {
            self.beat()?;
        }
        Ok(())
    }

    fn tell(&mut self) -> Result<(), BusError> {
        self.told = Some(Instant::now());
        self.sequence += 1;
        let mut message = told::verdicts(&self.watch, self.samples.len());
        (message.sequence, message.instants) = (self.sequence, self.instants);
        self.verdicts.publish(&[message])?;
        self.verdicts.refresh()
    }

    fn beat(&mut self) -> Result<(), BusError> {
        self.beaten = Some(Instant::now());
        self.beats += 1;
        self.say_doubts();
        self.heartbeats.publish(&[Heartbeat {
            sequence: self.beats,
            stamp: now(),
            process: ProcessKind::Judge.code(),
            pid: std::process::id(),
            received: self.received,
            missed: self.samples.iter().map(SampleSubscriber::missed).sum(),
            rejected: self.refused,
            late: self.aligner.late,
            published: self.sequence,
            step_p50_ns: self.step_ns,
            step_p99_ns: self.step_ns,
            uptime_s: self.started.elapsed().as_secs_f64(),
            ..Heartbeat::default()
        }])
    }

    /// Ever more rarely: a sensor that errs does so a thousand times a second. These are values, and no samples that are refused.
    fn say_doubts(&mut self) {
        let doubted = self.watch.doubted();
        if doubted > 2 * self.doubted {
            self.doubted = doubted;
            tracing::warn!(values = doubted, "values that no train shows count as unknown");
        }
    }
}
