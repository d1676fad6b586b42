//! What was sent while no estimator of the wagon was there: an estimator leaves behind which sample it took last, and its successor,
//! however the first one ended, sees by the running number of its own first sample how many were sent in between.
//!
//! The note is made after the estimates are sent: of what was just being sent when the first one died, a batch at most counts too.

use std::hash::Hash;
use std::path::PathBuf;

use railgrip_bus::Ledger;
use railgrip_messages::Stamp;

use crate::worker::Worker;

/// Running number and stamp of the last sample, and how many were unseen before.
const WORDS: usize = 3;

/// Counts them, over all estimators of a wagon since the train has started.
pub(crate) struct Absence {
    file: PathBuf,
    ledger: Option<Ledger>,
    failing: bool,
    /// The last sample of the predecessor, ns of the monotonic clock.
    left: Option<(u64, u64)>,
    noted: Option<u64>,
    unseen: u64,
}

impl Absence {
    /// Takes over what a predecessor has left about the same.
    pub fn open(file: PathBuf, about: &impl Hash) -> Self {
        let mut absence = Self { file, ledger: None, failing: false, left: None, noted: None, unseen: 0 };
        match Ledger::open(&absence.file, about, WORDS) {
            Ok((ledger, left)) => {
                absence.ledger = Some(ledger);
                if let Some(&[sequence, stamp_ns, unseen]) = left.as_ref().map(|left| left.latest.as_slice())
                {
                    (absence.left, absence.unseen) = (Some((sequence, stamp_ns)), unseen);
                }
            }
            Err(error) => absence.trouble(&error),
        }
        absence
    }

    /// Takes note of what the worker has taken.
    pub fn note(&mut self, worker: &Worker) {
        if let Some((first, stamp)) = worker.first
            && let Some(left) = self.left.take()
        {
            self.unseen += unseen_between(left, (first, stamp.monotonic_ns));
        }
        let Some((sequence, Stamp { monotonic_ns, .. })) = worker.last.filter(|_| worker.taken > 0) else {
            return;
        };
        let Some(ledger) = self.ledger.as_mut().filter(|_| self.noted != Some(monotonic_ns)) else { return };
        self.noted = Some(monotonic_ns);
        match ledger.write(&[sequence, monotonic_ns, self.unseen]) {
            Ok(()) => self.failing = false,
            Err(error) => self.trouble(&error),
        }
    }

    /// Samples that were sent while nobody was there.
    pub fn unseen(&self) -> u64 {
        self.unseen
    }

    /// Is told once, until it works again.
    fn trouble(&mut self, error: &std::io::Error) {
        if !self.failing {
            let file = self.file.display();
            tracing::warn!(%file, %error, "a successor will not know what was sent before it was there");
        }
        self.failing = true;
    }
}

/// Samples between the last of one and the first of the next, each a running number and a stamp.
fn unseen_between((left, left_ns): (u64, u64), (first, first_ns): (u64, u64)) -> u64 {
    if first_ns <= left_ns {
        // A late joiner gets the last few once more, and misses nothing.
        0
    } else if first > left {
        first - left - 1
    } else {
        // Whoever sends has begun to count anew; what it sent before that is not known.
        first
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use railgrip_filter::EstimatorConfig;
    use railgrip_indicators::IndicatorSettings;
    use railgrip_messages::Sample;

    fn worker() -> Worker {
        let vehicle =
            toml::from_str(include_str!("../../../config/vehicle.toml")).expect("the default vehicle");
        let indicators = IndicatorSettings::default();
        Worker::with(1, &EstimatorConfig::default(), indicators, vehicle).expect("a filter")
    }

    fn sample(sequence: u64, at: u64) -> Sample {
        let acquired = Stamp { unix_ns: 0, monotonic_ns: 1_000_000_000 + at * 10_000_000 };
        Sample { sequence, acquired, time_s: at as f64 * 0.01, wheelsets: 2, ..Sample::default() }
    }

    /// One estimator that is killed after samples with these numbers, taken at these hundredths of a second.
    fn lived(file: &std::path::Path, about: &str, samples: impl IntoIterator<Item = (u64, u64)>) -> u64 {
        let (mut absence, mut worker) = (Absence::open(file.to_owned(), &about), worker());
        for (sequence, at) in samples {
            worker.estimate(&sample(sequence, at));
            absence.note(&worker);
            worker.clear();
        }
        absence.unseen()
    }

    #[test]
    fn a_successor_counts_what_was_sent_while_nobody_was_there_and_nothing_twice() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("estimator-1.ledger");
        let same = |range: std::ops::Range<u64>| range.map(|k| (k, k)).collect::<Vec<_>>();
        assert_eq!(lived(&file, "a", same(5..100)), 0, "the first has no predecessor");
        assert_eq!(lived(&file, "a", same(130..200)), 30);
        assert_eq!(lived(&file, "a", []), 30, "one that is killed before its first sample");
        assert_eq!(lived(&file, "a", same(195..300)), 30, "a late joiner gets the last few once more");
        assert_eq!(lived(&file, "a", same(301..302)), 31);
        // Whoever sends has begun anew as well.
        assert_eq!(lived(&file, "a", (7..50).map(|k| (k, 400 + k))), 38);
        assert_eq!(lived(&file, "b", same(900..901)), 0, "another start of the train, or another vehicle");
    }
}
