//! The thread that listens to the channels and renews what is served.

mod ends;
mod notifying;
mod streamer;

use crate::history::Recorder;
use crate::history::watch::{self, Watch};
use crate::limits::Limits;
use crate::shared::Shared;
use crate::store::Store;
use ends::Ends;
use notifying::Notifying;
use railgrip_bus::{BusError, Lifecycle, now};
use railgrip_history::{Event, Reader};
use railgrip_settings::TrainSettings;
use std::sync::Arc;
use std::time::{Duration, Instant};
use streamer::Streamer;

/// The channels are looked at this often.
const POLL: Duration = Duration::from_millis(20);
/// Time between two looks at the holder.
const HOLDER_CHECK: Duration = Duration::from_millis(500);
/// Time between two heartbeats.
const HEARTBEAT: Duration = Duration::from_secs(1);

/// Listens until asked to stop. Ports stay on the thread that opened them, so the bus is opened here.
///
/// # Errors
/// Channels that cannot be used, or a holder that is gone.
pub(crate) fn collect(
    settings: &TrainSettings,
    shared: &Shared,
    lifecycle: &Lifecycle,
    joined: &Lifecycle,
    recorder: Option<Recorder>,
) -> Result<(), BusError> {
    let mut ends = Ends::open(settings)?;
    joined.ready();
    let mut store = Store::new(settings);
    recall_map(settings, &mut store);
    let mut notifying = Notifying::open(settings, shared, &store);
    let mut streamer = Streamer::default();
    let mut watch = Watch::default();
    let tell = |event| {
        if let Some(recorder) = &recorder {
            recorder.take_event(event);
        }
    };
    tell(of_service("service_started"));
    let mut refresh = Duration::from_secs_f64(settings.http.refresh_s);
    let started = Instant::now();
    let map_period = Duration::from_secs_f64(settings.capability.map_save_s);
    let (mut renewed, mut checked, mut beaten) = (None::<Instant>, started, None::<Instant>);
    let mut kept_map = started;
    let elapsed =
        |since: Option<Instant>, period: Duration| since.is_none_or(|since| since.elapsed() >= period);
    while !lifecycle.should_stop() {
        ends.receive(&mut store, recorder.as_ref(), &mut watch)?;
        if let Some(new) = lifecycle.offered() {
            store.take_over(&new);
            notifying.take_over(&new, shared, &store);
            shared.judge_by(Limits::of(&new));
            refresh = Duration::from_secs_f64(new.http.refresh_s);
        }
        if elapsed(renewed, refresh) || store.take_first_news() {
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
    // A new holder waits until nobody has ports any more; that must not hang on receivers.
    drop(ends);
    notifying.close();
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
        Err(error) => tracing::warn!(%error, "the adhesion map begins anew: what was kept cannot be read"),
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
