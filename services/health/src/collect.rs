//! The thread that listens to the channels and renews what is served.

use crate::alerts::journal::Journal;
use crate::api::wagons::model::WagonRow;
use crate::delivery;
use crate::history::Recorder;
use crate::history::watch::{self, Watch};
use crate::shared::{Shared, StreamEvent};
use crate::store::{Snapshot, Store};
use crate::web::json::json;
use railgrip_bus::{
    Bus, BusConfig, BusError, HealthSubscriber, HeardSubscriber, HeartbeatPublisher, HeartbeatSubscriber,
    Lifecycle, now,
};
use railgrip_history::{Event, Reader};
use railgrip_messages::{Heartbeat, NO_WAGON, ProcessKind};
use railgrip_settings::TrainSettings;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// The channels are looked at this often.
const POLL: Duration = Duration::from_millis(20);
/// Time between two looks at the holder.
const HOLDER_CHECK: Duration = Duration::from_millis(500);
/// Time between two heartbeats.
const HEARTBEAT: Duration = Duration::from_secs(1);
/// Listeners of the stream get changes this often.
const STREAM_PERIOD: Duration = Duration::from_millis(500);

/// Listens until asked to stop. Ports stay on the thread that opened them, so the bus is opened here.
///
/// # Errors
/// Channels that cannot be used, or a holder that is gone.
pub(crate) fn collect(
    settings: &TrainSettings,
    shared: &Shared,
    lifecycle: &Lifecycle,
    recorder: Option<Recorder>,
) -> Result<(), BusError> {
    let mut ends = Ends::open(settings)?;
    let mut store = Store::new(settings);
    recall_map(settings, &mut store);
    let post = Post::open(settings, shared, &store);
    let mut streamer = Streamer::default();
    let mut watch = Watch::default();
    let tell = |event| {
        if let Some(recorder) = &recorder {
            recorder.take_event(event);
        }
    };
    tell(of_service("service_started"));
    let refresh = Duration::from_secs_f64(settings.http.refresh_s);
    let started = Instant::now();
    let map_period = Duration::from_secs_f64(settings.capability.map_save_s);
    let (mut renewed, mut checked, mut beaten) = (None::<Instant>, started, None::<Instant>);
    let mut kept_map = started;
    let elapsed =
        |since: Option<Instant>, period: Duration| since.is_none_or(|since| since.elapsed() >= period);
    while !lifecycle.should_stop() {
        ends.receive(&mut store, recorder.as_ref(), &mut watch)?;
        if elapsed(renewed, refresh) {
            renewed = Some(Instant::now());
            store.set_history_trouble(shared.history().and_then(|history| history.trouble()));
            let snapshot = Arc::new(store.snapshot(now()));
            snapshot.news.iter().for_each(|alert| tell(watch::of_alert(alert, snapshot.taken.unix_ns)));
            watch.gone(snapshot.taken.monotonic_ns, snapshot.taken.unix_ns).into_iter().for_each(tell);
            shared.replace(Arc::clone(&snapshot));
            if snapshot.book.lock().version() != snapshot.alert_version {
                // Somebody acknowledged one in between.
                crate::alerts::routes::show(shared);
            }
            streamer.stream(shared, &snapshot);
            lifecycle.beat();
        }
        if elapsed(beaten, HEARTBEAT) {
            beaten = Some(Instant::now());
            ends.beat(started.elapsed().as_secs_f64())?;
        }
        if checked.elapsed() >= HOLDER_CHECK {
            checked = Instant::now();
            ends.bus.check_holder()?;
        }
        if let Some(recorder) = recorder.as_ref().filter(|_| kept_map.elapsed() >= map_period) {
            kept_map = Instant::now();
            recorder.take_cells(store.changed_map(now()));
        }
        std::thread::sleep(POLL);
    }
    if let Some(recorder) = &recorder {
        recorder.take_cells(store.changed_map(now()));
    }
    tell(of_service("service_stopped"));
    post.close();
    Ok(())
}

/// Goes on with the map of the track as it was when this service last ran.
fn recall_map(settings: &TrainSettings, store: &mut Store) {
    let database = settings.history.database();
    if !settings.history.enabled || !database.exists() {
        return;
    }
    match Reader::open(&database).and_then(|reader| reader.cells()) {
        Ok(cells) => {
            let known = store.restore_map(&cells, now());
            tracing::info!(known, "cells of the adhesion map are known from before");
        }
        // Also of a database that an older version wrote: it has no map yet.
        Err(error) => tracing::info!(%error, "the adhesion map begins anew"),
    }
}

/// A start or stop of this service.
fn of_service(kind: &str) -> Event {
    Event {
        unix_ms: now().unix_ns.div_euclid(1_000_000),
        kind: kind.to_owned(),
        cause: "health".to_owned(),
        text: format!("{} (process {})", kind.replace('_', " "), std::process::id()),
        ..Event::default()
    }
}

