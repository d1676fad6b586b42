//! Ingest: brings the samples of every wagon onto the channels.
//!
//! A [`feed::Feed`] knows where samples come from (a simulated train, recordings, the standard input) and when each is
//! due; [`validate`] turns its rows into messages; the loop here paces, stamps, sends and counts. Deadlines are
//! absolute: sleeping too long once delays nothing later. Sending never waits for a reader.
//!
//! # Glossary
//! * **due**: seconds after the start at which a sample shall be acquired; that instant is its acquisition stamp, so
//!   that the age of an estimate tells of every delay from there on.
//! * **tick**: one round of the loop; all that is due by then leaves as one batch a wagon.

mod counters;
pub mod feed;
mod microphones;
mod outbox;
mod pace;
pub mod validate;

pub use counters::Counters;

use crate::feed::{Account, Arrival, Feed, Next, When};
use crate::microphones::Microphones;
use crate::outbox::Outbox;
use crate::pace::Pace;
use railgrip_bus::{
    Bus, BusConfig, BusError, EventPublisher, HeartbeatPublisher, Lifecycle, SourcePublisher, monotonic_ns,
    now,
};
use railgrip_messages::{
    Event, EventKind, Grade, Heartbeat, NO_WAGON, NO_WHEELSET, ProcessKind, SourceState, Stamp, Text,
};
use railgrip_settings::{Source, TrainSettings};
use std::collections::BTreeMap;
use std::time::{Duration, Instant};

/// Time between two looks at the holder, s.
const HOLDER_CHECK: Duration = Duration::from_millis(500);
/// How often it is said again what is wrong with a wagon.
const REPEATED: Duration = Duration::from_secs(10);
/// Time between two heartbeats.
const HEARTBEAT: Duration = Duration::from_secs(1);
/// Longest wait for the estimators before a replay begins: a run should be seen from its first sample on.
const WAIT_FOR_ESTIMATORS: Duration = Duration::from_secs(3);
/// Errors of input that are spelled out in the log; the rest is only counted.
const TOLD_ERRORS: u64 = 20;

