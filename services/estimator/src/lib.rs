//! Estimator: one process a wagon. Samples wake it; it filters each, publishes estimates and innovations, and from time
//! to time indicators, a heartbeat and a snapshot.
//!
//! [`worker`] does the work and knows no channel; [`snapshot`] keeps its state for a successor; the loop here connects
//! both to the bus. Nothing here waits for a reader.

mod absence;
pub mod convert;
pub mod gap_record;
pub mod gap_watch;
mod inlet;
pub mod sight;
pub mod snapshot;
pub mod timing;
mod units;
pub mod worker;

use crate::absence::Absence;
use crate::inlet::Inlet;
use crate::snapshot::SnapshotError;
use crate::timing::Histogram;
use crate::worker::Worker;
use railgrip_bus::{
    Bus, BusConfig, BusError, EstimatePublisher, EventPublisher, HealthPublisher, HeartbeatPublisher,
    InnovationPublisher, KeptError, Lifecycle, monotonic_ns, now,
};
use railgrip_messages::{Event, EventKind, Heartbeat, NO_WHEELSET, ProcessKind, Text};
use railgrip_settings::{ReportingSettings, TrainSettings, VehicleNumber};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Longest sleep: timers and the stop flag are looked at this often.
const LONGEST_WAIT: Duration = Duration::from_millis(100);
/// Time between two looks for late joiners.
const REFRESH: Duration = Duration::from_millis(100);
/// Time between two looks at the holder.
const HOLDER_CHECK: Duration = Duration::from_millis(500);
/// At most so many recordings of mismatches are kept for a wagon; older ones are not overwritten.
const KEPT_CASES: u32 = 3;
/// Time between two heartbeats.
const HEARTBEAT: Duration = Duration::from_secs(1);

