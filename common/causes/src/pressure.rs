//! Pressing forces of one wagon: beside one another, against the order, and when they rise.
//!
//! Cylinders of one wagon hang on one distributor, so that their forces are alike; what one lacks, and whether it lacks a
//! share (a vent), a constant (a transducer's offset) or more and more (a leak), tells the causes apart.

use crate::input::MAX_WHEELSETS;
use crate::robust::{Past, median};
use crate::second::WagonSecond;

/// Time between two values of the traces, s.
pub(crate) const TRACE_S: f64 = 0.2;
/// Longest trace of an application.
const LONGEST: usize = 600;
/// Kept before an application begins.
const BEFORE: usize = 10;
/// Older applications count so much less each time: enough to complete one that is short.
const FADING: f64 = 0.1;

/// Sums over forces of a wheelset (y) and of the others (x).
#[derive(Debug, Clone, Copy, Default, serde::Serialize, serde::Deserialize)]
struct Pair {
    n: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
    /// Ratio against time within the application.
    t: f64,
    tt: f64,
    r: f64,
    rt: f64,
    rn: f64,
}

/// How the force of one wheelset lies beside those of its wagon.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Beside {
    /// Force over that of the others.
    pub ratio: f64,
    /// Force less that of the others, N.
    pub offset_n: f64,
    /// Root mean square of what a share leaves unexplained, and a constant, N.
    pub left_n: (f64, f64),
    /// Trend of the ratio within applications, 1/s.
    pub trend_per_s: f64,
}

/// When the force of the wagon rose, against its own past and the train.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rise {
    /// First rise, later than usual by so much, s, and its scatter.
    pub start_s: (f64, f64),
    /// Area between order and force, more than usual by so much, s, and its scatter.
    pub area_s: (f64, f64),
    /// The usual area, s.
    pub usual_s: f64,
}

/// Pressing forces of one wagon.
#[derive(Debug, Clone, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct Pressure {
    /// Largest force of the middle wheelset seen, N.
    pub full_n: f64,
    pair: [Pair; MAX_WHEELSETS],
    /// Force of each wheelset while released, N: fading mean, and for how long.
    released_n: [f64; MAX_WHEELSETS],
    /// Seconds released so far in this pause.
    pub released_s: f64,
    before_n: f64,
    /// Largest force of the middle wheelset in this application, N.
    pub peak_n: f64,
    /// Whether an electric brake took part.
    pub electric: bool,
    trace: Vec<(f64, f64)>,
    start: Past,
    area: Past,
    /// Largest force of an application over the largest ever and over the order.
    share: Past,
}

impl Pressure {
    /// Whether the pads were left out although they never are beside the electric brake of this wagon; `order` is the largest
    /// of the application. What is usual is learnt from the others.
    pub(crate) fn left_out(&mut self, order: f64, not_pressed: f64) -> bool {
        if self.full_n < 1000.0 || order < 0.1 {
            return false;
        }
        let share = self.peak_n / self.full_n;
        let usual = self.share.count() >= 2.0 && self.share.mean() - 3.0 * self.share.sigma() > 0.15;
        let out = share < not_pressed && (!self.electric || usual);
        if !out {
            self.share.take(share / order);
        }
        out
    }

    /// Takes a value of the traces: the order, and the force of the middle wheelset.
    pub(crate) fn trace(&mut self, order: f64, force_n: f64, braking: bool) {
        if !braking && self.trace.len() >= BEFORE {
            self.trace.remove(0);
        }
        if self.trace.len() < LONGEST {
            self.trace.push((order, force_n));
        }
    }

