//! Blocks of audio into windows of one second.

use railgrip_messages::{AudioHeader, Stamp, sample_flags};

/// Longest time without a block after which the audio is called absent, s.
pub(crate) const ABSENT_S: f64 = 1.5;

/// One second of audio as it arrived.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Second {
    /// When its last sample was taken.
    pub acquired: Stamp,
    /// Samples a second.
    pub sample_rate_hz: u32,
    /// The samples.
    pub samples: Vec<f32>,
}

/// Gathers blocks until a second is full. A gap, another sample rate and a new beginning empty it: a window is never
/// put together from pieces that do not belong together.
#[derive(Debug, Default)]
pub(crate) struct Gatherer {
    sample_rate_hz: u32,
    next: Option<u64>,
    samples: Vec<f32>,
}

impl Gatherer {
    /// Takes a block; hands over every second that it fills.
    pub fn take(&mut self, header: &AudioHeader, block: &[f32], full: &mut impl FnMut(Second)) {
        let begins = header.flags & sample_flags::TIME_BASE_RESTARTED != 0;
        let follows = self.next == Some(header.sequence);
        if begins || !follows || header.sample_rate_hz != self.sample_rate_hz {
            self.samples.clear();
        }
        self.next = Some(header.sequence.wrapping_add(1));
        self.sample_rate_hz = header.sample_rate_hz;
        self.samples.extend_from_slice(block);
        let second = self.sample_rate_hz as usize;
        // Nothing is sampled slower than this; without a rate there is no second.
        if second == 0 {
            self.samples.clear();
            return;
        }
        while self.samples.len() >= second {
            let rest = self.samples.split_off(second);
            let samples = std::mem::replace(&mut self.samples, rest);
            full(Second { acquired: header.acquired, sample_rate_hz: self.sample_rate_hz, samples });
        }
    }
}

/// Root mean square of samples over full scale, dB; −200 in silence.
pub(crate) fn level_db(samples: &[f32]) -> f64 {
    let power: f64 = samples.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>() / samples.len().max(1) as f64;
    if power.is_finite() { 10.0 * power.max(1e-20).log10() } else { -200.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(sequence: u64, sample_rate_hz: u32, flags: u32) -> AudioHeader {
        AudioHeader { sequence, sample_rate_hz, flags, ..AudioHeader::default() }
    }

    #[test]
    fn seconds_are_whole_and_never_patched_together() {
        let mut gatherer = Gatherer::default();
        let mut lengths = Vec::new();
        let mut take = |sequence, rate, flags, length: usize, value: f32| {
            gatherer.take(&header(sequence, rate, flags), &vec![value; length], &mut |second| {
                lengths.push((second.sample_rate_hz, second.samples.len(), second.samples[0]));
            });
        };
        take(5, 1000, 0, 600, 0.1);
        take(6, 1000, 0, 1500, 0.2); // fills two seconds, 100 remain
        take(8, 1000, 0, 950, 0.3); // 7 is lost: the 100 go
        take(9, 1000, 0, 60, 0.4);
        take(10, 2000, 0, 1999, 0.5); // another rate
        take(11, 2000, 1, 1, 0.6); // a new beginning
        take(12, 0, 0, 5, 0.7);
        assert_eq!(lengths, [(1000, 1000, 0.1), (1000, 1000, 0.2), (1000, 1000, 0.3)]);
    }

    #[test]
    fn levels_are_those_of_full_scale() {
        assert_eq!(level_db(&[1.0, -1.0]), 0.0);
        assert_eq!(level_db(&[0.0; 10]), -200.0);
        assert!((level_db(&[0.1; 10]) + 20.0).abs() < 1e-4);
    }
}
