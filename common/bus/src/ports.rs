//! The typed ends of a channel.

use std::sync::Arc;
use std::time::Duration;

use iceoryx2::port::listener::Listener;
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::port::{publisher, subscriber};
use iceoryx2::prelude::{
    CallbackProgression, SignalHandlingMode, WaitSet, WaitSetBuilder, WaitSetGuard, ipc,
};
use iceoryx2::waitset::WaitSetAttachmentError;
use railgrip_messages::{
    BogieSample, Estimate, Event, Health, Heard, Heartbeat, Innovation, MotorSample, Payload, Sample,
    SourceState, Verdicts,
};

use crate::BusError;
use crate::presence::Membership;

/// Sends samples of one wagon.
pub type SamplePublisher = Publisher<Sample>;
/// Receives samples of one wagon.
pub type SampleSubscriber = Subscriber<Sample>;
/// Sends motor samples of one rig.
pub type MotorPublisher = Publisher<MotorSample>;
/// Receives motor samples of one rig.
pub type MotorSubscriber = Subscriber<MotorSample>;
/// Sends samples of one bogie rig.
pub type BogiePublisher = Publisher<BogieSample>;
/// Receives samples of one bogie rig.
pub type BogieSubscriber = Subscriber<BogieSample>;
/// Sends estimates of one wagon.
pub type EstimatePublisher = Publisher<Estimate>;
/// Receives estimates of one wagon.
pub type EstimateSubscriber = Subscriber<Estimate>;
/// Sends innovations of one wagon.
pub type InnovationPublisher = Publisher<Innovation>;
/// Receives innovations of one wagon.
pub type InnovationSubscriber = Subscriber<Innovation>;
/// Sends the indicators of one wagon.
pub type HealthPublisher = Publisher<Health>;
/// Receives the indicators of one wagon.
pub type HealthSubscriber = Subscriber<Health>;
/// Sends what the microphone of one wagon heard.
pub type HeardPublisher = Publisher<Heard>;
/// Receives what the microphone of one wagon heard.
pub type HeardSubscriber = Subscriber<Heard>;
/// Sends what is wrong with the train.
pub type VerdictPublisher = Publisher<Verdicts>;
/// Receives what is wrong with the train.
pub type VerdictSubscriber = Subscriber<Verdicts>;
/// Sends events.
pub type EventPublisher = Publisher<Event>;
/// Receives events.
pub type EventSubscriber = Subscriber<Event>;
/// Sends how the source fares.
pub type SourcePublisher = Publisher<SourceState>;
/// Receives how the source fares.
pub type SourceSubscriber = Subscriber<SourceState>;
/// Sends heartbeats.
pub type HeartbeatPublisher = Publisher<Heartbeat>;
/// Receives heartbeats.
pub type HeartbeatSubscriber = Subscriber<Heartbeat>;

/// The sending end of a channel. It never waits for a reader.
pub struct Publisher<T: Payload> {
    name: String,
    port: publisher::Publisher<ipc::Service, [T], ()>,
    notifier: Option<Notifier<ipc::Service>>,
    max_batch: usize,
    _member: Arc<Membership>,
}

impl<T: Payload> Publisher<T> {
    pub(crate) const fn new(
        name: String,
        port: publisher::Publisher<ipc::Service, [T], ()>,
        notifier: Option<Notifier<ipc::Service>>,
        max_batch: usize,
        member: Arc<Membership>,
    ) -> Self {
        Self { name, port, notifier, max_batch, _member: member }
    }

    /// Items that travel in one message, at most; [`Publisher::publish`] splits longer slices.
    #[must_use]
    pub const fn max_batch(&self) -> usize {
        self.max_batch
    }

    /// Sends the items in order and wakes the readers once. Without readers this is cheap.
    ///
    /// # Errors
    /// If iceoryx2 has no memory for the batch or cannot reach a reader.
    pub fn publish(&self, items: &[T]) -> Result<(), BusError> {
        self.send(items)?;
        if items.is_empty() { Ok(()) } else { self.wake() }
    }

