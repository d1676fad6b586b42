//! When the pressing force of a wagon comes and goes: how late behind the order, and how slowly.
//!
//! Pressure is measured, so a slow cylinder and a late distributor are seen directly, against the wagon's own past and with what
//! the whole train shows at once (the way of the order along the pipe, its shape) removed. Both ends of an application tell:
//!
//! * the rise, by its beginning and by the area between order and force, where no electric brake takes part;
//! * the fall after a full release, by its beginning and by the time that it takes for a newton. A release goes to nothing at one
//!   go, within seconds, whatever the application was like, and at a platform it shows the cylinders of wagons that brake electrically, too.

use crate::robust::Past;

/// Time between two values of the traces, s.
pub(crate) const TRACE_S: f64 = 0.1;
/// Longest trace of an application.
const LONGEST: usize = 1200;
/// Kept before an application begins.
const BEFORE: usize = 20;
/// The order has stood still for so many values before a release that tells, and by so much.
const STEADY: (usize, f64) = (30, 0.06);
/// And has been lowered over at most so many values until it is released: handles and brake computers let go within seconds.
const LOWERED: usize = 30;
/// A release is an order that falls from at least this to at most that.
const RELEASED: (f64, f64) = (0.08, 0.02);
/// A fall that is not over after this time is none, s.
const LONGEST_FALL_S: f64 = 90.0;
/// The slope of a fall is taken between these shares of the force before.
const FALLS: (f64, f64) = (0.8, 0.35);

/// Beginning and duration of one rise or fall.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub(crate) struct Stroke {
    /// From the order, s.
    pub start_s: f64,
    /// Area of a rise, s; natural logarithm of the time that a fall takes, s/N.
    pub slow: f64,
}

/// A fall that runs.
#[derive(Debug, Clone, Copy, serde::Serialize, serde::Deserialize)]
struct Falling {
    from_n: f64,
    before_n: f64,
    after_s: f64,
    upper_s: Option<f64>,
    over_s: Option<f64>,
}

impl Falling {
    /// Takes the force of the next value of the trace, N.
    fn take(&mut self, force_n: f64) {
        let crossed = |share: f64| {
            let level_n = share * self.from_n;
            (force_n < level_n).then(|| {
                let part = (self.before_n - level_n) / (self.before_n - force_n).max(1e-9);
                self.after_s + TRACE_S * part.clamp(0.0, 1.0)
            })
        };
        self.upper_s = self.upper_s.or_else(|| crossed(FALLS.0));
        self.over_s = self.over_s.or_else(|| crossed(FALLS.1));
        self.after_s += TRACE_S;
        self.before_n = force_n;
    }

    /// Its beginning and duration, once it is over.
    fn stroke(&self) -> Option<Stroke> {
        let (upper_s, over_s) = (self.upper_s?, self.over_s?);
        let per_share_s = (over_s - upper_s) / (FALLS.0 - FALLS.1);
        let s_per_n = per_share_s.max(0.02) / self.from_n;
        // Where the slope meets the force before: a slow fall begins no later.
        Some(Stroke { start_s: upper_s - (1.0 - FALLS.0) * per_share_s, slow: s_per_n.ln() })
    }
}

/// Least and most of the latest values of a trace.
fn range(values: &[(f64, f64)], of: fn(&(f64, f64)) -> f64) -> (f64, f64) {
    values.iter().map(of).fold((f64::MAX, 0.0_f64), |(low, high), one| (low.min(one), high.max(one)))
}

/// Which end of an application.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum End {
    /// The rise of the pressing force.
    Rise,
    /// The rise of pads and electric brake together.
    Blended,
    /// The fall of the pressing force.
    Fall,
}

/// What rises and falls of one wagon were like so far.
#[derive(Debug, Clone, Copy, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct Usual {
    start: Past,
    slow: Past,
}

impl Usual {
    /// What is usual and its scatter, of beginning and duration; `None` while there is no past.
    pub(crate) fn told(&self) -> Option<(Stroke, Stroke)> {
        let of = |start_s, slow| Stroke { start_s, slow };
        (self.start.count() >= 2.0)
            .then(|| (of(self.start.mean(), self.slow.mean()), of(self.start.sigma(), self.slow.sigma())))
    }

    /// It becomes part of the past.
    pub(crate) fn remember(&mut self, stroke: Stroke) {
        self.start.take(stroke.start_s);
        self.slow.take(stroke.slow);
    }
}

