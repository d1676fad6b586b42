//! What was received: the latest message of each wagon, of its microphone, and of each process. Here payloads come in, and
//! what is wrong with one is found.

use crate::store::refused::Refused;
use railgrip_indicators::Nominal;
use railgrip_messages::{
    Checked, Event, EventKind, Grade, Health, Heard, Heartbeat, NO_WAGON, Refusal, SourceState, Stamp,
    Validated, Verdicts,
};
use railgrip_settings::{TrainSettings, WagonSettings};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A process that has been quiet for this long is no longer listed, s.
const PROCESS_GONE_S: f64 = 30.0;

/// The latest of everything that arrived.
#[derive(Debug, Clone)]
pub(super) struct Received {
    /// The wagons of the train, front first.
    pub wagons: Vec<Wagon>,
    /// By kind of process and wagon.
    pub heartbeats: BTreeMap<(u32, u32), Heartbeat>,
    /// What the source of samples said last, by wagon.
    pub sources: BTreeMap<u32, SourceState>,
    /// What the source of samples says is wrong with a wagon, by what it is and wagon: units, clock; and when it said so last.
    pub told: BTreeMap<(EventKind, u32), (String, Stamp)>,
    /// When the recording that is played had ended.
    pub ended: Option<Stamp>,
    /// Data are stale from this age on, s.
    pub stale_after_s: f64,
    /// What was not taken.
    pub refused: Refused,
}

/// A wagon: what the config says of it, and the latest that it said itself.
#[derive(Debug, Clone)]
pub(super) struct Wagon {
    /// Its place in the train, 1 first.
    pub number: u32,
    /// Its name.
    pub name: String,
    /// The number of its vehicle, as it is written.
    pub vehicle: Option<String>,
    /// What it is by its vehicle file.
    pub nominal: Nominal,
    /// Its latest indicators.
    pub health: Option<Arc<Health>>,
    /// Whether it has a microphone.
    pub microphone: bool,
    /// What that heard last.
    pub heard: Option<Heard>,
}

impl Wagon {
    fn new(settings: &TrainSettings, wagon: &WagonSettings) -> Self {
        Self {
            number: wagon.number,
            name: wagon.name.clone(),
            vehicle: wagon.vehicle_number.as_ref().map(|number| number.written().to_owned()),
            nominal: railgrip_settings::nominal(&wagon.vehicle),
            health: None,
            microphone: settings.microphone(wagon.number).is_some(),
            heard: None,
        }
    }
}

impl Received {
    /// Nothing has arrived yet.
    pub fn new(settings: &TrainSettings) -> Self {
        Self {
            wagons: settings.wagons.iter().map(|wagon| Wagon::new(settings, wagon)).collect(),
            heartbeats: BTreeMap::new(),
            sources: BTreeMap::new(),
            told: BTreeMap::new(),
            ended: None,
            stale_after_s: settings.http.stale_after_s,
            refused: Refused::default(),
        }
    }

    /// The number of the vehicle at a place of the train, as it is written.
    pub fn vehicle(&self, wagon: u32) -> Option<&str> {
        self.wagons.iter().find(|known| known.number == wagon)?.vehicle.as_deref()
    }