    /// Sends the items in order and lets the readers sleep.
    ///
    /// # Errors
    /// If iceoryx2 has no memory for the batch or cannot reach a reader.
    pub fn send(&self, items: &[T]) -> Result<(), BusError> {
        for batch in items.chunks(self.max_batch) {
            let failed = |error: &dyn std::fmt::Debug| BusError::transport(&self.name, "send", error);
            let loan = self.port.loan_slice_uninit(batch.len()).map_err(|error| failed(&error))?;
            loan.write_from_slice(batch).send().map_err(|error| failed(&error))?;
        }
        Ok(())
    }

    /// Wakes the readers. On a busy processor they may run before this comes back.
    ///
    /// # Errors
    /// If a reader cannot be reached.
    pub fn wake(&self) -> Result<(), BusError> {
        match &self.notifier {
            Some(notifier) => notifier
                .notify()
                .map(drop)
                .map_err(|error| BusError::transport(&self.name, "wake readers", error)),
            None => Ok(()),
        }
    }

    /// Finds readers that joined since the last message and gives them the history.
    ///
    /// # Errors
    /// If a reader cannot be reached.
    pub fn refresh(&self) -> Result<(), BusError> {
        self.port
            .update_connections()
            .map_err(|error| BusError::transport(&self.name, "look for new readers", error))
    }
}

/// Why [`Subscriber::wait`] came back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wake {
    /// Something arrived.
    Data,
    /// The time is over (or a signal came): look at the stop flag and at timers.
    Timeout,
}

/// The receiving end of a channel.
pub struct Subscriber<T: Payload> {
    name: String,
    port: subscriber::Subscriber<ipc::Service, [T], ()>,
    waking: Option<Waking>,
    sequence: Option<Sequence>,
    _member: Arc<Membership>,
}

/// What wakes a reader.
pub(crate) struct Bell {
    listener: Listener<ipc::Service>,
    waitset: WaitSet<ipc::Service>,
}

type Attachment<'a> = WaitSetGuard<'a, 'a, ipc::Service>;

self_cell::self_cell!(
    /// The bell with its listener attached to its wait set. The attachment borrows both; attaching anew for each wait
    /// would cost ten system calls a wake-up.
    pub(crate) struct Waking {
        owner: Bell,
        #[not_covariant]
        dependent: Attachment,
    }
);

/// Attaches a listener to a wait set of its own.
pub(crate) fn waking(name: &str, listener: Listener<ipc::Service>) -> Result<Waking, BusError> {
    let waitset = WaitSetBuilder::new()
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<ipc::Service>()
        .map_err(|error| BusError::transport(name, "prepare to wait", error))?;
    Waking::try_new(Bell { listener, waitset }, attach)
        .map_err(|error| BusError::transport(name, "prepare to wait", error))
}

/// Sleeps until the bell rings or `timeout` is over; without a bell it only sleeps.
pub(crate) fn wait_on(waking: Option<&Waking>, name: &str, timeout: Duration) -> Result<Wake, BusError> {
    let Some(Bell { waitset, .. }) = waking.map(Waking::borrow_owner) else {
        std::thread::sleep(timeout);
        return Ok(Wake::Timeout);
    };
    let mut wake = Wake::Timeout;
    waitset
        .wait_and_process_once_with_timeout(
            |_| {
                wake = Wake::Data;
                CallbackProgression::Continue
            },
            timeout,
        )
        .map_err(|error| BusError::transport(name, "wait", error))?;
    Ok(wake)
}

/// Takes note of all that rang so far.
pub(crate) fn hush(waking: Option<&Waking>, name: &str) -> Result<(), BusError> {
    let Some(waking) = waking else { return Ok(()) };
    let heard = waking.borrow_owner().listener.try_wait(|_| {});
    heard.map(|_| ()).map_err(|error| BusError::transport(name, "receive", error))
}

fn attach<'a>(bell: &'a Bell) -> Result<Attachment<'a>, WaitSetAttachmentError> {
    bell.waitset.attach_notification(&bell.listener)
}

/// No reader misses more at once: fifty days of a thousand a second.
const MOST_MISSED: u64 = 1 << 32;

