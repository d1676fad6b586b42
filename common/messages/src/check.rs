//! What a payload must fulfil before anybody uses it.
//!
//! Any process of the train can write into a channel, and a fault in one must not become a fault in its readers. Whoever
//! reads a channel therefore checks each payload once, on receipt, and hands on only what is [`Validated`]. What is refused
//! is counted under the word of its [`Refusal`].
//!
//! A plain figure may be NaN: that is how "unknown" travels. A judged figure that says it is known must be finite, and no
//! figure may be infinite. When the latest brake application began is not checked, because an estimator that goes on from
//! a snapshot may know it from an earlier boot. Text needs no check: [`crate::Text::as_str`] ends at the first byte that is no UTF-8.

use crate::{
    AudioHeader, BogieSample, Condition, Estimate, EstimateState, Event, EventKind, Grade, Health, Heard,
    HearingState, Heartbeat, Indicator, MAX_WHEELSETS, MotorSample, Payload, ProcessKind, Sample,
    SourceState, Stamp, Verdicts, WheelsetHealth,
};

/// A stamp may be so far ahead of the reader's monotonic clock, ns: all processes of a train share that clock.
const AHEAD_MONOTONIC_NS: u64 = 100_000_000;
/// And so far ahead of its wall clock, ns, which may be set while a payload is on its way.
const AHEAD_UNIX_NS: i64 = 60_000_000_000;
/// No clock of a source counts farther, s either way; beyond that steps are lost in the digits.
const LONGEST_S: f64 = 1e12;
/// No microphone samples slower or faster, Hz.
const RATES_HZ: std::ops::RangeInclusive<u32> = 1000..=384_000;
/// No train is faster, m/s.
const FASTEST_M_S: f64 = 200.0;
/// No track position is farther from zero, m.
const FARTHEST_M: f64 = 1e9;

/// Why a payload is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Refusal {
    /// It says that it was taken later than now.
    FutureStamp,
    /// It does not say when it was taken.
    NoStamp,
    /// A figure is infinite, or not a number where one must be.
    NotFinite,
    /// A figure is finite and impossible.
    OutOfRange,
    /// The lower end of an interval lies above its upper end.
    ReversedInterval,
    /// A code or flag that has no meaning.
    UnknownCode,
    /// More wheelsets than there are places.
    WrongCount,
    /// Nothing has been measured for long: what follows would be invented.
    NothingMeasured,
    /// The columns of another program cannot be in their units.
    UnitsImplausible,
    /// It is about a wagon that the train or the channel does not have.
    WrongWagon,
}

impl Refusal {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::FutureStamp,
        Self::NoStamp,
        Self::NotFinite,
        Self::OutOfRange,
        Self::ReversedInterval,
        Self::UnknownCode,
        Self::WrongCount,
        Self::NothingMeasured,
        Self::UnitsImplausible,
        Self::WrongWagon,
    ];

    /// The word for metrics, JSON and logs.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::FutureStamp => "future_stamp",
            Self::NoStamp => "no_stamp",
            Self::NotFinite => "not_finite",
            Self::OutOfRange => "out_of_range",
            Self::ReversedInterval => "reversed_interval",
            Self::UnknownCode => "unknown_code",
            Self::WrongCount => "wrong_count",
            Self::NothingMeasured => "nothing_measured",
            Self::UnitsImplausible => "units_implausible",
            Self::WrongWagon => "wrong_wagon",
        }
    }
}

/// A payload that has passed its check.
#[derive(Debug, Clone, Copy)]
pub struct Validated<'a, T>(&'a T);

impl<T> std::ops::Deref for Validated<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        self.0
    }
}

/// A payload that can be checked.
pub trait Checked: Payload {
    /// What its readers call it in metrics and logs.
    const NAME: &'static str;

    /// The wagon that it is about; [`crate::NO_WAGON`] if only its channel says so.
    fn wagon(&self) -> u32;

    /// Checks everything that a reader relies on; `now` is the reader's time.
    ///
    /// # Errors
    /// The first thing that is wrong.
    fn check(&self, now: Stamp) -> Result<(), Refusal>;

    /// The same payload, as one that has passed.
    ///
    /// # Errors
    /// As [`Self::check`].
    fn validated(&self, now: Stamp) -> Result<Validated<'_, Self>, Refusal> {
        self.check(now).map(|()| Validated(self))
    }
}