    /// Takes a second. `slides`: some wheelset of the wagon slides, so that slide protection may vent.
    pub(crate) fn take(
        &mut self,
        second: &WagonSecond,
        wheelsets: usize,
        since_s: Option<f64>,
        quiet: bool,
        slides: bool,
    ) {
        let middle_n = median(&mut second.wheel[..wheelsets].iter().map(|wheel| wheel.press_n).collect());
        if !middle_n.is_finite() {
            return;
        }
        self.electric |= second.wheel[..wheelsets].iter().any(|wheel| wheel.drive_nm < -150.0);
        self.peak_n = self.peak_n.max(middle_n);
        let Some(t) = since_s.filter(|_| !slides) else {
            self.pause(second, wheelsets, middle_n, quiet && since_s.is_none());
            return;
        };
        self.released_s = 0.0;
        self.full_n = self.full_n.max(middle_n);
        for k in 0..wheelsets {
            let own_n = second.wheel[k].press_n;
            let others = (0..wheelsets).filter(|other| *other != k).map(|other| second.wheel[other].press_n);
            let others_n = median(&mut others.collect());
            if own_n.is_finite() && others_n > 0.12 * self.full_n && others_n > 500.0 {
                self.pair[k].add(others_n, own_n, t);
            }
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

    /// Each wheelset beside the others, over the latest applications.
    pub(crate) fn beside(&self, k: usize) -> Option<Beside> {
        self.pair[k].read()
    }

    /// The application or pause that runs is forgotten.
    pub(crate) fn abandon(&mut self) {
        (self.peak_n, self.electric, self.before_n, self.released_s) = (0.0, false, 0.0, 0.0);
        self.trace.clear();
    }

    /// The application is over.
    pub(crate) fn end(&mut self) {
        for pair in &mut self.pair {
            pair.fade();
        }
        (self.peak_n, self.electric) = (0.0, false);
    }

    /// Start and area of the rise of the latest application, s; `None` if it does not tell them.
    pub(crate) fn rise(&self, orders: Option<&[f64]>) -> Option<(f64, f64)> {
        let order = |index: usize| orders.map_or(self.trace[index].0, |orders| orders[index]);
        let count = self.trace.len();
        let most = (0..count).map(order).fold(f64::NAN, f64::max);
        let peak_n = self.trace.iter().map(|(_, force_n)| *force_n).fold(f64::NAN, f64::max);
        let told = most > 0.1 && peak_n > 0.15 * self.full_n && peak_n > 1000.0 && !self.electric;
        if !told {
            return None;
        }
        let ordered = (0..count).find(|index| order(*index) > 0.04)?;
        let rises = (0..count).find(|index| self.trace[*index].1 > 0.04 * self.full_n + 150.0)?;
        let level = (0..count).find(|index| self.trace[*index].1 > 0.95 * peak_n)?;
        let area = (ordered..level.max(ordered))
            .map(|index| (order(index) / most - self.trace[index].1 / peak_n) * TRACE_S)
            .sum();
        Some(((rises as f64 - ordered as f64) * TRACE_S, area))
    }

    /// The order of the latest application as its trace has it.
    pub(crate) fn forget_trace(&mut self) {
        let from = self.trace.len().saturating_sub(BEFORE);
        self.trace.drain(..from);
    }

    /// Forces of the trace over the largest of them, to stand for an order that nobody tells.
    pub(crate) fn shape(&self) -> Vec<f64> {
        let peak_n = self.trace.iter().map(|(_, force_n)| *force_n).fold(1.0, f64::max);
        self.trace.iter().map(|(_, force_n)| force_n / peak_n).collect()
    }

    /// A rise against its own past; `None` while there is none.
    pub(crate) fn against_past(&self, start_s: f64, area_s: f64) -> Option<Rise> {
        (self.start.count() >= 2.0).then(|| Rise {
            start_s: (start_s - self.start.mean(), self.start.sigma().max(0.12)),
            area_s: (area_s - self.area.mean(), self.area.sigma().max(0.10)),
            usual_s: self.area.mean(),
        })
    }

    /// A rise becomes part of the past.
    pub(crate) fn remember(&mut self, start_s: f64, area_s: f64) {
        self.start.take(start_s);
        self.area.take(area_s);
    }
}

impl Pair {
    fn add(&mut self, x: f64, y: f64, t: f64) {
        self.n += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
        let ratio = y / x;
        self.rn += 1.0;
        self.t += t;
        self.tt += t * t;
        self.r += ratio;
        self.rt += ratio * t;
    }

    fn fade(&mut self) {
        for sum in [
            &mut self.n,
            &mut self.x,
            &mut self.y,
            &mut self.xx,
            &mut self.xy,
            &mut self.yy,
            &mut self.t,
            &mut self.tt,
            &mut self.r,
            &mut self.rt,
            &mut self.rn,
        ] {
            *sum *= FADING;
        }
    }

    fn read(&self) -> Option<Beside> {
        if self.n < 5.0 || self.xx <= 0.0 {
            return None;
        }
        let ratio = self.xy / self.xx;
        let offset_n = (self.y - self.x) / self.n;
        let by_share = (self.yy - ratio * self.xy).max(0.0) / self.n;
        let by_constant = (self.yy - 2.0 * self.xy + self.xx) / self.n - offset_n * offset_n;
        let spread = self.tt - self.t * self.t / self.rn;
        let trend = (self.rt - self.t * self.r / self.rn) / spread.max(1.0);
        Some(Beside {
            ratio,
            offset_n,
            left_n: (by_share.sqrt(), by_constant.max(0.0).sqrt()),
            trend_per_s: trend,
        })
    }
}