/// Why an estimator ended.
#[derive(Debug, thiserror::Error)]
pub enum EstimatorError {
    /// The filter does not fit the vehicle.
    #[error(transparent)]
    Filter(#[from] railgrip_filter::FilterError),
    /// The channels cannot be used.
    #[error(transparent)]
    Bus(#[from] BusError),
}

/// Runs until asked to stop.
///
/// # Errors
/// A filter that does not fit the vehicle, or channels that cannot be used.
pub fn run(settings: &TrainSettings, wagon: u32, lifecycle: &Lifecycle) -> Result<(), EstimatorError> {
    let mut worker = Worker::new(settings, wagon)?;
    let bus = Bus::open(BusConfig::of(settings), ProcessKind::Estimator, wagon)?;
    let mut samples = Inlet::open(&bus, settings, &worker)?;
    let mut service = Service::new(&bus, settings, wagon)?;
    service.resume(&mut worker)?;
    service.heartbeat(&worker, &samples)?;
    lifecycle.ready();
    tracing::info!(filter = worker.filter(), "estimator has started");
    while !lifecycle.should_stop() {
        samples.wait(LONGEST_WAIT)?;
        samples.receive(&mut worker)?;
        service.publish(&mut worker)?;
        service.absence.note(&worker);
        service.timers(&mut worker, &samples, &bus)?;
        if let Some(new) = lifecycle.offered() {
            worker.judge_by(new.indicators);
            service.report_as(&new.reporting);
        }
        lifecycle.beat();
    }
    service.save(&worker);
    service.event(EventKind::Stopped, [0.0; 4], "estimator was asked to stop")?;
    tracing::info!(
        taken = worker.taken,
        missed = samples.missed(),
        refused = samples.refused(),
        unseen = service.absence.unseen(),
        not_newer = worker.not_newer,
        "estimator stops"
    );
    Ok(())
}

/// Something that is due again and again.
struct Timer {
    period: Duration,
    next: Instant,
}

impl Timer {
    fn every(period: Duration) -> Self {
        Self { period, next: Instant::now() + period }
    }

    /// Goes on with another period, which begins now.
    fn set(&mut self, period: Duration) {
        *self = Self::every(period);
    }

    /// True if it is due; it is then due again a period later, and never twice for one that was missed.
    fn due(&mut self, now: Instant) -> bool {
        let due = now >= self.next;
        if due {
            self.next = (self.next + self.period).max(now);
        }
        due
    }
}

/// The sending ends and the timers.
struct Service {
    wagon: u32,
    estimates: EstimatePublisher,
    innovations: InnovationPublisher,
    health: HealthPublisher,
    events: EventPublisher,
    heartbeats: HeartbeatPublisher,
    absence: Absence,
    snapshot_file: PathBuf,
    snapshot_failing: bool,
    gap_folder: PathBuf,
    gap_cases: u32,
    gap_kept: bool,
    /// A case that is written anew when more has been seen, and when it was first written, s.
    gap_growing: Option<(PathBuf, f64)>,
    health_timer: Timer,
    heartbeat_timer: Timer,
    snapshot_timer: Timer,
    refresh_timer: Timer,
    holder_timer: Timer,
    latency_ns: Histogram,
    started: Instant,
    published: u64,
    reported: u64,
    saved: u64,
    heartbeat_sequence: u64,
    event_sequence: u64,
}

impl Service {
    fn new(bus: &Bus, settings: &TrainSettings, wagon: u32) -> Result<Self, BusError> {
        let reporting = &settings.reporting;
        let own = settings.wagon(wagon).and_then(|wagon| wagon.vehicle_number.as_ref());
        Ok(Self {
            wagon,
            estimates: bus.estimate_publisher(wagon)?,
            innovations: bus.innovation_publisher(wagon)?,
            health: bus.health_publisher(wagon)?,
            events: bus.event_publisher()?,
            heartbeats: bus.heartbeat_publisher()?,
            absence: Absence::open(
                settings.instance.absence_file(wagon),
                &(settings.instance.session(), own.map(VehicleNumber::key)),
            ),
            snapshot_file: settings.instance.snapshot_file(wagon, own),
            snapshot_failing: false,
            gap_folder: settings.instance.gap_folder(),
            gap_cases: 0,
            gap_kept: false,
            gap_growing: None,
            health_timer: Timer::every(Duration::from_secs_f64(1.0 / reporting.health_rate_hz)),
            heartbeat_timer: Timer::every(HEARTBEAT),
            snapshot_timer: Timer::every(Duration::from_secs_f64(reporting.snapshot_period_s)),
            refresh_timer: Timer::every(REFRESH),
            holder_timer: Timer::every(HOLDER_CHECK),
            latency_ns: Histogram::default(),
            started: Instant::now(),
            published: 0,
            reported: 0,
            saved: 0,
            heartbeat_sequence: 0,
            event_sequence: 0,
        })
    }

    /// Reports and saves as often as that from now on.
    fn report_as(&mut self, reporting: &ReportingSettings) {
        self.health_timer.set(Duration::from_secs_f64(1.0 / reporting.health_rate_hz));
        self.snapshot_timer.set(Duration::from_secs_f64(reporting.snapshot_period_s));
    }

    /// Goes on from the predecessor's snapshot, if there is a sound one.
    fn resume(&mut self, worker: &mut Worker) -> Result<(), BusError> {
        if let Some(folder) = self.snapshot_file.parent()
            && let Err(error) = std::fs::create_dir_all(folder)
        {
            tracing::warn!(folder = %folder.display(), %error, "no snapshots: their folder cannot be made");
        }
        match snapshot::restore(&self.snapshot_file, worker) {
            Ok(None) if worker.vehicle_number.is_none() => {
                let text = "estimator has started fresh: the wagon has no vehicle number";
                tracing::info!("{text}");
                self.event(EventKind::Started, [0.0; 4], text)
            }
            Ok(None) => self.event(EventKind::Started, [0.0; 4], "estimator has started fresh"),
            Ok(Some(stamp)) => {
                let age_s = (now().unix_ns - stamp.unix_ns) as f64 * 1e-9;
                tracing::info!(age_s, "estimator goes on from a snapshot");
                if stamp.monotonic_ns > monotonic_ns() {
                    // Of an earlier boot of this host: its monotonic stamps mean nothing now.
                    worker.forget_stamp();
                }
                let text = format!("estimator goes on from a snapshot that is {age_s:.1} s old");
                self.event(EventKind::FilterRestarted, [age_s, 0.0, 0.0, 0.0], &text)
            }
            Err(error) => {
                match error {
                    SnapshotError::EarlierStart(_) => tracing::info!(%error, "estimator has started fresh"),
                    _ => tracing::warn!(%error, "the snapshot is refused; the estimator starts fresh"),
                }
                let text = match &error {
                    SnapshotError::EarlierStart(_) => {
                        "estimator has started fresh: of an earlier start; without a vehicle number it may be of another wagon".to_owned()
                    }
                    SnapshotError::Kept(KeptError::Form { problem, .. }) => {
                        format!("estimator has started fresh: {problem}")
                    }
                    _ => "estimator has started fresh: its snapshot was refused".to_owned(),
                };
                self.event(EventKind::Started, [0.0; 4], &text)
            }
        }
    }

    fn publish(&mut self, worker: &mut Worker) -> Result<(), BusError> {
        if !worker.estimates.is_empty() {
            let published_ns = monotonic_ns();
            for estimate in &mut worker.estimates {
                estimate.published_monotonic_ns = published_ns;
                self.latency_ns.add(published_ns.saturating_sub(estimate.acquired.monotonic_ns));
            }
            self.estimates.publish(&worker.estimates)?;
            self.innovations.publish(&worker.innovations)?;
            self.published += worker.estimates.len() as u64;
        }
        worker.digest();
        for event in &mut worker.events {
            self.event_sequence += 1;
            event.sequence = self.event_sequence;
        }
        for event in &worker.events {
            self.events.publish(std::slice::from_ref(event))?;
        }
        worker.clear();
        Ok(())
    }

    fn timers(&mut self, worker: &mut Worker, samples: &Inlet, bus: &Bus) -> Result<(), BusError> {
        let instant = Instant::now();
        if self.health_timer.due(instant) && worker.taken > self.reported {
            self.reported = worker.taken;
            let mut health = worker.health();
            health.missed = samples.missed();
            health.published_monotonic_ns = monotonic_ns();
            self.health.publish(&[health])?;
            self.keep_mismatch(worker);
        }
        if self.snapshot_timer.due(instant) {
            self.save(worker);
        }
        if self.heartbeat_timer.due(instant) {
            self.heartbeat(worker, samples)?;
        }
        if self.refresh_timer.due(instant) {
            self.health.refresh()?;
            self.heartbeats.refresh()?;
            self.events.refresh()?;
        }
        if self.holder_timer.due(instant) {
            bus.check_holder()?;
        }
        Ok(())
    }

    /// Keeps the latest minutes for each mismatch, ready to be diagnosed: at once, and again when more has been seen.
    fn keep_mismatch(&mut self, worker: &Worker) {
        if let Some((case, told_s)) = &self.gap_growing {
            let more_s = worker.gap.newest_s() - told_s;
            // Where time begins anew, what was kept is gone: the case stays as it is.
            let again = || match gap_record::write(case, &worker.gap, &worker.vehicle, false) {
                Ok(false) => gap_record::settle(case),
                written => written.map(|_| ()),
            };
            let grown = match more_s {
                more_s if more_s > gap_watch::KEPT_S / 2.0 => Some(again()),
                more_s if more_s < 0.0 => Some(gap_record::settle(case)),
                _ => None,
            };
            if let Some(Err(error)) = &grown {
                tracing::warn!(%error, "the recording of a mismatch cannot be kept");
            }
            if grown.is_some() {
                self.gap_growing = None;
            }
        }
        let Some(mismatch) = worker.told.as_ref() else {
            self.gap_kept = false;
            return;
        };
        if self.gap_kept || self.gap_growing.is_some() || self.gap_cases >= KEPT_CASES {
            return;
        }
        self.gap_kept = true;
        let seconds = now().unix_ns / 1_000_000_000;
        let case = self.gap_folder.join(format!("wagon-{}-{seconds}", self.wagon));
        match gap_record::write(&case, &worker.gap, &worker.vehicle, true) {
            Ok(true) => {
                self.gap_cases += 1;
                tracing::warn!(
                    suspect = mismatch.term,
                    place = mismatch.place,
                    ratio = mismatch.ratio,
                    "the model does not explain this wagon; see it with `railgrip gap diagnose {}`",
                    case.display()
                );
                self.gap_growing = Some((case, worker.gap.newest_s()));
            }
            // Too little yet: the next look may have more.
            Ok(false) => self.gap_kept = false,
            Err(error) => tracing::warn!(%error, "the recording of a mismatch cannot be kept"),
        }
    }

    /// Trouble is told once, until it works again.
    fn save(&mut self, worker: &Worker) {
        if worker.taken == self.saved {
            return;
        }
        match snapshot::save(&self.snapshot_file, worker) {
            Ok(()) => {
                self.saved = worker.taken;
                self.snapshot_failing = false;
            }
            Err(error) => {
                if !self.snapshot_failing {
                    tracing::warn!(%error, "no snapshot: a restart would start fresh");
                }
                self.snapshot_failing = true;
            }
        }
    }

    fn heartbeat(&mut self, worker: &Worker, samples: &Inlet) -> Result<(), BusError> {
        self.heartbeat_sequence += 1;
        self.heartbeats.publish(&[Heartbeat {
            sequence: self.heartbeat_sequence,
            stamp: now(),
            process: ProcessKind::Estimator.code(),
            wagon: self.wagon,
            pid: std::process::id(),
            unseen: u32::try_from(self.absence.unseen()).unwrap_or(u32::MAX),
            received: worker.taken,
            missed: samples.missed(),
            rejected: samples.refused(),
            late: worker.not_newer,
            published: self.published,
            step_p50_ns: worker.step_ns.quantile_ns(0.5),
            step_p99_ns: worker.step_ns.quantile_ns(0.99),
            latency_p50_ns: self.latency_ns.quantile_ns(0.5),
            latency_p99_ns: self.latency_ns.quantile_ns(0.99),
            uptime_s: self.started.elapsed().as_secs_f64(),
        }])
    }

    fn event(&mut self, kind: EventKind, values: [f64; 4], text: &str) -> Result<(), BusError> {
        self.event_sequence += 1;
        self.events.publish(&[Event {
            sequence: self.event_sequence,
            stamp: now(),
            time_s: 0.0,
            kind: kind.code(),
            wagon: self.wagon,
            wheelset: NO_WHEELSET,
            grade: 0,
            values,
            text: Text::new(text),
        }])
    }
}