/// Alerts on the disk, and the threads that deliver them.
struct Post {
    stop: Arc<AtomicBool>,
    threads: Vec<std::thread::JoinHandle<()>>,
}

impl Post {
    /// Goes on from the journal. Without one alerts are live only, and nothing is delivered.
    fn open(settings: &TrainSettings, shared: &Shared, store: &Store) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let (path, delivery) = (&settings.alert_journal, &settings.delivery);
        let (targets, most) = (delivery::targets(delivery), delivery.most_waiting);
        let opened = Journal::open(path, &settings.name, targets, most)
            .and_then(|journal| journal.alerts().map(|kept| (journal, kept)));
        let book = store.book();
        let threads = match opened {
            Ok((journal, kept)) => {
                book.lock().keep_in(journal, kept);
                delivery::start(delivery, &settings.name, path, shared.mailbox(), &stop)
            }
            Err(error) => {
                tracing::error!(%error, "alerts are neither kept nor delivered");
                book.lock().set_trouble(error.to_string());
                Vec::new()
            }
        };
        Self { stop, threads }
    }

    fn close(self) {
        self.stop.store(true, std::sync::atomic::Ordering::Relaxed);
        for thread in self.threads {
            let _ = thread.join();
        }
    }
}

struct Ends {
    bus: Bus,
    health: Vec<HealthSubscriber>,
    heard: Vec<HeardSubscriber>,
    heartbeats: HeartbeatSubscriber,
    own: HeartbeatPublisher,
    sequence: u64,
}

impl Ends {
    fn open(settings: &TrainSettings) -> Result<Self, BusError> {
        let bus = Bus::open(BusConfig::of(settings), ProcessKind::Health, NO_WAGON)?;
        let wagons = settings.wagons.iter();
        let health = wagons.map(|wagon| bus.health_subscriber(wagon.number)).collect::<Result<_, _>>()?;
        let microphones = settings.microphones.iter();
        let heard =
            microphones.map(|microphone| bus.heard_subscriber(microphone.wagon)).collect::<Result<_, _>>()?;
        let (heartbeats, own) = (bus.heartbeat_subscriber()?, bus.heartbeat_publisher()?);
        Ok(Self { bus, health, heard, heartbeats, own, sequence: 0 })
    }

    fn receive(
        &mut self,
        store: &mut Store,
        recorder: Option<&Recorder>,
        watch: &mut Watch,
    ) -> Result<(), BusError> {
        let tell = |event| {
            if let Some(recorder) = recorder {
                recorder.take_event(event);
            }
        };
        for subscriber in &mut self.health {
            subscriber.receive(|batch| {
                for health in batch {
                    store.take_health(health);
                    if let Some(recorder) = recorder {
                        recorder.take(health);
                    }
                    watch.health(health).into_iter().for_each(tell);
                }
            })?;
        }
        for subscriber in &mut self.heard {
            subscriber.receive(|batch| batch.iter().for_each(|heard| store.take_heard(heard)))?;
        }
        self.heartbeats.receive(|batch| {
            for beat in batch {
                store.take_heartbeat(beat);
                watch.heartbeat(beat).into_iter().for_each(tell);
            }
        })?;
        Ok(())
    }

    fn beat(&mut self, uptime_s: f64) -> Result<(), BusError> {
        self.sequence += 1;
        self.own.publish(&[Heartbeat {
            sequence: self.sequence,
            stamp: now(),
            process: ProcessKind::Health.code(),
            pid: std::process::id(),
            uptime_s,
            ..Heartbeat::default()
        }])
    }
}

/// Tells the listeners of the stream what changed.
#[derive(Default)]
struct Streamer {
    told: Vec<WagonRow>,
    at: Option<Instant>,
}

impl Streamer {
    fn stream(&mut self, shared: &Shared, snapshot: &Snapshot) {
        for alert in &snapshot.news {
            let change = alert.history.last().map_or("changed", |line| line.change.word());
            tracing::info!(
                id = alert.id,
                grade = alert.grade.word(),
                "alert {change}: {} ({}): {}",
                alert.cause,
                if alert.scope == crate::alerts::model::Scope::Train {
                    "train".to_owned()
                } else {
                    format!("wagon {}", alert.wagon)
                },
                alert.reason
            );
            shared.send(StreamEvent { name: "alert", data: json(alert) });
        }
        if self.at.is_some_and(|at| at.elapsed() < STREAM_PERIOD) || !shared.has_listeners() {
            return;
        }
        self.at = Some(Instant::now());
        let changed: Vec<&WagonRow> = snapshot.rows.iter().filter(|row| !self.told.contains(row)).collect();
        if !changed.is_empty() {
            shared.send(StreamEvent { name: "wagons", data: json(&changed) });
        }
        shared.send(StreamEvent { name: "train", data: snapshot.train_json.clone() });
        self.told.clone_from(&snapshot.rows);
    }
}
