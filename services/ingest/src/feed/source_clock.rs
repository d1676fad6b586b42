//! The clock of a source against ours. A source stamps its samples by a clock of its own, and they arrive after delays that vary;
//! the least delay of the latest seconds ties the one clock to the other, as the delay itself cannot be known.

/// The least delay is sought over two stretches of so long, ns.
const STRETCH_NS: u64 = 10_000_000_000;
/// A time that goes back by more than this begins a new time base; less is a late sample, s.
const RESTART_S: f64 = 1.0;
/// Of somebody who sends, it does so only after nothing else has come for so long, ns: what a broken connection still delivers,
/// while another one goes on, is late and no new time base.
const QUIET_NS: u64 = 500_000_000;
/// A time that goes back by less begins one too, once this many samples have come in order behind it, at the pace of their times
/// over so long, s, and none on the old one: the clock was set, or its owner has started again.
const NEW_BASE_SAMPLES: u32 = 5;
const NEW_BASE_S: f64 = 0.1;
/// A time that jumps ahead of the clock by more is not taken before the next one, s: delays vary by less.
const AHEAD_S: f64 = 0.05;
/// At the pace of their times: what was held up somewhere and comes in one go takes far less time than its times say.
const PACE: std::ops::Range<f64> = 0.5..2.0;

/// What the time of a sample means.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reading {
    /// Taken at this instant of our monotonic clock, ns.
    At(u64),
    /// The same, as the first of a new time base.
    Begins(u64),
    /// Not after the sample before: late, sent twice, or of a connection that is over.
    Late,
}

/// The clock of one wagon's source.
#[derive(Debug, Clone, Default)]
pub struct SourceClock {
    last: Option<Last>,
    /// Ours minus theirs with the least delay, ns: in the stretch before, and in this one since its start.
    before_ns: Option<i128>,
    least_ns: Option<i128>,
    stretch_began_ns: u64,
    drift_ppm: Option<f64>,
    /// Late samples in order, nothing in between.
    astray: Option<Astray>,
    /// A recording that is played: a time that goes back begins a new time base at once.
    played: bool,
}

#[derive(Debug, Clone, Copy)]
struct Last {
    t_s: f64,
    stamp_ns: u64,
    arrived_ns: u64,
}

/// A row of late samples that may be a new time base.
#[derive(Debug, Clone, Copy)]
struct Astray {
    count: u32,
    first_s: f64,
    first_arrived_ns: u64,
    last_s: f64,
}

impl Astray {
    /// With one more; begins anew with one that is not behind the sample before.
    fn and(row: Option<Self>, t_s: f64, arrived_ns: u64) -> Self {
        match row.filter(|row| t_s > row.last_s) {
            Some(row) => Self { count: row.count + 1, last_s: t_s, ..row },
            None => Self { count: 1, first_s: t_s, first_arrived_ns: arrived_ns, last_s: t_s },
        }
    }

    fn is_new_base(&self, arrived_ns: u64) -> bool {
        let arrived_s = arrived_ns.saturating_sub(self.first_arrived_ns) as f64 * 1e-9;
        let lasted_s = self.last_s - self.first_s;
        self.count >= NEW_BASE_SAMPLES && lasted_s >= NEW_BASE_S && PACE.contains(&(arrived_s / lasted_s))
    }
}

impl SourceClock {
    /// Of somebody who sends live, or of a recording that is played.
    #[must_use]
    pub fn of_kind(live: bool) -> Self {
        Self { played: !live, ..Self::default() }
    }

    /// Figures that a successor needs.
    pub const WORDS: usize = 7;

    /// The figures for a successor on the same running computer; the largest number stands for what is not known.
    #[must_use]
    pub fn words(&self) -> [u64; Self::WORDS] {
        let offset =
            |ns: Option<i128>| ns.and_then(|ns| i64::try_from(ns).ok()).unwrap_or(i64::MAX).cast_unsigned();
        [
            self.last.map_or(f64::NAN, |last| last.t_s).to_bits(),
            self.last.map_or(u64::MAX, |last| last.stamp_ns),
            offset(self.before_ns),
            offset(self.least_ns),
            self.stretch_began_ns,
            self.drift_ppm.unwrap_or(f64::NAN).to_bits(),
            self.last.map_or(0, |last| last.arrived_ns),
        ]
    }