/// Counts what is missing in a running number.
#[derive(Debug, Default)]
pub(crate) struct Sequence {
    next: Option<u64>,
    /// What would follow a number that was too far ahead to be believed.
    strange: Option<u64>,
    pub(crate) missed: u64,
    restarts: u64,
}

impl Sequence {
    /// A number ahead of the expected one is a gap; one behind it is a source that began again. One that is absurdly far ahead
    /// is nonsense, unless the next one goes on from there.
    pub(crate) fn take(&mut self, sequence: u64) {
        let follows = self.strange.take() == Some(sequence);
        match self.next {
            Some(next) if sequence.saturating_sub(next) > MOST_MISSED => {
                if !follows {
                    self.strange = Some(sequence.wrapping_add(1));
                    return;
                }
                self.restarts += 1;
            }
            Some(next) if sequence > next => self.missed += sequence - next,
            Some(next) if sequence < next => self.restarts += 1,
            _ => {}
        }
        self.next = Some(sequence.wrapping_add(1));
    }
}

impl<T: Payload> Subscriber<T> {
    pub(crate) fn new(
        name: String,
        port: subscriber::Subscriber<ipc::Service, [T], ()>,
        listener: Option<Listener<ipc::Service>>,
        counted: bool,
        member: Arc<Membership>,
    ) -> Result<Self, BusError> {
        let waking = listener.map(|listener| waking(&name, listener)).transpose()?;
        Ok(Self { name, port, waking, sequence: counted.then(Sequence::default), _member: member })
    }

    /// Sleeps until something arrives or `timeout` is over. On a channel without wake-ups it only sleeps.
    ///
    /// # Errors
    /// If the system refuses to wait.
    pub fn wait(&self, timeout: Duration) -> Result<Wake, BusError> {
        wait_on(self.waking.as_ref(), &self.name, timeout)
    }

    /// Hands every batch that waits to `take`, oldest first, and says how many items there were.
    ///
    /// # Errors
    /// If a publisher cannot be reached; what was received before stays valid.
    pub fn receive(&mut self, mut take: impl FnMut(&[T])) -> Result<usize, BusError> {
        let failed = |error: &dyn std::fmt::Debug| BusError::transport(&self.name, "receive", error);
        hush(self.waking.as_ref(), &self.name)?;
        let mut items = 0;
        while let Some(batch) = self.port.receive().map_err(|error| failed(&error))? {
            let batch = batch.payload();
            if let Some(sequence) = &mut self.sequence {
                batch.iter().for_each(|item| sequence.take(item.sequence()));
            }
            items += batch.len();
            take(batch);
        }
        Ok(items)
    }

    /// Items that never arrived, so far; 0 on channels that do not count.
    #[must_use]
    pub fn missed(&self) -> u64 {
        self.sequence.as_ref().map_or(0, |sequence| sequence.missed)
    }

    /// How often the source began to count again.
    #[must_use]
    pub fn restarts(&self) -> u64 {
        self.sequence.as_ref().map_or(0, |sequence| sequence.restarts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_count_as_missed_and_steps_back_as_restarts() {
        let mut sequence = Sequence::default();
        for number in [100, 101, 105, 106, 0, 1, 2, 4] {
            sequence.take(number);
        }
        assert_eq!((sequence.missed, sequence.restarts), (3 + 1, 1));
    }

    /// One sample with the number u64::MAX once counted as 1.8e19 missed ones.
    #[test]
    fn a_number_that_nobody_counts_to_is_no_gap() {
        let mut sequence = Sequence::default();
        [100, 101, u64::MAX, 102, 104, u64::MAX, u64::MAX, 105]
            .into_iter()
            .for_each(|number| sequence.take(number));
        assert_eq!((sequence.missed, sequence.restarts), (1, 0));
        [1 << 60, (1 << 60) + 1, (1 << 60) + 3].into_iter().for_each(|number| sequence.take(number));
        assert_eq!((sequence.missed, sequence.restarts), (2, 1), "a source that counts from elsewhere");
    }
}