/// A value of the trace of an application.
#[derive(Debug, Clone, Copy, serde::Serialize, serde::Deserialize)]
struct Traced {
    order: f64,
    /// Force of the middle wheelset, N.
    force_n: f64,
    /// The same with what the electric brake does instead of the pads, N.
    together_n: f64,
}

/// What is ordered, a share of full braking, and the pressing force at that moment.
type Told = (f64, f64);

/// Traces of one wagon.
#[derive(Debug, Clone, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct Timing {
    trace: Vec<Traced>,
    recent: Vec<Told>,
    falling: Option<Falling>,
    /// The latest fall, until it is judged.
    fallen: Option<Stroke>,
    rises: Usual,
    falls: Usual,
    blended: Usual,
    /// Evidence for a late distributor and for a slow cylinder: natural logarithm of what the looks so far make of the odds.
    pub late: f64,
    pub slow: f64,
    /// The same for a late distributor by what pads and electric brake do together: where the electric brake hears the order by another
    /// way, that says nothing against what the pads do.
    pub late_together: f64,
}

impl Timing {
    /// All evidence for a late distributor, and for a slow cylinder.
    pub(crate) const fn evidence(&self) -> (f64, f64) {
        (self.late + self.late_together, self.slow)
    }

    /// Takes a value of the traces: the order, and the force of the middle wheelset with what the electric brake does instead of
    /// it; `full_n` is the largest ever, `electric` whether an electric brake takes part now.
    pub(crate) fn trace(
        &mut self,
        order: f64,
        (force_n, electric_n): (f64, f64),
        braking: bool,
        (full_n, electric): (f64, bool),
    ) {
        if !braking && self.trace.len() >= BEFORE {
            self.trace.remove(0);
        }
        if self.trace.len() < LONGEST {
            self.trace.push(Traced { order, force_n, together_n: force_n + electric_n });
        }
        self.follow_fall(order, force_n, full_n, electric);
        if self.recent.len() == STEADY.0 + LOWERED {
            self.recent.remove(0);
        }
        self.recent.push((order, force_n));
    }

    fn follow_fall(&mut self, order: f64, force_n: f64, full_n: f64, electric: bool) {
        if order <= RELEASED.1
            && self.recent.last().is_some_and(|before| before.0 > RELEASED.1)
            && let Some((stood, lowered)) = self.stood_before()
        {
            // A cylinder that is still filling goes on doing so before it hears of the release.
            let (least_n, most_n) = range(stood, |one| one.1);
            let steady = most_n - least_n < STEADY.1 * most_n + 600.0;
            let mut forces_n = lowered.iter().map(|one| one.1).chain([force_n]);
            let from_n = forces_n.next().unwrap_or(force_n);
            let tells = steady && from_n > 0.12 * full_n && from_n > 1000.0 && !electric;
            let mut fall = Falling { from_n, before_n: from_n, after_s: 0.0, upper_s: None, over_s: None };
            forces_n.for_each(|force_n| fall.take(force_n));
            self.falling = tells.then_some(fall);
        } else if let Some(fall) = &mut self.falling {
            fall.take(force_n);
        }
        let Some(fall) = &self.falling else { return };
        if let Some(fallen) = fall.stroke() {
            self.fallen = Some(fallen);
        }
        if fall.over_s.is_some() || order > RELEASED.0 || fall.after_s > LONGEST_FALL_S {
            self.falling = None;
        }
    }

    /// Orders and forces while the order last stood still, and since it has been lowered; `None` if it did not stand, or was not
    /// lowered at one go. Of orders that nobody tells there are none.
    fn stood_before(&self) -> Option<(&[Told], &[Told])> {
        let longest = LOWERED.min(self.recent.len().checked_sub(STEADY.0)?);
        (0..=longest).find_map(|count| {
            let (before, lowered) = self.recent.split_at(self.recent.len() - count);
            let stood = &before[before.len() - STEADY.0..];
            let (low, high) = range(stood, |one| one.0);
            let stands = low > RELEASED.0 && high >= low && high - low < STEADY.1;
            let falls = lowered.is_sorted_by(|a, b| a.0 >= b.0) && lowered.iter().all(|one| one.0 <= high);
            (stands && falls).then_some((stood, lowered))
        })
    }

