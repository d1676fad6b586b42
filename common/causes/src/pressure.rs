//! Pressing forces of one wagon: beside one another, and against the order.
//!
//! Cylinders of one wagon hang on one distributor, so that their forces are alike; what one lacks, and whether it lacks a
//! share (a vent), a constant (a transducer's offset) or more and more (a leak), tells the causes apart. What pads and the
//! electric brake do together follows the order; what the electric brake does not do is owed by the pads.

mod beside;

use crate::input::MAX_WHEELSETS;
use crate::robust::median;
use crate::second::{SECOND_S, WagonSecond};
use beside::{ENOUGH, Moving, Pair};

pub(crate) use beside::{Beside, Looks};

/// A share or a constant is told from the other when it leaves so much less, beyond what noise of a transducer leaves, N
/// (hand-set).
const CLEAR: f64 = 0.6;
const NOISE_N: f64 = 60.0;
/// An order must have stood for so many seconds before pressure is owed.
const STANDS: usize = 6;
/// And the pads owe something from this share of a full brake on.
const OWED: f64 = 0.1;

/// Pressing forces of one wagon.
#[derive(Debug, Clone, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct Pressure {
    /// Largest force of the middle wheelset seen, N.
    pub full_n: f64,
    pair: [Pair; MAX_WHEELSETS],
    moving: [Moving; MAX_WHEELSETS],
    /// Force of each wheelset while released, N: fading mean, and for how long.
    released_n: [f64; MAX_WHEELSETS],
    /// Seconds released so far in this pause.
    pub released_s: f64,
    before_n: f64,
    /// Largest force of the middle wheelset in this application, N.
    pub peak_n: f64,
    /// Whether an electric brake took part in this application, and whether it does now.
    pub electric: bool,
    pub electric_now: bool,
    /// Whether its pads owe nothing now, because others may brake for it.
    pub excused: bool,
    /// Orders of the latest seconds, and what pads and electric brake did.
    orders: Vec<(f64, f64)>,
    /// Force of the pads, and what the electric brake does instead of them, at a full order, N; and how many seconds told it.
    per_order_n: (f64, f64),
    /// Seconds in which the pads owed force, and the largest force in them, N.
    owed: (f64, f64),
}

impl Pressure {
    /// Force of pads and electric brake at a full order, N; `None` until enough has been seen.
    pub(crate) fn per_order_n(&self) -> Option<f64> {
        (self.per_order_n.1 >= 2.0 * ENOUGH).then_some(self.per_order_n.0)
    }

    /// For how long the pads have owed force in this application, s, if they gave less than a share of what they ever did; whether
    /// it is known that they do. `None` if they pressed, or nothing was owed.
    pub(crate) fn left_out_s(&self, not_pressed: f64) -> Option<f64> {
        let (owed_s, most_n) = self.owed;
        let known = self.full_n > 1000.0 && self.per_order_n.1 >= ENOUGH;
        (known && owed_s > 0.0 && most_n < not_pressed * self.full_n).then_some(owed_s)
    }