impl Checked for Health {
    const NAME: &'static str = "health";

    fn wagon(&self) -> u32 {
        self.wagon
    }

    fn check(&self, now: Stamp) -> Result<(), Refusal> {
        taken(self.acquired, now)?;
        not_ahead(self.published_monotonic_ns, now)?;
        count(self.wheelsets)?;
        code(Grade::from_code(self.grade))?;
        condition(self.condition)?;
        flag(self.adhesion_available_is_bound)?;
        self.condition_probability.iter().try_for_each(|share| within(*share, 0.0, 1.0 + 1e-6))?;
        unless_unknown(self.v_m_s, FASTEST_M_S)?;
        unless_unknown(self.position_m, FARTHEST_M)?;
        within(self.braking_s, 0.0, f64::MAX)?;
        let plain = [
            self.time_s,
            self.mu_w,
            self.mu_w_sigma,
            self.mu_b_mean,
            self.mu_b_mean_sigma,
            self.pressing_force_n,
            self.sanding_now,
        ];
        plain.into_iter().try_for_each(not_infinite)?;
        self.indicator.iter().try_for_each(indicator)?;
        self.wheelset[..self.wheelset_count()].iter().try_for_each(wheelset)
    }
}

fn wheelset(health: &WheelsetHealth) -> Result<(), Refusal> {
    health.indicator.iter().try_for_each(indicator)?;
    [health.adhesion_available_is_bound, health.observable, health.sliding, health.wsp_active]
        .into_iter()
        .try_for_each(flag)?;
    [health.slide_energy_j, health.slide_s].into_iter().try_for_each(|total| within(total, 0.0, f64::MAX))?;
    let plain = [
        health.brake_friction_ratio,
        health.mu_b,
        health.mu_b_sigma,
        health.mu_w,
        health.mu_w_sigma,
        health.slip,
        health.pressing_force_n,
    ];
    plain.into_iter().try_for_each(not_infinite)
}

impl Checked for Heard {
    const NAME: &'static str = "heard";

    fn wagon(&self) -> u32 {
        self.wagon
    }

    fn check(&self, now: Stamp) -> Result<(), Refusal> {
        taken(self.acquired, now)?;
        not_ahead(self.published_monotonic_ns, now)?;
        code(HearingState::from_code(self.state))?;
        condition(self.condition)?;
        [self.known, self.decided, self.kept].into_iter().try_for_each(flag)?;
        not_infinite(self.level_db)?;
        if self.known != 0 {
            within(self.wet_probability, 0.0, 1.0)?;
        }
        if self.decided != 0 {
            condition(self.decided_condition)?;
            let decided = [self.decided_adhesion, self.optimum_slip, self.optimum_adhesion];
            decided.into_iter().try_for_each(not_infinite)?;
        }
        Ok(())
    }
}

impl Checked for Heartbeat {
    const NAME: &'static str = "heartbeat";

    fn wagon(&self) -> u32 {
        self.wagon
    }

    fn check(&self, now: Stamp) -> Result<(), Refusal> {
        taken(self.stamp, now)?;
        code(ProcessKind::from_code(self.process))?;
        within(self.uptime_s, 0.0, f64::MAX)
    }
}

impl Checked for SourceState {
    const NAME: &'static str = "source state";

    fn wagon(&self) -> u32 {
        self.wagon
    }

    fn check(&self, now: Stamp) -> Result<(), Refusal> {
        taken(self.stamp, now)?;
        flag(self.drift_known)?;
        if self.drift_known == 0 { Ok(()) } else { finite(self.drift_ppm) }
    }
}

impl Checked for Event {
    const NAME: &'static str = "event";

    fn wagon(&self) -> u32 {
        self.wagon
    }

    fn check(&self, now: Stamp) -> Result<(), Refusal> {
        taken(self.stamp, now)?;
        code(EventKind::from_code(self.kind))?;
        code(Grade::from_code(self.grade))?;
        self.values.iter().try_for_each(|value| finite(*value))
    }
}

/// What a cause's code means is known to the crate of the causes alone.
impl Checked for Verdicts {
    const NAME: &'static str = "verdicts";

    fn wagon(&self) -> u32 {
        crate::NO_WAGON
    }

