//! Payloads that were refused on receipt, counted by what they are and why.

use railgrip_messages::Refusal;
use std::collections::BTreeMap;

/// How many were refused.
#[derive(Debug, Default, Clone)]
pub(super) struct Refused {
    counts: BTreeMap<(&'static str, Refusal), u64>,
    /// By channel, since the last payload of its wagon that was taken.
    since_taken: BTreeMap<u32, (Refusal, u64)>,
}

impl Refused {
    /// Counts one of the channel of a wagon ([`railgrip_messages::NO_WAGON`] for a channel of all).
    pub fn count(&mut self, payload: &'static str, channel: u32, why: Refusal) {
        let count = self.counts.entry((payload, why)).or_insert(0);
        *count += 1;
        // Ever more rarely: a process that errs does so many times a second.
        if count.is_power_of_two() {
            tracing::warn!(payload, channel, why = why.word(), count = *count, "a payload is refused");
        }
        let (latest, number) = self.since_taken.entry(channel).or_insert((why, 0));
        (*latest, *number) = (why, *number + 1);
    }

    /// A payload of this channel was taken.
    pub fn taken(&mut self, channel: u32) {
        self.since_taken.remove(&channel);
    }

    /// Why the latest payload of this channel was refused, and how many were since one was taken.
    pub fn since_taken(&self, channel: u32) -> Option<(Refusal, u64)> {
        self.since_taken.get(&channel).copied()
    }

    /// Payload, reason and count.
    pub fn counts(&self) -> impl Iterator<Item = (&'static str, Refusal, u64)> {
        self.counts.iter().map(|((payload, why), count)| (*payload, *why, *count))
    }
}