    /// What strokes of that kind were like so far.
    pub(crate) const fn usual(&mut self, end: End) -> &mut Usual {
        match end {
            End::Rise => &mut self.rises,
            End::Blended => &mut self.blended,
            End::Fall => &mut self.falls,
        }
    }

    /// The latest fall, once.
    pub(crate) fn fallen(&mut self) -> Option<Stroke> {
        self.fallen.take()
    }

    /// The rise of the latest application; `None` if it does not tell it. `orders` stand in where none is told.
    pub(crate) fn rise(&self, orders: Option<&[f64]>, full_n: f64) -> Option<Stroke> {
        self.rise_of(orders, full_n, |at| at.force_n)
    }

    /// The same of pads and electric brake together: both hear of the order by the distributor.
    pub(crate) fn blended_rise(&self, full_n: f64) -> Option<Stroke> {
        self.rise_of(None, full_n, |at| at.together_n)
    }

    fn rise_of(&self, orders: Option<&[f64]>, full_n: f64, force: fn(&Traced) -> f64) -> Option<Stroke> {
        let order = |index: usize| orders.map_or(self.trace[index].order, |orders| orders[index]);
        let force_n = |index: usize| force(&self.trace[index]);
        // Orders that stand in may be of fewer values than this wagon's own.
        let count = orders.map_or(usize::MAX, <[f64]>::len).min(self.trace.len());
        let most = (0..count).map(order).fold(f64::NAN, f64::max);
        let peak_n = self.trace.iter().map(force).fold(f64::NAN, f64::max);
        if !(most > 0.1 && peak_n > 0.15 * full_n && peak_n > 1000.0) {
            return None;
        }
        let ordered = (0..count).find(|index| order(*index) > 0.04)?;
        let rises = (0..count).find(|index| force_n(*index) > 0.04 * full_n + 150.0)?;
        let level = (0..count).find(|index| force_n(*index) > 0.95 * peak_n)?;
        let area = (ordered..level.max(ordered))
            .map(|index| (order(index) / most - force_n(index) / peak_n) * TRACE_S)
            .sum();
        Some(Stroke { start_s: (rises as f64 - ordered as f64) * TRACE_S, slow: area })
    }

    /// The application is over: its trace is.
    pub(crate) fn forget_trace(&mut self) {
        let from = self.trace.len().saturating_sub(BEFORE);
        self.trace.drain(..from);
    }

    /// All that runs is forgotten.
    pub(crate) fn abandon(&mut self) {
        self.trace.clear();
        self.recent.clear();
        (self.falling, self.fallen) = (None, None);
    }