    /// The one place where payloads come in: what is wrong, or about a wagon that the channel does not carry, is refused
    /// and counted. `channel` is the number of the wagon whose channel it came from, or [`NO_WAGON`].
    pub fn admit<'a, T: Checked>(
        &mut self,
        channel: u32,
        payload: &'a T,
        now: Stamp,
    ) -> Option<Validated<'a, T>> {
        let known = |wagon: u32| self.wagons.iter().any(|known| known.number == wagon);
        let wagon = payload.wagon();
        let expected = if channel == NO_WAGON { wagon == NO_WAGON || known(wagon) } else { wagon == channel };
        self.admit_if(expected, channel, payload, now)
    }

    /// The same of what is wrong with the train; one of another length is another train, and its wagons are none of these.
    pub fn admit_verdicts<'a>(
        &mut self,
        verdicts: &'a Verdicts,
        now: Stamp,
    ) -> Option<Validated<'a, Verdicts>> {
        let expected = verdicts.wagons as usize == self.wagons.len();
        self.admit_if(expected, NO_WAGON, verdicts, now)
    }

    fn admit_if<'a, T: Checked>(
        &mut self,
        expected: bool,
        channel: u32,
        payload: &'a T,
        now: Stamp,
    ) -> Option<Validated<'a, T>> {
        let admitted =
            payload.validated(now).and_then(|valid| expected.then_some(valid).ok_or(Refusal::WrongWagon));
        match admitted {
            Ok(valid) => {
                self.refused.taken(channel);
                Some(valid)
            }
            Err(why) => {
                self.refused.count(T::NAME, channel, why);
                None
            }
        }
    }

    /// Takes the indicators of a wagon unless it has newer ones. Returns the message that they replace, or `None` if
    /// nothing was taken.
    pub fn take_health(&mut self, health: Validated<'_, Health>) -> Option<Option<Arc<Health>>> {
        let known = self.wagons.iter_mut().find(|known| known.number == health.wagon)?;
        let newer = |old: &Health| health.published_monotonic_ns >= old.published_monotonic_ns;
        known.health.as_deref().is_none_or(newer).then(|| known.health.replace(Arc::new(*health)))
    }

    /// Takes what a microphone heard.
    pub fn take_heard(&mut self, heard: Validated<'_, Heard>) {
        if let Some(known) = self.wagons.iter_mut().find(|known| known.number == heard.wagon) {
            known.heard = Some(*heard);
        }
    }

    /// Takes the heartbeat of a process.
    pub fn take_heartbeat(&mut self, beat: Validated<'_, Heartbeat>) {
        self.heartbeats.insert((beat.process, beat.wagon), *beat);
    }

    /// Takes what the source of samples has counted.
    pub fn take_source(&mut self, state: Validated<'_, SourceState>) {
        self.sources.insert(state.wagon, *state);
    }

    /// Takes what a process tells of a wagon: something that is wrong with what its source sends, or that it is over.
    pub fn take_event(&mut self, event: Validated<'_, Event>) {
        if event.kind() == Some(EventKind::SourceChanged) && event.wagon == NO_WAGON {
            self.ended = Some(event.stamp);
        }
        let Some(kind @ (EventKind::UnitsImplausible | EventKind::ClockDrifts)) = event.kind() else {
            return;
        };
        if event.grade() > Grade::Ok {
            self.told.insert((kind, event.wagon), (event.text.as_str().to_owned(), event.stamp));
        } else {
            self.told.remove(&(kind, event.wagon));
        }
    }

    /// Forgets processes that have been quiet for long.
    pub fn forget_silent_processes(&mut self, now: Stamp) {
        self.heartbeats.retain(|_, beat| beat.stamp.age_s(now.monotonic_ns) < PROCESS_GONE_S);
        self.sources.retain(|_, state| state.stamp.age_s(now.monotonic_ns) < PROCESS_GONE_S);
        self.told.retain(|_, (_, said)| said.age_s(now.monotonic_ns) < PROCESS_GONE_S);
    }

    /// Whether what a wagon said last was the end of its recording.
    pub fn played_out(&self, last: Stamp) -> bool {
        let before = |ended: Stamp| ended.monotonic_ns.checked_sub(last.monotonic_ns);
        self.ended.and_then(before).is_some_and(|ns| ns as f64 * 1e-9 <= self.stale_after_s)
    }

    /// What a wagon said last, unless that is stale.
    pub fn fresh<'a>(&self, wagon: &'a Wagon, now_ns: u64) -> Option<&'a Health> {
        wagon.health.as_deref().filter(|health| health.acquired.age_s(now_ns) <= self.stale_after_s)
    }
}
