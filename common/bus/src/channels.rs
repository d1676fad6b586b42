//! The one table of channels. Nothing else in the system names a channel, its payload or its sizes.

use railgrip_messages::{
    AUDIO_TYPE_NAME, BogieSample, Estimate, Event, Health, Heard, Heartbeat, Innovation, MotorSample,
    Payload, Sample, SourceState, Verdicts,
};

use crate::audio::{AUDIO_BUFFER, MAX_AUDIO_BLOCK};
use crate::creator::{Creator, Kept, Service};
use crate::{BusError, Limits};

/// Whether a channel exists once a wagon or once a train.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// One channel for each wagon, `name/N`.
    Wagon,
    /// One channel for each wagon that has a microphone, `name/N`.
    Microphone,
    /// One channel for the train; every process may publish, unless the row says that one does.
    Train,
}

/// One row of the table.
#[derive(Debug, Clone, Copy)]
pub struct Channel {
    /// The name, without the wagon.
    pub name: &'static str,
    /// Once a wagon or once a train.
    pub scope: Scope,
    /// Name and version of what travels.
    pub payload: &'static str,
    /// Size of one item, bytes.
    pub item_bytes: usize,
    /// Items come in batches of up to `Limits::max_batch`; otherwise one by one.
    pub batched: bool,
    /// Messages a second in normal operation, for a reader who sizes something; 0 = when something happens.
    pub rate_hz: f64,
    /// Silence longer than this means that something is wrong, s; infinite where silence is normal.
    pub deadline_s: f64,
    /// Batches that a late joiner gets.
    pub history: usize,
    /// One process of the train publishes, and no other does.
    pub alone: bool,
    /// Readers are woken (otherwise they poll).
    pub wakes: bool,
    /// `sequence` counts items without gaps, so that readers can count what they missed.
    pub counted: bool,
    /// Creates the channel with the type of its payload.
    pub(crate) create: fn(&Creator<'_>, &Service) -> Result<Kept, BusError>,
}

/// Every channel there is.
pub const CHANNELS: &[Channel] = &[
    row::<Sample>("samples", Scope::Wagon).batched().rate(100.0, 1.0).history(16).wakes().counted(),
    row::<MotorSample>("motors", Scope::Wagon).batched().rate(100.0, 1.0).history(16).wakes().counted(),
    row::<BogieSample>("bogies", Scope::Wagon).batched().rate(100.0, 1.0).history(16).wakes().counted(),
    row::<Estimate>("estimates", Scope::Wagon).batched().rate(100.0, 1.0).history(1).counted(),
    row::<Innovation>("innovations", Scope::Wagon).batched().rate(100.0, 1.0).history(1).counted(),
    row::<Health>("health", Scope::Wagon).rate(5.0, 2.0).history(1),
    audio("audio").rate(10.0, 2.0),
    row::<Heard>("heard", Scope::Microphone).rate(1.0, 5.0).history(1),
    row::<Verdicts>("verdicts", Scope::Train).rate(1.0, 5.0).history(1).alone(),
    row::<Event>("events", Scope::Train).history(16),
    row::<SourceState>("sources", Scope::Train).batched().rate(1.0, 5.0).history(1).alone(),
    row::<Heartbeat>("heartbeats", Scope::Train).rate(1.0, 5.0).history(1),
];

/// The row of a channel.
#[must_use]
pub fn channel(name: &str) -> Option<&'static Channel> {
    CHANNELS.iter().find(|channel| channel.name == name)
}

const fn row<T: Payload>(name: &'static str, scope: Scope) -> Channel {
    Channel {
        name,
        scope,
        payload: T::TYPE_NAME,
        item_bytes: size_of::<T>(),
        batched: false,
        rate_hz: 0.0,
        deadline_s: f64::INFINITY,
        history: 0,
        alone: false,
        wakes: false,
        counted: false,
        create: |creator, service| creator.channel::<T>(service),
    }
}

/// Blocks of samples of any length, each with a header.
const fn audio(name: &'static str) -> Channel {
    Channel {
        payload: AUDIO_TYPE_NAME,
        item_bytes: size_of::<f32>(),
        counted: true,
        create: |creator, service| creator.audio(service),
        ..row::<Heard>(name, Scope::Microphone).wakes()
    }
}

impl Channel {
    const fn batched(mut self) -> Self {
        self.batched = true;
        self
    }

    const fn rate(mut self, rate_hz: f64, deadline_s: f64) -> Self {
        self.rate_hz = rate_hz;
        self.deadline_s = deadline_s;
        self
    }

    const fn history(mut self, batches: usize) -> Self {
        self.history = batches;
        self
    }

    const fn alone(mut self) -> Self {
        self.alone = true;
        self
    }

    const fn wakes(mut self) -> Self {
        self.wakes = true;
        self
    }

    const fn counted(mut self) -> Self {
        self.counted = true;
        self
    }

    /// Items of one batch, at most.
    #[must_use]
    pub const fn max_batch(&self, limits: &Limits) -> usize {
        if self.batched { limits.max_batch } else { 1 }
    }

    /// Messages that a reader can be behind, and items of one message.
    pub(crate) fn capacity(&self, limits: &Limits) -> (usize, usize) {
        if self.payload == AUDIO_TYPE_NAME {
            return (AUDIO_BUFFER, MAX_AUDIO_BLOCK);
        }
        (limits.buffer, self.max_batch(limits))
    }

    /// The name of the service in iceoryx2.
    pub(crate) fn service_name(&self, wagon: u32) -> String {
        match self.scope {
            Scope::Wagon | Scope::Microphone => format!("{}/{wagon}", self.name),
            Scope::Train => self.name.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_payloads_carry_versions() {
        for (index, row) in CHANNELS.iter().enumerate() {
            assert!(row.payload.starts_with("railgrip/") && row.payload.contains("/v"), "{}", row.payload);
            assert!(CHANNELS[..index].iter().all(|other| other.name != row.name), "{} twice", row.name);
        }
        assert_eq!(channel("samples").map(|row| row.service_name(7)).as_deref(), Some("samples/7"));
        assert_eq!(channel("events").map(|row| row.service_name(7)).as_deref(), Some("events"));
    }
}