    /// From the figures of a predecessor; as if nothing had come where they make no sense.
    #[must_use]
    pub fn of(words: &[u64]) -> Self {
        let &[t_s, stamp_ns, before_ns, least_ns, stretch_began_ns, drift_ppm, arrived_ns] = words else {
            return Self::default();
        };
        let offset = |word: u64| Some(word.cast_signed()).filter(|ns| *ns != i64::MAX).map(i128::from);
        let t_s = f64::from_bits(t_s);
        if !t_s.is_finite() || stamp_ns == u64::MAX || offset(least_ns).is_none() {
            return Self::default();
        }
        Self {
            last: Some(Last { t_s, stamp_ns, arrived_ns }),
            before_ns: offset(before_ns),
            least_ns: offset(least_ns),
            stretch_began_ns,
            drift_ppm: Some(f64::from_bits(drift_ppm)).filter(|ppm| ppm.is_finite()),
            astray: None,
            played: false,
        }
    }

    /// Whether a time runs ahead of the clock of its source by more than delays can vary, having jumped there, s and ns as below. One
    /// sample alone does not say whether it is wrong or the clock was set.
    #[must_use]
    pub fn is_ahead(&self, t_s: f64, arrived_ns: u64) -> bool {
        let Some((last, least_ns)) = self.last.zip(self.least_ns).filter(|_| !self.played) else {
            return false;
        };
        let least_ns = self.before_ns.map_or(least_ns, |before_ns| least_ns.min(before_ns));
        let jump_s = t_s - last.t_s - arrived_ns.saturating_sub(last.arrived_ns) as f64 * 1e-9;
        jump_s > AHEAD_S
            && least_ns - (i128::from(arrived_ns) - (t_s * 1e9) as i128) > (AHEAD_S * 1e9) as i128
    }

    /// Takes the next sample of a source: its time, s, and when it arrived here, ns of the monotonic clock.
    pub fn read(&mut self, t_s: f64, arrived_ns: u64) -> Reading {
        let astray = self.astray.take();
        let mut begins = false;
        if let Some(last) = self.last.filter(|last| t_s <= last.t_s) {
            let quiet = self.played || arrived_ns.saturating_sub(last.arrived_ns) >= QUIET_NS;
            let astray = Astray::and(astray, t_s, arrived_ns);
            begins = (quiet && t_s < last.t_s - RESTART_S) || astray.is_new_base(arrived_ns);
            if !begins {
                self.astray = Some(astray);
                return Reading::Late;
            }
            *self = Self::of_kind(!self.played);
        }
        let theirs_ns = (t_s * 1e9) as i128;
        let offset_ns = i128::from(arrived_ns) - theirs_ns;
        self.take(offset_ns, arrived_ns);
        let least_ns = self.before_ns.into_iter().chain(self.least_ns).min().unwrap_or(offset_ns);
        let stamp_ns = u64::try_from(theirs_ns + least_ns).unwrap_or(0);
        // A delay shorter than any before moves the tie; stamps go on all the same.
        let stamp_ns = self.last.map_or(stamp_ns, |last| stamp_ns.max(last.stamp_ns + 1));
        self.last = Some(Last { t_s, stamp_ns, arrived_ns });
        if begins { Reading::Begins(stamp_ns) } else { Reading::At(stamp_ns) }
    }

    fn take(&mut self, offset_ns: i128, arrived_ns: u64) {
        let Some(least_ns) = self.least_ns else {
            (self.least_ns, self.stretch_began_ns) = (Some(offset_ns), arrived_ns);
            return;
        };
        let lasted_ns = arrived_ns.saturating_sub(self.stretch_began_ns);
        if lasted_ns < STRETCH_NS {
            self.least_ns = Some(least_ns.min(offset_ns));
            return;
        }
        if let Some(before_ns) = self.before_ns {
            // Two least delays, about one stretch apart.
            self.drift_ppm = Some((least_ns - before_ns) as f64 / STRETCH_NS as f64 * 1e6);
        }
        (self.before_ns, self.least_ns) = (Some(least_ns), Some(offset_ns));
        self.stretch_began_ns = arrived_ns;
    }

