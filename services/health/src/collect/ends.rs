//! The ends of the channels that this service reads, and of its own heartbeat.

use crate::history::Recorder;
use crate::history::watch::Watch;
use crate::store::Store;
use railgrip_bus::{
    Bus, BusConfig, BusError, EventSubscriber, HealthSubscriber, HeardSubscriber, HeartbeatPublisher,
    HeartbeatSubscriber, SourceSubscriber, VerdictSubscriber, now,
};
use railgrip_messages::{Heartbeat, NO_WAGON, ProcessKind};
use railgrip_settings::TrainSettings;

/// All ends. Ports stay on the thread that opened them.
pub(super) struct Ends {
    pub bus: Bus,
    health: Vec<(u32, HealthSubscriber)>,
    heard: Vec<(u32, HeardSubscriber)>,
    /// Of a train whose wagons are judged together.
    verdicts: Option<VerdictSubscriber>,
    sources: SourceSubscriber,
    heartbeats: HeartbeatSubscriber,
    events: EventSubscriber,
    own: HeartbeatPublisher,
    sequence: u64,
}

impl Ends {
    /// Opens the channels of this train.
    pub fn open(settings: &TrainSettings) -> Result<Self, BusError> {
        let bus = Bus::open(BusConfig::of(settings), ProcessKind::Health, NO_WAGON)?;
        let wagons = settings.wagons.iter();
        let health = wagons
            .map(|wagon| Ok((wagon.number, bus.health_subscriber(wagon.number)?)))
            .collect::<Result<_, BusError>>()?;
        let microphones = settings.microphones.iter();
        let heard = microphones
            .map(|microphone| Ok((microphone.wagon, bus.heard_subscriber(microphone.wagon)?)))
            .collect::<Result<_, BusError>>()?;
        let verdicts = settings.judged_together.then(|| bus.verdict_subscriber()).transpose()?;
        let sources = bus.source_subscriber()?;
        let (heartbeats, own) = (bus.heartbeat_subscriber()?, bus.heartbeat_publisher()?);
        let events = bus.event_subscriber()?;
        Ok(Self { bus, health, heard, verdicts, sources, heartbeats, events, own, sequence: 0 })
    }

    /// Hands on everything that has arrived.
    pub fn receive(
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
        for (wagon, subscriber) in &mut self.health {
            subscriber.receive(|batch| {
                let now = now();
                for health in batch {
                    let health = store.limit(health);
                    let Some(health) = store.receive_health(*wagon, &health, now) else { continue };
                    if let Some(recorder) = recorder {
                        recorder.take(&health);
                    }
                    watch.health(&health).into_iter().for_each(tell);
                }
            })?;
        }
        for (wagon, subscriber) in &mut self.heard {
            subscriber.receive(|batch| {
                let now = now();
                for heard in batch {
                    let _ = store.receive_heard(*wagon, heard, now);
                }
            })?;
        }
        if let Some(verdicts) = &mut self.verdicts {
            verdicts.receive(|batch| {
                let now = now();
                for verdicts in batch {
                    let _ = store.receive_verdicts(verdicts, now);
                }
            })?;
        }
        self.sources.receive(|batch| {
            let now = now();
            for state in batch {
                let _ = store.receive_source(state, now);
            }
        })?;
        self.events.receive(|batch| {
            let now = now();
            for event in batch.iter().filter_map(|event| store.receive_event(event, now)) {
                watch.told(&event).into_iter().for_each(tell);
            }
        })?;
        self.heartbeats.receive(|batch| {
            let now = now();
            for beat in batch.iter().filter_map(|beat| store.receive_heartbeat(beat, now)) {
                watch.heartbeat(&beat).into_iter().for_each(tell);
            }
        })?;
        Ok(())
    }

    /// Sends a sign of life.
    pub fn beat(&mut self, uptime_s: f64) -> Result<(), BusError> {
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