    /// Takes a second. `slides`: some wheelset of the wagon slides, so that slide protection may vent; `grip_m` is pad friction
    /// times the radius at which the pads act.
    pub(crate) fn take(
        &mut self,
        second: &WagonSecond,
        wheelsets: usize,
        since_s: Option<f64>,
        quiet: bool,
        slides: bool,
        grip_m: f64,
    ) {
        let wheels = &second.wheel[..wheelsets];
        let middle_n = median(&mut wheels.iter().map(|wheel| wheel.press_n).collect());
        if !middle_n.is_finite() {
            return;
        }
        self.electric_now = wheels.iter().any(|wheel| wheel.drive_nm < -150.0);
        self.electric |= self.electric_now;
        if slides && since_s.is_some() {
            // What slides brakes; and where slide protection has cut the electric brake, pads do not take its place at once.
            self.owed = (0.0, 0.0);
            self.orders.clear();
        }
        let Some(_) = since_s.filter(|_| !slides) else {
            self.pause(second, wheelsets, middle_n, quiet && since_s.is_none());
            return;
        };
        self.peak_n = self.peak_n.max(middle_n);
        self.released_s = 0.0;
        self.full_n = self.full_n.max(middle_n);
        let drive_nm = median(&mut wheels.iter().map(|wheel| wheel.drive_nm).collect());
        self.owe(second.demand, middle_n, (-drive_nm / grip_m).max(0.0));
        for k in 0..wheelsets {
            let own_n = second.wheel[k].press_n;
            let others = (0..wheelsets).filter(|other| *other != k).map(|other| second.wheel[other].press_n);
            let others_n = median(&mut others.collect());
            if own_n.is_finite() && others_n > 0.12 * self.full_n && others_n > 500.0 {
                self.pair[k].add(others_n, own_n);
                self.moving[k].hold(others_n, own_n);
            }
        }
    }

    /// Takes forces of one instant: what a wheelset does while the others come and go.
    pub(crate) fn trace(&mut self, forces_n: &[f64]) {
        for (k, own_n) in forces_n.iter().enumerate() {
            let others = forces_n.iter().enumerate().filter(|(other, _)| *other != k);
            let others_n = median(&mut others.map(|(_, force_n)| *force_n).collect());
            if own_n.is_finite() && others_n.is_finite() {
                self.moving[k].take(others_n, *own_n);
            }
        }
    }

    /// What is owed to the order of this second, and what pads and electric brake do together.
    fn owe(&mut self, order: f64, middle_n: f64, electric_n: f64) {
        if self.orders.len() == STANDS {
            self.orders.remove(0);
        }
        let together_n = middle_n + electric_n;
        self.orders.push((order, together_n));
        let range = |of: fn(&(f64, f64)) -> f64| {
            self.orders
                .iter()
                .map(of)
                .fold((f64::MAX, 0.0_f64), |(low, high), one| (low.min(one), high.max(one)))
        };
        let ((least, most), (least_n, most_n)) = (range(|one| one.0), range(|one| one.1));
        if self.orders.len() < STANDS || !order.is_finite() || least < OWED {
            return;
        }
        let (mean_n, count) = &mut self.per_order_n;
        let now_n = together_n / order;
        let steady = most - least < 0.03 && most_n - least_n < 0.03 * most_n + 300.0;
        if steady && (*count < ENOUGH || now_n > 0.6 * *mean_n) {
            *count = (*count + 1.0).min(60.0);
            *mean_n += (now_n - *mean_n) / *count;
        }
        if !self.excused && least * *mean_n - electric_n > OWED * *mean_n {
            self.owed = (self.owed.0 + SECOND_S, self.owed.1.max(middle_n));
        }
    }

    fn pause(&mut self, second: &WagonSecond, wheelsets: usize, middle_n: f64, quiet: bool) {
        // While cylinders still empty, nothing is told by what is left in them.
        let steady = (middle_n - self.before_n).abs() < 0.02 * self.before_n.max(2000.0);
        self.before_n = middle_n;
        self.released_s = if quiet && steady { self.released_s + 1.0 } else { 0.0 };
        if self.released_s > 3.0 {
            for k in 0..wheelsets {
                let own_n = second.wheel[k].press_n;
                if own_n.is_finite() {
                    let share = if self.released_s < 6.0 { 1.0 } else { 0.1 };
                    self.released_n[k] += share * (own_n - self.released_n[k]);
                }
            }
        }
    }

    /// Force of each wheelset while released, N; `None` until they have been released for some time.
    pub(crate) fn released_n(&self) -> Option<[f64; MAX_WHEELSETS]> {
        (self.released_s > 12.0).then_some(self.released_n)
    }