    /// How much faster our clock runs than theirs, parts in a million, once two stretches are over; delays that change look
    /// like drift, so that only what lasts means something.
    pub fn drift_ppm(&self) -> Option<f64> {
        self.drift_ppm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const START_NS: u64 = 5_000_000_000;

    /// Delays between 1 and 4 ms that look random.
    fn delay_ns(k: u64) -> u64 {
        1_000_000 + (k.wrapping_mul(2_654_435_761) >> 7) % 3_000_000
    }

    #[test]
    fn stamps_have_the_steps_of_the_source_and_not_those_of_the_network() {
        let mut clock = SourceClock::default();
        let mut stamps = Vec::new();
        for k in 0..2000_u64 {
            let t_s = 100.0 + k as f64 * 0.005;
            match clock.read(t_s, START_NS + k * 5_000_000 + delay_ns(k)) {
                Reading::At(stamp_ns) => stamps.push(stamp_ns),
                other => panic!("{other:?}"),
            }
        }
        let settled = &stamps[200..];
        let odd = settled.windows(2).filter(|pair| (pair[1] - pair[0]).abs_diff(5_000_000) > 20_000).count();
        assert!(odd <= 2, "{odd} odd steps");
        // Behind the instant at which they were taken by the least delay.
        let taken_ns = START_NS + 1999 * 5_000_000;
        assert!((1_000_000..1_100_000).contains(&(stamps[1999] - taken_ns)));
    }

    #[test]
    fn of_a_packet_that_arrives_at_once_no_sample_is_late() {
        let mut clock = SourceClock::default();
        let mut last_ns = 0;
        for k in 0..500_u64 {
            let arrived_ns = START_NS + k / 10 * 100_000_000;
            let Reading::At(stamp_ns) = clock.read(k as f64 * 0.01, arrived_ns) else { panic!("late: {k}") };
            assert!(stamp_ns > last_ns && stamp_ns < arrived_ns + 1000);
            last_ns = stamp_ns;
        }
    }

    #[test]
    fn repeats_and_late_samples_are_told_and_a_restart_begins_anew() {
        let mut clock = SourceClock::default();
        assert!(matches!(clock.read(50.0, START_NS), Reading::At(_)));
        assert!(matches!(clock.read(50.01, START_NS + 10_000_000), Reading::At(_)));
        assert_eq!(clock.read(50.01, START_NS + 11_000_000), Reading::Late);
        assert_eq!(clock.read(49.5, START_NS + 12_000_000), Reading::Late);
        let begins = clock.read(0.0, START_NS + 620_000_000);
        assert_eq!(begins, Reading::Begins(START_NS + 620_000_000));
        let mut played = SourceClock::of_kind(false);
        assert!(matches!(played.read(50.0, START_NS), Reading::At(_)));
        assert_eq!(played.read(0.0, START_NS + 1), Reading::Begins(START_NS + 1));
    }

    #[test]
    fn what_a_broken_connection_still_delivers_is_late_and_no_new_time_base() {
        let mut clock = SourceClock::default();
        for k in 0..400_u64 {
            let arrived_ns = START_NS + k * 10_000_000;
            // From the second second on a new connection goes on, and the old one delivers what it held, four seconds old.
            assert!(matches!(clock.read(100.0 + k as f64 * 0.01, arrived_ns), Reading::At(_)), "{k}");
            if k > 200 {
                assert_eq!(clock.read(96.0 + k as f64 * 0.01, arrived_ns + 1_000_000), Reading::Late, "{k}");
            }
        }
    }

    #[test]
    fn a_clock_that_is_set_back_a_little_is_followed_soon_and_loses_no_more_than_it_must() {
        for (period_s, back_s, packet) in [(0.01, 0.4, 1), (0.001, 0.3, 1), (0.01, 0.45, 10), (0.02, 0.2, 1)]
        {
            let mut clock = SourceClock::default();
            let (mut late, mut begun) = (0, 0);
            let step_ns = (period_s * 1e9) as u64;
            for k in 0..4000_u64 {
                // From the middle on its clock says less; the last of a packet comes when it is taken, the others wait for it.
                let t_s = 7.003 + k as f64 * period_s - if k < 2000 { 0.0 } else { back_s };
                let taken_ns = START_NS + k * step_ns;
                let sent_ns = START_NS + (k / packet * packet + packet - 1) * step_ns;
                let arrived_ns = sent_ns + delay_ns(k / packet);
                match clock.read(t_s, arrived_ns) {
                    Reading::Late => late += 1,
                    Reading::At(stamp_ns) if k >= 2000 + 1000 => {
                        let error_ns = stamp_ns.abs_diff(taken_ns);
                        assert!(error_ns < 5_000_000, "{k}: {error_ns} ns wrong ({period_s}, {back_s})");
                    }
                    Reading::At(_) => {}
                    Reading::Begins(_) => begun += 1,
                }
            }
            println!("{period_s} s, back by {back_s} s, {packet} a packet: {late} late");
            assert_eq!(begun, 1, "{period_s}, {back_s}");
            let must = (NEW_BASE_S / period_s) as u64 + u64::from(NEW_BASE_SAMPLES) + 2 * packet;
            assert!(late <= must, "{late} late ({period_s}, {back_s})");
        }
    }

    #[test]
    fn stragglers_are_never_a_new_time_base_in_whatever_row_they_come() {
        // What was held up comes in one go, while nothing else comes.
        let mut clock = SourceClock::default();
        let on_time = |clock: &mut SourceClock, k: u64| {
            clock.read(k as f64 * 0.001, START_NS + k * 1_000_000 + delay_ns(k) / 10)
        };
        for k in (0..1000).filter(|k| !(500..900).contains(k)) {
            assert!(matches!(on_time(&mut clock, k), Reading::At(_)), "{k}");
        }
        for k in 500..900 {
            let arrived_ns = START_NS + 1_000_000_000 + k * 20_000;
            assert_eq!(clock.read(k as f64 * 0.001, arrived_ns), Reading::Late, "{k}");
        }
        // A second way that is slower says everything again at its own pace, and the first goes on, ten samples at a time.
        let (mut taken, mut late) = (0, 0);
        for packet in 110..400_u64 {
            for k in packet * 10..packet * 10 + 10 {
                match on_time(&mut clock, k) {
                    Reading::At(_) => taken += 1,
                    other => panic!("{k}: {other:?}"),
                }
            }
            for k in packet * 10 - 100..packet * 10 - 90 {
                let arrived_ns = START_NS + (k + 100) * 1_000_000 + 9_500_000;
                late += usize::from(clock.read(k as f64 * 0.001, arrived_ns) == Reading::Late);
            }
        }
        assert_eq!((taken, late), (2900, 2900));
    }

    #[test]
    fn for_a_successor_nothing_that_waited_looks_new() {
        let mut clock = SourceClock::default();
        for k in 0..1000_u64 {
            clock.read(k as f64 * 0.01, START_NS + k * 10_000_000 + delay_ns(k));
        }
        // Away for half a second, while samples waited.
        let mut successor = SourceClock::of(&clock.words());
        assert_eq!(successor.words(), clock.words());
        let back_ns = START_NS + 1050 * 10_000_000;
        for k in 1000..1050_u64 {
            let Reading::At(stamp_ns) = successor.read(k as f64 * 0.01, back_ns) else { panic!("late: {k}") };
            assert!(stamp_ns.abs_diff(START_NS + k * 10_000_000) < 2_000_000, "{k}: {stamp_ns}");
        }
        for words in [&[][..], &[u64::MAX; SourceClock::WORDS][..], &SourceClock::default().words()[..]] {
            assert_eq!(SourceClock::of(words).read(1.0, 77), Reading::At(77));
        }
    }

    #[test]
    fn a_clock_that_runs_slow_is_followed_and_its_drift_is_known() {
        let mut clock = SourceClock::default();
        for k in 0..12_000_u64 {
            // Theirs loses 100 µs a second.
            let t_s = k as f64 * 0.01 * (1.0 - 100e-6);
            let arrived_ns = START_NS + k * 10_000_000 + delay_ns(k);
            let Reading::At(stamp_ns) = clock.read(t_s, arrived_ns) else { panic!("{k}") };
            let behind_ns = arrived_ns.saturating_sub(stamp_ns);
            assert!(behind_ns < 8_000_000, "{k}: {behind_ns} ns behind its arrival");
        }
        let drift_ppm = clock.drift_ppm().expect("two stretches are over");
        assert!((drift_ppm - 100.0).abs() < 5.0, "{drift_ppm}");
    }
}
