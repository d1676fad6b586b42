//! Bad data: what each kind of it does, as pure state machines.
//!
//! | what | behaviour |
//! | --- | --- |
//! | no time, or the same time again | ignored; the estimate repeats the last one |
//! | late: time goes back by up to `late_s` | ignored; after `late_samples` in a row the clock was set |
//! | clock set: time goes back further | motion measured anew, pads and radii kept |
//! | gap up to `max_gap_s` | predicted in short steps under held inputs, then measured |
//! | longer gap | motion measured anew, pads kept and aged by the gap |
//! | value missing, NaN or impossible | not used; the other sensors carry on |
//! | spike | refused by the gate; believed once it lasts `wheel_recover_s` or `speed_recover_s` |
//! | stuck value | refused from `stuck_after_s` on, while the estimate has moved away, until it changes |
//! | missing pressing force | held for `hold_s`; then adhesion moves freely and nothing is said about the pads |
//! | missing drive torque, grade, sand | held for `hold_s`; then 0, with the grade's sigma for unknown grade |

use crate::{HygieneSettings, WagonSample};
use railgrip_vehicle::MAX_WHEELSETS;
use serde::{Deserialize, Serialize};

/// What the time of a sample means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TimeStep {
    /// The first sample.
    First,
    /// A step of this length, s.
    Regular(f64),
    /// Samples are missing, but few enough to predict over, s.
    Gap(f64),
    /// So many samples are missing that motion must be measured anew, s.
    LongGap(f64),
    /// The clock was set.
    ClockSet,
    /// Not a new instant.
    Ignored,
}

/// Time base of the samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TimeBase {
    /// Time of the last sample used, s.
    pub last_s: Option<f64>,
    late: u32,
}

impl TimeBase {
    /// Judges the time of a sample; `usual_s` is the declared time between samples.
    pub fn judge(&mut self, time_s: f64, usual_s: f64, settings: &HygieneSettings) -> TimeStep {
        if !time_s.is_finite() {
            return TimeStep::Ignored;
        }
        let Some(last_s) = self.last_s else {
            self.last_s = Some(time_s);
            return TimeStep::First;
        };
        let dt_s = time_s - last_s;
        // Less than a microsecond is the same instant: a step must be long enough to divide by.
        if dt_s.abs() < 1e-6 {
            return TimeStep::Ignored;
        }
        if dt_s < 0.0 && -dt_s <= settings.late_s && self.late + 1 < settings.late_samples {
            self.late += 1;
            return TimeStep::Ignored;
        }
        self.late = 0;
        self.last_s = Some(time_s);
        match dt_s {
            dt if dt < 0.0 => TimeStep::ClockSet,
            dt if dt > settings.max_gap_s => TimeStep::LongGap(dt),
            dt if dt > 2.5 * usual_s => TimeStep::Gap(dt),
            dt => TimeStep::Regular(dt),
        }
    }
}

/// An input that is held while it is missing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct HeldInput {
    /// Last good value; 0 before the first.
    pub value: f64,
    /// Since when it is missing, s; infinite before the first value.
    missing_s: Option<f64>,
    seen: bool,
}

impl HeldInput {
    /// Takes the value of a sample, NaN if missing; says whether the value is known: measured, or held for less than
    /// `hold_s`.
    pub fn take(
        &mut self,
        value: f64,
        allowed: std::ops::RangeInclusive<f64>,
        dt_s: f64,
        hold_s: f64,
    ) -> bool {
        if allowed.contains(&value) {
            *self = Self { value, missing_s: None, seen: true };
            return true;
        }
        let missing_s = self.missing_s.unwrap_or(0.0) + dt_s;
        self.missing_s = Some(missing_s);
        self.seen && missing_s <= hold_s
    }

    /// True while the value is not a fresh one.
    pub fn is_held(&self) -> bool {
        self.missing_s.is_some()
    }
}

/// What to do with a measured value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Use it.
    Use,
    /// Refuse it.
    Refuse,
    /// It was refused for so long that the filter must be wrong.
    Believe,
}

/// Watch over one sensor: spikes, and values that stick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SensorWatch {
    last: Option<f64>,
    repeats_s: f64,
    expected_then: f64,
    moved: f64,
    stuck: bool,
    refused_s: f64,
}

impl SensorWatch {
    /// Notes the raw value of a sample, and what a wagon that rolls at the estimated speed would show. Call before
    /// [`Self::judge`]. Zero is no stuck value: a locked wheelset shows it.
    pub fn note(&mut self, value: f64, rolling: f64, dt_s: f64) {
        if self.last == Some(value) && value != 0.0 {
            self.repeats_s += dt_s;
            self.moved = (rolling - self.expected_then).abs();
        } else {
            (self.repeats_s, self.moved, self.stuck) = (0.0, 0.0, false);
            self.expected_then = rolling;
        }
        self.last = Some(value);
    }

