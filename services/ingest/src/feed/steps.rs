//! What the time of a source passes over: a sample that never came in leaves a gap between its neighbours, wherever it was lost —
//! at the sender, on the network, in a queue, or with an ingest that was killed.

/// Steps by which the usual one is known.
const RECENT: usize = 16;
/// So many of them must be whole multiples of the usual one, or the source has no rhythm and nobody can say what is missing.
const REGULAR: usize = 14;
/// How far from a whole multiple a step may be, in usual ones.
const OFF: f64 = 0.2;
/// A step longer than so many usual ones passes over samples.
const LONGER: f64 = 1.5;
/// A longer silence is a pause, s: nobody can say whether the source went on.
const PAUSE_S: f64 = 60.0;
/// Shorter steps are no rhythm of sensors, s.
const SHORTEST_S: f64 = 1e-5;

/// What a sample's time says about those before it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Step {
    /// Nothing is missing, or nobody can say so.
    Usual,
    /// So many samples are missing.
    Skipped(u64),
    /// The source has paused.
    Paused,
}

/// The times of one wagon's source.
#[derive(Debug, Clone, Default)]
pub(crate) struct Steps {
    last_s: Option<f64>,
    usual_s: Option<f64>,
    recent_s: [f64; RECENT],
    filled: usize,
}

impl Steps {
    /// Takes the time of the next sample, which is after that of the one before, s.
    pub fn take(&mut self, t_s: f64) -> Step {
        let Some(last_s) = self.last_s.replace(t_s) else { return Step::Usual };
        let step_s = t_s - last_s;
        let usual_s = self.usual_s;
        self.learn(step_s);
        if step_s > PAUSE_S {
            return Step::Paused;
        }
        match usual_s {
            Some(usual_s) if step_s > LONGER * usual_s => {
                Step::Skipped(((step_s / usual_s).round() - 1.0) as u64)
            }
            _ => Step::Usual,
        }
    }

    /// Whether a time would go on by more than the usual step, s.
    pub fn jumps(&self, t_s: f64) -> bool {
        let longer = |(last_s, usual_s): (f64, f64)| t_s - last_s > LONGER * usual_s;
        self.last_s.zip(self.usual_s).is_some_and(longer)
    }

    /// Another time base begins with a sample of this time, s.
    pub fn begin(&mut self, t_s: f64) {
        *self = Self { last_s: Some(t_s), ..Self::default() };
    }

    /// For a successor: the time of the last sample and the usual step, s; NaN where there is none.
    pub fn known(&self) -> [f64; 2] {
        [self.last_s, self.usual_s].map(|value| value.unwrap_or(f64::NAN))
    }

    /// From a predecessor.
    pub fn of(known: [f64; 2]) -> Self {
        let [last_s, usual_s] = known.map(|value| Some(value).filter(|value| value.is_finite()));
        Self { last_s, usual_s: usual_s.filter(|usual_s| *usual_s >= SHORTEST_S), ..Self::default() }
    }

    fn learn(&mut self, step_s: f64) {
        self.recent_s[self.filled] = step_s;
        self.filled += 1;
        if self.filled < RECENT {
            return;
        }
        self.filled = 0;
        let mut sorted = self.recent_s;
        sorted.sort_by(f64::total_cmp);
        let middle_s = sorted[RECENT / 2 - 1];
        let whole = |step_s: &&f64| {
            let steps = *step_s / middle_s;
            (steps - steps.round()).abs() <= OFF && steps > 0.5
        };
        let regular = sorted.iter().filter(whole).count() >= REGULAR;
        self.usual_s = Some(middle_s).filter(|middle_s| regular && *middle_s >= SHORTEST_S);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Feeds the times for which `keep` holds; gives skipped samples and pauses.
    fn fed(steps: &mut Steps, times: impl Iterator<Item = f64>) -> (u64, u64) {
        let (mut skipped, mut pauses) = (0, 0);
        for t_s in times {
            match steps.take(t_s) {
                Step::Skipped(count) => skipped += count,
                Step::Paused => pauses += 1,
                Step::Usual => {}
            }
        }
        (skipped, pauses)
    }

    fn at(k: u32) -> f64 {
        1_772_366_400.0 + f64::from(k) * 0.001
    }

    #[test]
    fn every_sample_that_is_missing_is_counted_and_none_that_is_there() {
        assert_eq!(fed(&mut Steps::default(), (0..100_000).map(at)), (0, 0));
        // After the first seconds, one of seven is lost, and two stretches.
        let lost = |k: &u32| {
            *k > 2000 && (k.is_multiple_of(7) || (5000..5321).contains(k) || (9000..9999).contains(k))
        };
        let missing = (0..19_999).filter(lost).count() as u64;
        let found = fed(&mut Steps::default(), (0..19_999).filter(|k| !lost(k)).map(at));
        assert_eq!(found, (missing, 0));
    }

    #[test]
    fn a_successor_counts_what_its_predecessor_took_to_the_grave() {
        let mut first = Steps::default();
        fed(&mut first, (0..1000).map(at));
        let mut second = Steps::of(first.known());
        assert_eq!(fed(&mut second, (1234..2000).map(at)), (234, 0));
        assert_eq!(fed(&mut Steps::of([f64::NAN; 2]), (0..100).map(at)), (0, 0));
        assert_eq!(fed(&mut Steps::of([0.0, -1.0]), (50..60).map(f64::from)), (0, 0));
    }

    #[test]
    fn a_new_rate_is_learnt_a_pause_is_none_of_samples_and_what_has_no_rhythm_is_not_counted() {
        let mut steps = Steps::default();
        let slower = (1000..2000).map(|k| at(1000) + f64::from(k - 1000) * 0.01);
        let (skipped, pauses) = fed(&mut steps, (0..1000).map(at).chain(slower));
        // Nobody knows at once that the rate has changed.
        assert!(pauses == 0 && skipped < 2 * 16 * 9, "{skipped}");
        assert_eq!(fed(&mut steps, (0..9).map(|k| at(0) + 100.0 + f64::from(k) * 0.01)), (0, 1));
        let mut seed = 1_u32;
        let mut t_s = 0.0;
        let odd = std::iter::from_fn(|| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            t_s += 0.001 + f64::from(seed >> 8) / 16_777_216.0 * 0.05;
            Some(t_s)
        });
        let (skipped, pauses) = fed(&mut Steps::default(), odd.take(10_000));
        assert!(pauses == 0 && skipped < 100, "{skipped}");
    }

    #[test]
    fn times_that_make_no_sense_do_no_harm() {
        for times in [[0.0, 1e300, 1e301], [0.0, 5e-324, 1e-323], [-1e308, 1e308, f64::INFINITY]] {
            let mut steps = Steps::default();
            fed(&mut steps, (0..40).flat_map(|_| times));
            fed(&mut steps, times.into_iter());
        }
    }
}