    fn check(&self, now: Stamp) -> Result<(), Refusal> {
        taken(self.stamp, now)?;
        not_infinite(self.time_s)?;
        if self.count as usize > self.verdict.len() {
            return Err(Refusal::WrongCount);
        }
        self.standing().iter().try_for_each(|verdict| {
            code(Grade::from_code(verdict.grade))?;
            within(verdict.probability, 0.0, 1.0)?;
            finite(verdict.found_t_s)?;
            verdict.instead_probability.iter().try_for_each(|share| within(*share, 0.0, 1.0))?;
            if verdict.wagons().all(|wagon| wagon <= self.wagons) { Ok(()) } else { Err(Refusal::WrongWagon) }
        })
    }
}

/// The values of a sample are the filter's to judge; its stamp and its form are checked here.
impl Checked for Sample {
    const NAME: &'static str = "sample";

    fn wagon(&self) -> u32 {
        crate::NO_WAGON
    }

    fn check(&self, now: Stamp) -> Result<(), Refusal> {
        taken(self.acquired, now)?;
        count(self.wheelsets)?;
        within(self.time_s, -LONGEST_S, LONGEST_S)
    }
}

impl Checked for MotorSample {
    const NAME: &'static str = "motor sample";

    fn wagon(&self) -> u32 {
        crate::NO_WAGON
    }

    fn check(&self, now: Stamp) -> Result<(), Refusal> {
        taken(self.acquired, now)?;
        within(self.time_s, -LONGEST_S, LONGEST_S)
    }
}

impl Checked for BogieSample {
    const NAME: &'static str = "bogie sample";

    fn wagon(&self) -> u32 {
        crate::NO_WAGON
    }

    fn check(&self, now: Stamp) -> Result<(), Refusal> {
        taken(self.acquired, now)?;
        within(self.time_s, -LONGEST_S, LONGEST_S)
    }
}

impl Checked for Estimate {
    const NAME: &'static str = "estimate";

    fn wagon(&self) -> u32 {
        crate::NO_WAGON
    }

    fn check(&self, now: Stamp) -> Result<(), Refusal> {
        taken(self.acquired, now)?;
        not_ahead(self.published_monotonic_ns, now)?;
        count(self.wheelsets)?;
        code(EstimateState::from_code(self.state))?;
        within(self.time_s, -LONGEST_S, LONGEST_S)?;
        unless_unknown(self.v_m_s, FASTEST_M_S)
    }
}

/// The header of a block is no payload of its own, and comes with the channel of a wagon.
impl AudioHeader {
    /// Checks what a listener relies on; `wagon` is that of the channel, `now` the reader's time. The samples are the ear's to judge.
    ///
    /// # Errors
    /// The first thing that is wrong.
    pub fn check(&self, wagon: u32, now: Stamp) -> Result<(), Refusal> {
        taken(self.acquired, now)?;
        if !RATES_HZ.contains(&self.sample_rate_hz) {
            return Err(Refusal::OutOfRange);
        }
        if self.wagon == wagon { Ok(()) } else { Err(Refusal::WrongWagon) }
    }
}

/// It was taken at some time, and not later than now.
fn taken(stamp: Stamp, now: Stamp) -> Result<(), Refusal> {
    if stamp.monotonic_ns == 0 {
        return Err(Refusal::NoStamp);
    }
    if stamp.unix_ns > now.unix_ns.saturating_add(AHEAD_UNIX_NS) {
        return Err(Refusal::FutureStamp);
    }
    not_ahead(stamp.monotonic_ns, now)
}

fn not_ahead(monotonic_ns: u64, now: Stamp) -> Result<(), Refusal> {
    let ahead = monotonic_ns > now.monotonic_ns.saturating_add(AHEAD_MONOTONIC_NS);
    if ahead { Err(Refusal::FutureStamp) } else { Ok(()) }
}

fn indicator(indicator: &Indicator) -> Result<(), Refusal> {
    code(Grade::from_code(indicator.grade))?;
    flag(indicator.known)?;
    if indicator.known == 0 {
        return Ok(());
    }
    [indicator.value, indicator.low, indicator.high].into_iter().try_for_each(finite)?;
    if indicator.low > indicator.high { Err(Refusal::ReversedInterval) } else { Ok(()) }
}

