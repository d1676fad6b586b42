//! What is wrong with a train, as all its wagons together show it.

use bytemuck::{Pod, Zeroable};
use iceoryx2_bb_derive_macros::ZeroCopySend;
use iceoryx2_bb_elementary_traits::zero_copy_send::ZeroCopySend;

use crate::{Stamp, Text, payload, zero_default};

/// Places for verdicts; of more, the first ones are told.
pub const MAX_VERDICTS: usize = 32;
/// Places for what a verdict may be instead.
pub const MAX_RUNNERS: usize = 3;

/// One fault: the cause that explains what is seen, and where. Codes of causes belong to the crate of the causes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("railgrip/Verdict/v1")]
pub struct Verdict {
    /// Wagons concerned: bit `n − 1` of all words together belongs to wagon `n`; none: the whole train.
    pub wagons: [u64; 4],
    /// Probability of the cause.
    pub probability: f64,
    /// Probabilities of what it may be instead.
    pub instead_probability: [f64; MAX_RUNNERS],
    /// Codes of these; 0 where there is none.
    pub instead: [u32; MAX_RUNNERS],
    /// Code of the cause.
    pub cause: u32,
    /// Code of a [`crate::Grade`].
    pub grade: u32,
    /// Wheelsets that it may be, bit mask; none: the wagon as a whole.
    pub wheelsets: u32,
    /// Brake applications seen until it was found.
    pub brakings_seen: u32,
    /// Running number of the verdict, 1 first; a judge that goes on from the memory of the one before counts on.
    pub number: u32,
    /// Time base of the sensors at which it was found, s.
    pub found_t_s: f64,
    /// Why.
    pub reason: Text,
}
zero_default!(Verdict);

impl Verdict {
    /// Numbers of the wagons concerned, front first.
    pub fn wagons(&self) -> impl Iterator<Item = u32> + '_ {
        (0..256).filter(|bit| self.wagons[bit / 64] >> (bit % 64) & 1 == 1).map(|bit| bit as u32 + 1)
    }

    /// Adds a wagon; beyond 256 nothing happens.
    pub fn add_wagon(&mut self, wagon: u32) {
        let bit = (wagon as usize).wrapping_sub(1);
        if let Some(word) = self.wagons.get_mut(bit / 64) {
            *word |= 1 << (bit % 64);
        }
    }
}

/// Everything that is wrong with the train now (channel `verdicts`, about once a second; late joiners get the last one).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("railgrip/Verdicts/v1")]
pub struct Verdicts {
    /// Counts these messages.
    pub sequence: u64,
    /// When it was published.
    pub stamp: Stamp,
    /// Time base of the sensors at the latest instant that was judged, s.
    pub time_s: f64,
    /// Instants judged since the judge began.
    pub instants: u64,
    /// Brake applications seen by this judge and those whose memory it goes on from.
    pub brakings: u32,
    /// Verdicts in use.
    pub count: u32,
    /// Wagons of the train.
    pub wagons: u32,
    /// Always 0.
    pub reserved: u32,
    /// The verdicts that stand, oldest first.
    pub verdict: [Verdict; MAX_VERDICTS],
}
payload!(Verdicts, "railgrip/Verdicts/v1");

impl Verdicts {
    /// The verdicts that stand, never more than there are places.
    #[must_use]
    pub fn standing(&self) -> &[Verdict] {
        &self.verdict[..(self.count as usize).min(MAX_VERDICTS)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wagons_are_a_set() {
        let mut verdict = Verdict::default();
        for wagon in [200, 3, 64, 65, 0, 300] {
            verdict.add_wagon(wagon);
        }
        assert_eq!(verdict.wagons().collect::<Vec<_>>(), [3, 64, 65, 200]);
    }
}