/// Why ingest ended.
#[derive(Debug, thiserror::Error)]
pub enum IngestError {
    /// A recording or scenario cannot be used.
    #[error(transparent)]
    Input(#[from] feed::InputError),
    /// The channels cannot be used.
    #[error(transparent)]
    Bus(#[from] BusError),
}

/// Runs until asked to stop, or until the source has ended.
///
/// # Errors
/// Input that cannot be read, or channels that cannot be used.
pub fn run(settings: &TrainSettings, lifecycle: &Lifecycle) -> Result<(), IngestError> {
    let mut feed = feed::open(settings)?;
    let prepared = microphones::prepare(settings)?;
    let bus = Bus::open(BusConfig::of(settings), ProcessKind::Ingest, 0)?;
    let mut microphones = Microphones::open(&bus, prepared)?;
    let mut outboxes = settings
        .wagons
        .iter()
        .map(|wagon| Outbox::open(&bus, wagon.number, wagon.plant.kind()))
        .collect::<Result<Vec<_>, BusError>>()?;
    let mut reporter = Reporter::new(&bus)?;
    let played = match &settings.source {
        Source::Replay { .. } | Source::Rig { .. } => true,
        Source::Can(can) => can.log.is_some(),
        _ => false,
    };
    if played {
        wait_for_estimators(&bus, settings.wagons.len(), lifecycle)?;
    }
    lifecycle.ready();
    reporter.event(EventKind::Started, "ingest has started")?;
    tracing::info!(wagons = outboxes.len(), source = feed.describe(), "ingest has started");

    feed.begin();
    let mut pace = Pace::new(settings.batch_s, feed.speed());
    let mut checked = Instant::now();
    let mut ended = false;
    while !lifecycle.should_stop() && !ended {
        let until_s = pace.wait(lifecycle);
        let mut news = Vec::new();
        let counters = &mut reporter.counters;
        let mut sink = |arrival: Arrival<'_>| take(arrival, &pace, &mut outboxes, counters, &mut news);
        ended = feed.take_due(until_s, &mut sink) == Next::Ended;
        for news in &news {
            reporter.tell(news)?;
        }
        feed.sending();
        for (place, outbox) in outboxes.iter_mut().enumerate() {
            reporter.counters.published += outbox.send();
            feed.sent(place + 1);
        }
        // A reader that wakes takes the processor: who is killed then has written down what it sent.
        outboxes.iter_mut().for_each(Outbox::wake);
        microphones.send_due(until_s, feed.as_ref(), &pace);
        if let Some(skipped_s) = pace.catch_up(until_s) {
            tracing::warn!(skipped_s, "ingest was stopped or starved; the schedule goes on from here");
        }
        lifecycle.beat();
        reporter.beat_if_due(feed.as_ref())?;
        if checked.elapsed() >= HOLDER_CHECK {
            checked = Instant::now();
            bus.check_holder()?;
        }
    }
    let why = if ended { "the source has ended" } else { "ingest was asked to stop" };
    if ended && played {
        reporter.event(EventKind::SourceChanged, "the recording has ended")?;
    }
    reporter.event(EventKind::Stopped, why)?;
    let Counters { received, rejected, late, published } = reporter.counters;
    tracing::info!(received, rejected, late, published, "{why}");
    if ended && received == 0 {
        tracing::warn!("not one sample came from the source: does it hold what the mapping asks for?");
    }
    Ok(())
}

/// What people should know about the source of a wagon.
enum News {
    /// What gives its units away, or nothing once they are plausible.
    Units(u32, Option<String>),
    /// Its clock drifts by so many parts in a million, more than it should or no longer.
    Clock(u32, f64, bool),
}

/// The stamp of an instant of the monotonic clock.
fn stamp_at(at_ns: u64) -> Stamp {
    let now = now();
    let age_ns = i64::try_from(i128::from(now.monotonic_ns) - i128::from(at_ns)).unwrap_or(0);
    Stamp { unix_ns: now.unix_ns.saturating_sub(age_ns), monotonic_ns: at_ns }
}

fn take(
    arrival: Arrival<'_>,
    pace: &Pace,
    outboxes: &mut [Outbox],
    counters: &mut Counters,
    news: &mut Vec<News>,
) {
    counters.received += 1;
    match arrival {
        Arrival::Row { wagon, row, wheelsets, when, begins } => {
            if let Some(outbox) = outboxes.get_mut(wagon) {
                let acquired = match when {
                    When::Due(due_s) => pace.stamp(due_s),
                    When::At(at_ns) => stamp_at(at_ns),
                };
                outbox.take(row, wheelsets, begins, acquired, counters);
            }
        }
        Arrival::Motor { wagon, row, due_s, begins } => {
            if let Some(outbox) = outboxes.get_mut(wagon) {
                outbox.take_motor(row, begins, pace.stamp(due_s), counters);
            }
        }
        Arrival::Bogie { wagon, row, due_s, begins } => {
            if let Some(outbox) = outboxes.get_mut(wagon) {
                outbox.take_bogie(row, begins, pace.stamp(due_s), counters);
            }
        }
        Arrival::Late { .. } => counters.late += 1,
        Arrival::Withheld { .. } => counters.rejected += 1,
        Arrival::Implausible { wagon, why } => {
            counters.received -= 1;
            let wagon = wagon + 1;
            match &why {
                Some(why) => tracing::error!(wagon, "its samples are withheld: {why}"),
                None => tracing::info!(wagon, "its columns are plausible again"),
            }
            news.push(News::Units(wagon as u32, why));
        }
        Arrival::Drifts { wagon, drift_ppm, wrong } => {
            counters.received -= 1;
            tracing::warn!(wagon = wagon + 1, drift_ppm, wrong, "the clock of the source drifts");
            news.push(News::Clock(wagon as u32 + 1, drift_ppm, wrong));
        }
        Arrival::Refused(problem) => {
            counters.rejected += 1;
            if counters.rejected <= TOLD_ERRORS {
                tracing::warn!("{problem}");
            }
            if counters.rejected == TOLD_ERRORS {
                tracing::warn!("further errors of input are counted only");
            }
        }
    }
}

/// Heartbeats and events of this process.
struct Reporter {
    heartbeats: HeartbeatPublisher,
    events: EventPublisher,
    sources: SourcePublisher,
    counters: Counters,
    started: Instant,
    beaten: Option<Instant>,
    sequence: u64,
    event_sequence: u64,
    /// What is wrong with wagons, said again now and then: who listens may have begun later.
    lasting: BTreeMap<(u32, u32), Event>,
    repeated: Instant,
}

impl Reporter {
    fn new(bus: &Bus) -> Result<Self, BusError> {
        Ok(Self {
            heartbeats: bus.heartbeat_publisher()?,
            events: bus.event_publisher()?,
            sources: bus.source_publisher()?,
            counters: Counters::default(),
            started: Instant::now(),
            beaten: None,
            sequence: 0,
            event_sequence: 0,
            lasting: BTreeMap::new(),
            repeated: Instant::now(),
        })
    }

    fn beat_if_due(&mut self, feed: &dyn Feed) -> Result<(), BusError> {
        if self.beaten.is_some_and(|beaten| beaten.elapsed() < HEARTBEAT) {
            return Ok(());
        }
        self.beaten = Some(Instant::now());
        self.sequence += 1;
        self.account(feed)?;
        if self.repeated.elapsed() >= REPEATED {
            self.repeated = Instant::now();
            for mut event in self.lasting.values().copied().collect::<Vec<_>>() {
                self.event_sequence += 1;
                (event.sequence, event.stamp) = (self.event_sequence, now());
                self.events.publish(&[event])?;
            }
        }
        self.heartbeats.publish(&[Heartbeat {
            sequence: self.sequence,
            stamp: now(),
            process: ProcessKind::Ingest.code(),
            pid: std::process::id(),
            received: self.counters.received,
            rejected: self.counters.rejected,
            late: self.counters.late,
            published: self.counters.published,
            uptime_s: self.started.elapsed().as_secs_f64(),
            ..Heartbeat::default()
        }])
    }

    /// Says what the source has counted, and how its clocks run.
    fn account(&mut self, feed: &dyn Feed) -> Result<(), BusError> {
        let Some((whole, wagons)) = feed.accounts() else { return Ok(()) };
        let state = |(wagon, account): (usize, Account)| SourceState {
            sequence: self.sequence,
            stamp: now(),
            wagon: wagon as u32,
            drift_known: u32::from(account.drift_ppm.is_some()),
            drift_ppm: account.drift_ppm.unwrap_or(0.0),
            counts: account.counts,
        };
        let all: Vec<_> = std::iter::once(whole).chain(wagons).enumerate().map(state).collect();
        self.sources.publish(&all)
    }

    /// Tells people why nothing comes of a wagon any more, or that it does again; and of clocks.
    fn tell(&mut self, news: &News) -> Result<(), BusError> {
        let (kind, grade, wagon, value, text) = match news {
            News::Units(wagon, Some(why)) => {
                (EventKind::UnitsImplausible, Grade::Act, *wagon, 0.0, format!("samples withheld: {why}"))
            }
            News::Units(wagon, None) => {
                let text = "the columns are plausible again".to_owned();
                (EventKind::UnitsImplausible, Grade::Ok, *wagon, 0.0, text)
            }
            News::Clock(wagon, ppm, true) => {
                let text = format!("the clock of the source drifts by {ppm:.0} parts in a million");
                (EventKind::ClockDrifts, Grade::Watch, *wagon, *ppm, text)
            }
            News::Clock(wagon, ppm, false) => {
                let text = "the clock of the source runs well again".to_owned();
                (EventKind::ClockDrifts, Grade::Ok, *wagon, *ppm, text)
            }
        };
        self.event_about(kind, grade, wagon, value, &text)
    }

    fn event(&mut self, kind: EventKind, text: &str) -> Result<(), BusError> {
        self.event_about(kind, Grade::Unknown, NO_WAGON, 0.0, text)
    }

    fn event_about(
        &mut self,
        kind: EventKind,
        grade: Grade,
        wagon: u32,
        value: f64,
        text: &str,
    ) -> Result<(), BusError> {
        self.event_sequence += 1;
        let event = Event {
            wagon,
            sequence: self.event_sequence,
            stamp: now(),
            kind: kind.code(),
            grade: grade.code(),
            wheelset: NO_WHEELSET,
            values: [value, 0.0, 0.0, 0.0],
            text: Text::new(text),
            ..Event::default()
        };
        if grade > Grade::Ok {
            self.lasting.insert((kind.code(), wagon), event);
        } else {
            self.lasting.remove(&(kind.code(), wagon));
        }
        self.events.publish(&[event])
    }
}

/// Waits a little until every wagon's estimator has shown a sign of life.
fn wait_for_estimators(bus: &Bus, wagons: usize, lifecycle: &Lifecycle) -> Result<(), BusError> {
    let mut heartbeats = bus.heartbeat_subscriber()?;
    let mut alive = std::collections::BTreeSet::new();
    let deadline = Instant::now() + WAIT_FOR_ESTIMATORS;
    while alive.len() < wagons && Instant::now() < deadline && !lifecycle.should_stop() {
        heartbeats.receive(|batch| {
            let estimators = batch.iter().filter(|beat| beat.process() == Some(ProcessKind::Estimator));
            let fresh = estimators.filter(|beat| beat.stamp.age_s(monotonic_ns()) < 3.0);
            alive.extend(fresh.map(|beat| beat.wagon));
        })?;
        lifecycle.beat();
        std::thread::sleep(Duration::from_millis(10));
    }
    if alive.len() < wagons {
        tracing::warn!(
            alive = alive.len(),
            wagons,
            "not all estimators are there; the replay begins all the same"
        );
    }
    Ok(())
}