fn finite(value: f64) -> Result<(), Refusal> {
    if value.is_finite() { Ok(()) } else { Err(Refusal::NotFinite) }
}

fn not_infinite(value: f64) -> Result<(), Refusal> {
    if value.is_infinite() { Err(Refusal::NotFinite) } else { Ok(()) }
}

fn within(value: f64, low: f64, high: f64) -> Result<(), Refusal> {
    finite(value)?;
    if (low..=high).contains(&value) { Ok(()) } else { Err(Refusal::OutOfRange) }
}

/// NaN, or a number of at most this magnitude.
fn unless_unknown(value: f64, most: f64) -> Result<(), Refusal> {
    if value.is_nan() { Ok(()) } else { within(value, -most, most) }
}

fn code<T>(meaning: Option<T>) -> Result<(), Refusal> {
    meaning.map(|_| ()).ok_or(Refusal::UnknownCode)
}

/// A condition, or `u32::MAX` for none.
fn condition(number: u32) -> Result<(), Refusal> {
    if number == u32::MAX { Ok(()) } else { code(Condition::from_code(number)) }
}

fn flag(number: u32) -> Result<(), Refusal> {
    if number <= 1 { Ok(()) } else { Err(Refusal::UnknownCode) }
}

fn count(wheelsets: u32) -> Result<(), Refusal> {
    if wheelsets as usize <= MAX_WHEELSETS { Ok(()) } else { Err(Refusal::WrongCount) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOW: Stamp = Stamp { unix_ns: 1_700_000_000_000_000_000, monotonic_ns: 50_000_000_000 };

    fn sound() -> Health {
        Health { acquired: NOW, published_monotonic_ns: NOW.monotonic_ns, wheelsets: 2, ..Health::default() }
    }

    fn refusal(change: impl FnOnce(&mut Health)) -> Option<Refusal> {
        let mut health = sound();
        change(&mut health);
        health.check(NOW).err()
    }

    #[test]
    fn a_sound_message_passes_and_unknown_figures_may_be_nan() {
        assert_eq!(refusal(|_| {}), None);
        assert_eq!(refusal(|health| health.v_m_s = f64::NAN), None);
        assert_eq!(
            refusal(|health| health.indicator[9].value = f64::NAN),
            None,
            "it does not say that it is known"
        );
        assert_eq!(refusal(|health| health.condition = u32::MAX), None);
        assert_eq!(refusal(|health| health.mu_w = 5e-324), None);
    }

    #[test]
    fn each_fault_has_its_word() {
        use Refusal::*;
        let known = |health: &mut Health, value, low, high| {
            let judged = &mut health.indicator[8];
            (judged.known, judged.value, judged.low, judged.high) = (1, value, low, high);
        };
        assert_eq!(refusal(|health| health.acquired.monotonic_ns = u64::MAX), Some(FutureStamp));
        assert_eq!(refusal(|health| health.acquired.unix_ns = i64::MAX), Some(FutureStamp));
        assert_eq!(refusal(|health| health.published_monotonic_ns = u64::MAX), Some(FutureStamp));
        assert_eq!(refusal(|health| health.acquired = Stamp::default()), Some(NoStamp));
        assert_eq!(refusal(|health| known(health, 0.1, f64::NAN, 0.2)), Some(NotFinite));
        assert_eq!(refusal(|health| known(health, 0.1, 0.2, 0.1)), Some(ReversedInterval));
        assert_eq!(refusal(|health| health.mu_w = f64::NEG_INFINITY), Some(NotFinite));
        assert_eq!(refusal(|health| health.condition_probability[2] = f64::NAN), Some(NotFinite));
        assert_eq!(refusal(|health| health.v_m_s = 1e9), Some(OutOfRange));
        assert_eq!(refusal(|health| health.grade = 9), Some(UnknownCode));
        assert_eq!(refusal(|health| health.condition = 9), Some(UnknownCode));
        assert_eq!(refusal(|health| health.wheelset[1].sliding = 7), Some(UnknownCode));
        assert_eq!(refusal(|health| health.wheelsets = 77), Some(WrongCount));
        let sample = Sample { acquired: NOW, time_s: f64::NAN, ..Sample::default() };
        assert_eq!(sample.check(NOW), Err(NotFinite));
    }
}
