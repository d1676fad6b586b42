//! The ends of an audio channel: blocks of samples of any length, with a header each.

use std::sync::Arc;
use std::time::Duration;

use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::{publisher, subscriber};
use iceoryx2::prelude::ipc;
use railgrip_messages::AudioHeader;

use crate::BusError;
use crate::ports::{Sequence, Wake, Waking, hush, wait_on};
use crate::presence::Membership;

/// Samples of one block, at most: a quarter of a second at 48 kHz.
pub const MAX_AUDIO_BLOCK: usize = 12_000;
/// Blocks that a listener can be behind. Blocks are large, so there are fewer than of other batches.
pub(crate) const AUDIO_BUFFER: usize = 16;

/// Sends the audio of one microphone. It never waits for a reader.
pub struct AudioPublisher {
    name: String,
    port: publisher::Publisher<ipc::Service, [f32], AudioHeader>,
    notifier: Notifier<ipc::Service>,
    _member: Arc<Membership>,
}

impl AudioPublisher {
    pub(crate) const fn new(
        name: String,
        port: publisher::Publisher<ipc::Service, [f32], AudioHeader>,
        notifier: Notifier<ipc::Service>,
        member: Arc<Membership>,
    ) -> Self {
        Self { name, port, notifier, _member: member }
    }

    /// Sends one block and wakes the listener.
    ///
    /// # Errors
    /// More than [`MAX_AUDIO_BLOCK`] samples; if iceoryx2 has no memory for them or cannot reach a reader.
    pub fn publish(&self, header: AudioHeader, samples: &[f32]) -> Result<(), BusError> {
        let failed = |error: &dyn std::fmt::Debug| BusError::transport(&self.name, "send", error);
        let mut loan = self.port.loan_slice_uninit(samples.len()).map_err(|error| failed(&error))?;
        *loan.user_header_mut() = header;
        loan.write_from_slice(samples).send().map_err(|error| failed(&error))?;
        self.notifier.notify().map_err(|error| BusError::transport(&self.name, "wake readers", error))?;
        Ok(())
    }
}

/// Receives the audio of one microphone.
pub struct AudioSubscriber {
    name: String,
    port: subscriber::Subscriber<ipc::Service, [f32], AudioHeader>,
    waking: Waking,
    sequence: Sequence,
    _member: Arc<Membership>,
}

impl AudioSubscriber {
    pub(crate) fn new(
        name: String,
        port: subscriber::Subscriber<ipc::Service, [f32], AudioHeader>,
        waking: Waking,
        member: Arc<Membership>,
    ) -> Self {
        Self { name, port, waking, sequence: Sequence::default(), _member: member }
    }

    /// Sleeps until a block arrives or `timeout` is over.
    ///
    /// # Errors
    /// If the system refuses to wait.
    pub fn wait(&self, timeout: Duration) -> Result<Wake, BusError> {
        wait_on(Some(&self.waking), &self.name, timeout)
    }

    /// Hands every block that waits to `take`, oldest first, and says how many there were.
    ///
    /// # Errors
    /// If a publisher cannot be reached; what was received before stays valid.
    pub fn receive(&mut self, mut take: impl FnMut(&AudioHeader, &[f32])) -> Result<usize, BusError> {
        hush(Some(&self.waking), &self.name)?;
        let failed = |error: &dyn std::fmt::Debug| BusError::transport(&self.name, "receive", error);
        let mut blocks = 0;
        while let Some(block) = self.port.receive().map_err(|error| failed(&error))? {
            let header = *block.user_header();
            self.sequence.take(header.sequence);
            take(&header, block.payload());
            blocks += 1;
        }
        Ok(blocks)
    }

    /// Blocks that never arrived, so far.
    #[must_use]
    pub const fn missed(&self) -> u64 {
        self.sequence.missed
    }
}