    /// Forces of the trace over the largest of them, to stand for an order that nobody tells.
    pub(crate) fn shape(&self) -> Vec<f64> {
        let peak_n = self.trace.iter().map(|at| at.force_n).fold(1.0, f64::max);
        self.trace.iter().map(|at| at.force_n / peak_n).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FULL_N: f64 = 30e3;

    /// An application of 20 s at half a brake and its release: delay of the distributor, s, and factor on the time of cylinders.
    fn brakes(timing: &mut Timing, late_s: f64, slow: f64) -> (Stroke, Stroke) {
        brakes_and_lets_go(timing, late_s, slow, 0.0)
    }

    /// The same where the order is lowered within so long, s.
    fn brakes_and_lets_go(timing: &mut Timing, late_s: f64, slow: f64, within_s: f64) -> (Stroke, Stroke) {
        let mut force_n = 0.0;
        let lets_go = |t: f64| if t < 22.0 { 1.0 } else { (1.0 - (t - 21.9) / within_s.max(1e-9)).max(0.0) };
        let order_at = |t: f64| if t < 2.0 { 0.0 } else { 0.5 * lets_go(t) };
        let mut rise = None;
        for step in 0..600 {
            let t = TRACE_S * f64::from(step);
            let wanted_n = FULL_N * order_at(t - late_s);
            let most_n = TRACE_S * FULL_N / slow / if wanted_n > force_n { 4.0 } else { 12.0 };
            force_n += (wanted_n - force_n).clamp(-most_n, most_n);
            timing.trace(order_at(t), (force_n, 0.0), t > 2.0 && t < 22.0, (FULL_N, false));
            if step == 219 {
                rise = timing.rise(None, FULL_N);
            }
            if step == 221 {
                timing.forget_trace();
            }
        }
        (rise.expect("it rises"), timing.fallen().expect("it falls"))
    }

    #[test]
    fn a_late_distributor_begins_later_and_a_slow_cylinder_takes_longer() {
        let mut timing = Timing::default();
        let (rise, fall) = brakes(&mut timing, 0.3, 1.0);
        let (late_rise, late_fall) = brakes(&mut timing, 3.3, 1.0);
        assert!((late_rise.start_s - rise.start_s - 3.0).abs() < 0.15, "{rise:?} {late_rise:?}");
        assert!(
            (late_fall.start_s - fall.start_s - 3.0).abs() < 0.15
                && (late_fall.slow - fall.slow).abs() < 0.05
        );
        let (slow_rise, slow_fall) = brakes(&mut timing, 0.3, 2.5);
        assert!((slow_fall.slow - fall.slow - 2.5_f64.ln()).abs() < 0.05, "{fall:?} {slow_fall:?}");
        assert!((slow_fall.start_s - fall.start_s).abs() < 0.2 && slow_rise.slow > rise.slow + 1.0);
    }

    /// Handles and brake computers do not let go from one value to the next.
    #[test]
    fn a_release_within_seconds_tells_the_same() {
        let fall =
            |late_s, slow, within_s| brakes_and_lets_go(&mut Timing::default(), late_s, slow, within_s).1;
        for within_s in [0.5, 1.0, 2.5] {
            let usual = fall(0.3, 1.0, within_s);
            assert!((fall(3.3, 1.0, within_s).start_s - usual.start_s - 3.0).abs() < 0.15, "{within_s}");
            assert!((fall(0.3, 2.5, within_s).slow - usual.slow - 2.5_f64.ln()).abs() < 0.1, "{within_s}");
            assert!((usual.slow - fall(0.3, 1.0, 0.0).slow).abs() < 0.1, "{within_s}");
        }
    }

    /// Of a locomotive that brakes electrically the pads come when its electric brake fades; both together come with the order.
    #[test]
    fn pads_and_electric_brake_together_begin_when_the_distributor_hears() {
        let start_s = |late_s: f64| {
            let mut timing = Timing::default();
            for step in 0..300 {
                let t = TRACE_S * f64::from(step);
                let order = if t >= 2.0 { 0.5 } else { 0.0 };
                let heard = if t >= 2.0 + late_s { 0.5 } else { 0.0 };
                let electric_n = if t < 20.0 { heard * FULL_N } else { 0.0 };
                let pads_n = if t < 20.0 { 0.0 } else { heard * FULL_N };
                timing.trace(order, (pads_n, electric_n), t > 2.0, (FULL_N, true));
            }
            (timing.rise(None, FULL_N), timing.blended_rise(FULL_N).expect("it rises").start_s)
        };
        let (pads, usual_s) = start_s(0.4);
        assert!(pads.is_some_and(|pads| pads.start_s > 17.0), "{pads:?}");
        assert!((start_s(3.4).1 - usual_s - 3.0).abs() < 0.15);
    }

    #[test]
    fn what_still_fills_or_brakes_electrically_tells_no_fall() {
        for (electric, steady) in [(true, true), (false, false)] {
            let mut timing = Timing::default();
            for step in 0..400 {
                let order = if (20..120).contains(&step) { 0.5 } else { 0.0 };
                let fills_n = if steady { 15e3 } else { 100.0 * f64::from(step) };
                let force_n =
                    if order > 0.0 { fills_n } else { (fills_n - 300.0 * f64::from(step - 120)).max(0.0) };
                timing.trace(order, (force_n, 0.0), order > 0.0, (FULL_N, electric));
            }
            assert_eq!(timing.fallen(), None);
        }
    }

    #[test]
    fn orders_that_nobody_tells_or_that_are_too_few_make_no_stroke() {
        let mut timing = Timing::default();
        for value in 0..200 {
            let order = if value < 100 { f64::NAN } else { 0.0 };
            let force_n = if value < 100 { 20e3 } else { 20e3 * (-0.1 * f64::from(value - 100)).exp() };
            timing.trace(order, (force_n, 0.0), true, (20e3, false));
        }
        assert_eq!(timing.fallen(), None);
        assert_eq!(timing.rise(Some(&[1.0; 3]), 20e3).map(|rise| rise.start_s), Some(0.0));
        assert_eq!(timing.rise(Some(&[]), 20e3), None);
    }
}