    /// Each wheelset beside the others, over the latest application that tells.
    pub(crate) fn beside(&self, k: usize) -> Option<Beside> {
        let mut beside = self.pair[k].read()?;
        let looks = |(by_share_n, by_constant_n): (f64, f64)| match () {
            () if by_constant_n.hypot(NOISE_N) < CLEAR * by_share_n.hypot(NOISE_N) => Looks::Constant,
            () if by_share_n.hypot(NOISE_N) < CLEAR * by_constant_n.hypot(NOISE_N) => Looks::Share,
            () => Looks::Either,
        };
        beside.looks = match looks(beside.left_n) {
            Looks::Either => self.moving[k].left_n().map_or(Looks::Either, looks),
            clear => clear,
        };
        Some(beside)
    }

    /// The application or pause that runs is forgotten.
    pub(crate) fn abandon(&mut self) {
        self.moving = Default::default();
        (self.peak_n, self.electric, self.before_n, self.released_s) = (0.0, false, 0.0, 0.0);
        self.orders.clear();
        self.owed = (0.0, 0.0);
    }

    /// The application is over.
    pub(crate) fn end(&mut self) {
        self.pair.iter_mut().for_each(Pair::end);
        self.moving.iter_mut().for_each(Moving::fade);
        (self.peak_n, self.electric, self.owed) = (0.0, false, (0.0, 0.0));
        self.orders.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::second::{Line, WheelSecond};

    const GRIP_M: f64 = 0.0875;

    fn second(order: f64, press_n: [f64; 4], drive_nm: f64) -> WagonSecond {
        let line = Line { mean: 10.0, slope: 0.0, present: 1.0 };
        let wheel = press_n.map(|press_n| WheelSecond {
            omega: line,
            missing: 0.0,
            scatter: 0.0,
            largest: 0.0,
            once_a_turn: 0.0,
            press_n,
            drive_nm,
        });
        WagonSecond { v: line, wheel, load_kg: f64::NAN, demand: order, grade_rad: 0.0, heard: 1.0 }
    }

    /// An application of so many seconds at this order; force of wheelset 1 over that of the others by the second.
    fn brakes(pressure: &mut Pressure, order: f64, seconds: usize, ratio: impl Fn(f64) -> f64) {
        for t in 0..seconds {
            let others_n = 30e3 * order;
            let t = t as f64;
            let press_n = [others_n, ratio(t) * others_n, others_n, others_n];
            pressure.take(&second(order, press_n, 0.0), 4, Some(t), false, false, GRIP_M);
        }
    }

    #[test]
    fn a_leak_takes_more_and_more_and_a_vent_a_share_from_the_beginning() {
        let over_time = |ratio: fn(f64) -> f64| {
            let mut pressure = Pressure::default();
            brakes(&mut pressure, 0.6, 40, ratio);
            pressure.beside(1).and_then(|beside| beside.over_time).expect("it tells")
        };
        let (fresh, aged) = over_time(|t| 1.0 - 0.8 * (1.0 - (-0.04 * t).exp()));
        assert!(fresh > 0.85 && aged < 0.6, "{fresh} {aged}");
        let (fresh, aged) = over_time(|_| 0.5);
        assert!((fresh - aged).abs() < 1e-9);
    }

    #[test]
    fn an_application_that_tells_is_not_mixed_with_older_ones() {
        let mut pressure = Pressure::default();
        brakes(&mut pressure, 0.6, 60, |_| 1.0);
        pressure.end();
        brakes(&mut pressure, 0.6, 10, |_| 0.1);
        let beside = pressure.beside(1).expect("it tells");
        assert!((beside.ratio - 0.1).abs() < 1e-6 && beside.seconds == 10.0, "{beside:?}");
    }

    #[test]
    fn two_applications_tell_a_share_from_a_constant() {
        let left_n = |ratio: fn(f64) -> f64| {
            let mut pressure = Pressure::default();
            for order in [0.3, 0.6] {
                brakes(&mut pressure, order, 20, |_| ratio(order));
                pressure.end();
            }
            brakes(&mut pressure, 0.45, 20, |_| ratio(0.45));
            pressure.beside(1).expect("it tells").left_n
        };
        let (by_share_n, by_constant_n) = left_n(|_| 0.6);
        assert!(by_share_n < 1.0 && by_constant_n > 500.0);
        let (by_share_n, by_constant_n) = left_n(|order| 1.0 - 3e3 / (30e3 * order));
        assert!(by_constant_n < 1.0 && by_share_n > 100.0, "{by_share_n} {by_constant_n}");
    }

    /// At a platform a railcar always presses equally hard; what a wheelset does while the brake lets go tells a share from a constant,
    /// and from a transducer that shows nothing where it reads less.
    #[test]
    fn what_moves_tells_a_share_from_a_constant_where_all_applications_are_alike() {
        let looks = |moves: bool, own: fn(f64) -> f64| {
            let mut pressure = Pressure::default();
            for _ in 0..2 {
                brakes(&mut pressure, 0.4, 20, |_| own(12e3) / 12e3);
                for step in 0..20 {
                    let others_n = 12e3 * (1.0 - 0.05 * f64::from(step));
                    if moves {
                        pressure.trace(&[others_n, own(others_n), others_n, others_n]);
                    }
                }
                pressure.end();
            }
            brakes(&mut pressure, 0.4, 20, |_| own(12e3) / 12e3);
            pressure.beside(1).expect("it tells").looks
        };
        assert_eq!(looks(true, |others_n| 0.5 * others_n), Looks::Share);
        assert_eq!(looks(true, |others_n| others_n - 6e3), Looks::Constant);
        assert_eq!(looks(true, |others_n| (others_n - 6e3).max(0.0)), Looks::Constant);
        assert_eq!(looks(false, |others_n| 0.5 * others_n), Looks::Either);
    }

    /// A wagon whose electric brake does all that is ordered owes nothing with its pads until it stands.
    #[test]
    fn pads_owe_what_the_electric_brake_does_not_do() {
        let mut pressure = Pressure::default();
        let application = |pressure: &mut Pressure, cut: bool| {
            let electric_nm = -0.5 * 30e3 * GRIP_M;
            for t in 0..30 {
                pressure.take(
                    &second(0.5, [0.0; 4], electric_nm),
                    4,
                    Some(f64::from(t)),
                    false,
                    false,
                    GRIP_M,
                );
            }
            assert_eq!(pressure.left_out_s(0.05), None, "the electric brake does it all");
            let held_n = if cut { 0.0 } else { 12e3 };
            for t in 30..60 {
                pressure.take(&second(0.4, [held_n; 4], 0.0), 4, Some(f64::from(t)), false, false, GRIP_M);
            }
        };
        for _ in 0..2 {
            application(&mut pressure, false);
            assert_eq!(pressure.left_out_s(0.05), None);
            pressure.end();
        }
        application(&mut pressure, true);
        assert!(pressure.left_out_s(0.05).is_some_and(|owed_s| owed_s >= 20.0));
    }

    /// On a low rail slide protection cuts the electric brake again and again, and pads do not take its place.
    #[test]
    fn nothing_is_owed_while_wheelsets_slide() {
        let mut pressure = Pressure::default();
        brakes(&mut pressure, 0.6, 30, |_| 1.0);
        pressure.end();
        let owed_s = |slides: fn(usize) -> bool| {
            let mut pressure = pressure.clone();
            for t in 0..60 {
                let cut = second(0.5, [0.0; 4], -0.15 * 30e3 * GRIP_M);
                pressure.take(&cut, 4, Some(t as f64), false, slides(t), GRIP_M);
            }
            pressure.left_out_s(0.05).unwrap_or(0.0)
        };
        assert!(owed_s(|_| false) > 50.0);
        assert!(owed_s(|t| t % 12 < 5) < 3.0);
    }
}
