//! What waits to be sent for one wagon.

use crate::Counters;
use crate::validate;
use railgrip_bus::{BusError, SamplePublisher};
use railgrip_messages::{Sample, Stamp, sample_flags};
use railgrip_recording::Row;

/// The batch of one wagon.
pub(crate) struct Outbox {
    wagon: u32,
    publisher: SamplePublisher,
    batch: Vec<Sample>,
    sequence: u64,
    last_time_s: f64,
    begins: bool,
    failing: bool,
}

impl Outbox {
    pub fn new(wagon: u32, publisher: SamplePublisher) -> Self {
        let batch = Vec::with_capacity(publisher.max_batch());
        Self {
            wagon,
            publisher,
            batch,
            sequence: 0,
            last_time_s: f64::NEG_INFINITY,
            begins: true,
            failing: false,
        }
    }

    /// Validates and stamps one row and puts it into the batch.
    pub fn take(
        &mut self,
        row: &Row,
        wheelsets: usize,
        begins: bool,
        acquired: Stamp,
        counters: &mut Counters,
    ) {
        self.begins |= begins;
        let (sample, refused) = validate::sample(row, wheelsets);
        counters.rejected += u64::from(refused);
        let Some(mut sample) = sample else { return };
        if self.begins {
            sample.flags |= sample_flags::TIME_BASE_RESTARTED;
            self.begins = false;
        } else if sample.time_s <= self.last_time_s {
            counters.late += 1;
        }
        self.last_time_s = sample.time_s;
        sample.sequence = self.sequence;
        sample.acquired = acquired;
        self.sequence += 1;
        self.batch.push(sample);
    }

    /// Sends the batch; gives the number of samples sent. Trouble with one wagon's channel does not stop the others,
    /// it is told once and shows as missed samples.
    pub fn send(&mut self) -> Result<u64, BusError> {
        if self.batch.is_empty() {
            return Ok(0);
        }
        let sent = self.batch.len() as u64;
        let result = self.publisher.publish(&self.batch);
        self.batch.clear();
        match result {
            Ok(()) => {
                self.failing = false;
                Ok(sent)
            }
            Err(error) => {
                if !self.failing {
                    tracing::warn!(wagon = self.wagon, %error, "a batch is lost");
                }
                self.failing = true;
                Ok(0)
            }
        }
    }
}
