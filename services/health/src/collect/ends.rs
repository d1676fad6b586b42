//! The ends of the channels that this service reads, and of its own heartbeat.

use crate::history::Recorder;
use crate::history::watch::Watch;
use crate::store::Store;
use railgrip_bus::{
    Bus, BusConfig, BusError, HealthSubscriber, HeardSubscriber, HeartbeatPublisher, HeartbeatSubscriber, now,
};
use railgrip_messages::{Heartbeat, NO_WAGON, ProcessKind};
use railgrip_settings::TrainSettings;

/// All ends. Ports stay on the thread that opened them.
pub(super) struct Ends {
    pub bus: Bus,
    health: Vec<HealthSubscriber>,
    heard: Vec<HeardSubscriber>,
    heartbeats: HeartbeatSubscriber,
    own: HeartbeatPublisher,
    sequence: u64,
}

impl Ends {
    /// Opens the channels of this train.
    pub fn open(settings: &TrainSettings) -> Result<Self, BusError> {
        let bus = Bus::open(BusConfig::of(settings), ProcessKind::Health, NO_WAGON)?;
        let wagons = settings.wagons.iter();
        let health = wagons.map(|wagon| bus.health_subscriber(wagon.number)).collect::<Result<_, _>>()?;
        let microphones = settings.microphones.iter();
        let heard =
            microphones.map(|microphone| bus.heard_subscriber(microphone.wagon)).collect::<Result<_, _>>()?;
        let (heartbeats, own) = (bus.heartbeat_subscriber()?, bus.heartbeat_publisher()?);
        Ok(Self { bus, health, heard, heartbeats, own, sequence: 0 })
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