    /// Judges a value from its innovation, the innovation's `sigma`, and innovation over gate squared (`test_ratio`).
    pub fn judge(
        &mut self,
        innovation: f64,
        sigma: f64,
        test_ratio: f64,
        dt_s: f64,
        recover_s: f64,
        settings: &HygieneSettings,
    ) -> Verdict {
        if self.repeats_s >= settings.stuck_after_s && innovation.abs().max(self.moved) > 3.0 * sigma {
            self.stuck = true;
        }
        if self.stuck {
            return Verdict::Refuse;
        }
        if test_ratio <= 1.0 {
            self.refused_s = 0.0;
            return Verdict::Use;
        }
        self.refused_s += dt_s;
        if self.refused_s < recover_s {
            return Verdict::Refuse;
        }
        self.refused_s = 0.0;
        Verdict::Believe
    }
}

/// Speeds beyond this are nonsense, m/s.
const FASTEST_M_S: f64 = 200.0;
/// Wheelset speeds beyond this are nonsense, rad/s.
const FASTEST_RAD_S: f64 = 2000.0;

/// The input with every impossible measurement replaced by NaN.
pub fn without_nonsense(input: &WagonSample) -> WagonSample {
    let keep = |value: f64, limit: f64| if value.abs() <= limit { value } else { f64::NAN };
    WagonSample {
        v_m_s: keep(input.v_m_s, FASTEST_M_S),
        wheel_speed_rad_s: std::array::from_fn::<_, MAX_WHEELSETS, _>(|i| {
            keep(input.wheel_speed_rad_s[i], FASTEST_RAD_S)
        }),
        ..*input
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> HygieneSettings {
        HygieneSettings::default()
    }

    #[test]
    fn time_is_judged_as_documented() {
        let mut base = TimeBase::default();
        let mut judge = |time_s: f64| base.judge(time_s, 0.01, &settings());
        assert_eq!(judge(f64::NAN), TimeStep::Ignored);
        assert_eq!(judge(10.0), TimeStep::First);
        assert!(matches!(judge(10.01), TimeStep::Regular(_)));
        assert_eq!(judge(10.01), TimeStep::Ignored);
        assert_eq!(judge(9.9), TimeStep::Ignored);
        assert!(matches!(judge(10.5), TimeStep::Gap(_)));
        assert!(matches!(judge(100.0), TimeStep::LongGap(_)));
        assert_eq!(judge(5.0), TimeStep::ClockSet);
        assert!(matches!(judge(5.01), TimeStep::Regular(_)));
    }

    #[test]
    fn many_late_samples_are_a_clock_that_was_set() {
        let mut base = TimeBase::default();
        base.judge(10.0, 0.01, &settings());
        let verdicts: Vec<_> =
            (0..10).map(|i| base.judge(9.5 + 0.01 * f64::from(i), 0.01, &settings())).collect();
        assert!(verdicts[..9].iter().all(|v| *v == TimeStep::Ignored), "{verdicts:?}");
        assert_eq!(verdicts[9], TimeStep::ClockSet);
    }

    #[test]
    fn inputs_are_held_for_a_while() {
        let mut input = HeldInput::default();
        assert!(!input.take(f64::NAN, 0.0..=1e6, 0.01, 0.5));
        assert!(input.take(5e4, 0.0..=1e6, 0.01, 0.5));
        assert!(input.take(f64::NAN, 0.0..=1e6, 0.4, 0.5));
        assert!(input.is_held());
        assert!(!input.take(-3e9, 0.0..=1e6, 0.4, 0.5));
        assert_eq!(input.value, 5e4);
    }

    #[test]
    fn spikes_pass_and_contradictions_win_in_the_end() {
        let mut watch = SensorWatch::default();
        let mut judge = |ratio: f64| watch.judge(9.0, 1.0, ratio, 0.01, 0.05, &settings());
        assert_eq!(judge(0.5), Verdict::Use);
        let verdicts: Vec<_> = (0..5).map(|_| judge(3.0)).collect();
        assert_eq!(verdicts[..4], [Verdict::Refuse; 4]);
        assert_eq!(verdicts[4], Verdict::Believe);
    }

    #[test]
    fn a_value_that_repeats_is_stuck_only_when_the_estimate_leaves_it() {
        let mut watch = SensorWatch::default();
        for _ in 0..30 {
            watch.note(20.0, 20.0, 0.01);
            assert_eq!(watch.judge(0.5, 1.0, 0.01, 0.01, 0.05, &settings()), Verdict::Use);
        }
        watch.note(20.0, 20.0, 0.01);
        assert_eq!(watch.judge(4.0, 1.0, 0.6, 0.01, 0.05, &settings()), Verdict::Refuse);
        watch.note(20.0, 20.0, 0.01);
        assert_eq!(watch.judge(0.1, 1.0, 0.0, 0.01, 0.05, &settings()), Verdict::Refuse);
        watch.note(19.2, 20.0, 0.01);
        assert_eq!(watch.judge(0.1, 1.0, 0.0, 0.01, 0.05, &settings()), Verdict::Use);
    }
}
