//! The force of one wheelset beside those of its wagon: while an application is held, while it moves, and over several.

use crate::second::SECOND_S;

/// Seconds that tell what a wheelset does beside the others.
pub(super) const ENOUGH: f64 = 5.0;
/// The first seconds under pressure, in which a leak has taken little yet, and those in which it has, s.
const FRESH_S: f64 = 6.0;
const AGED_S: f64 = 12.0;
/// From here on a wheelset differs from the others; and forces of several applications tell a share from a constant.
const DIFFERS: f64 = 0.07;
const FORCES_APART: f64 = 0.1;
/// While the others move between these shares of what they were held at, a share and a constant differ.
const MOVES: (f64, f64) = (0.15, 0.8);
/// So many values tell it.
const MOVED: f64 = 5.0;

/// Sums over forces of a wheelset (y) and of the others (x).
#[derive(Debug, Clone, Copy, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct Pair {
    n: f64,
    x: f64,
    y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
    /// Seconds under pressure in this application.
    pressed_s: f64,
    /// Count and sum of the ratio: while fresh, and aged.
    fresh: (f64, f64),
    aged: (f64, f64),
    /// Number of applications in a row in which it differed, and sums over their means: of the others' force x and of the
    /// difference d.
    runs: [f64; 6],
}

/// Forces of a wheelset and of the others while they held still last, and how well a share and a constant by that foretold what
/// it did while the others moved.
#[derive(Debug, Clone, Copy, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct Moving {
    /// Force of the others and of this wheelset while held, N; 0 before.
    held_n: (f64, f64),
    /// Forces of the second before, N.
    before_n: (f64, f64),
    /// Values taken, and sums of squares that a share and a constant leave, N².
    count: f64,
    left: (f64, f64),
}

/// How the force of one wheelset lies beside those of its wagon.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Beside {
    /// Seconds that say so.
    pub seconds: f64,
    /// Force over that of the others.
    pub ratio: f64,
    /// Force less that of the others, N.
    pub offset_n: f64,
    /// Root mean square of what a share leaves unexplained, and a constant, N.
    pub left_n: (f64, f64),
    /// Ratio in the first seconds under pressure, and later.
    pub over_time: Option<(f64, f64)>,
    /// What the difference is by these.
    pub looks: Looks,
}

/// What a difference between two pressing forces looks like.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) enum Looks {
    /// Like a share of the others' force.
    Share,
    /// Like the same force throughout.
    Constant,
    /// Forces were too much alike to say.
    #[default]
    Either,
}

impl Moving {
    /// Takes forces of a second under pressure, N: those of a brake that is held are what a fall is foretold by.
    pub(super) fn hold(&mut self, others_n: f64, own_n: f64) {
        let (others_before_n, own_before_n) = std::mem::replace(&mut self.before_n, (others_n, own_n));
        let still = |now_n: f64, before_n: f64| (now_n - before_n).abs() < 0.03 * others_n;
        if still(others_n, others_before_n) && still(own_n, own_before_n) {
            self.held_n = (others_n, own_n);
        }
    }

    pub(super) fn take(&mut self, others_n: f64, own_n: f64) {
        let (held_n, own_held_n) = self.held_n;
        if held_n <= 0.0 || !(MOVES.0 * held_n..MOVES.1 * held_n).contains(&others_n) {
            return;
        }
        let by_share_n = own_n - others_n * own_held_n / held_n;
        // A transducer that reads too little shows nothing, or less than that, before its cylinder is empty.
        let by_constant_n = own_n.max(0.0) - (others_n - (held_n - own_held_n)).max(0.0);
        self.count += 1.0;
        self.left = (self.left.0 + by_share_n * by_share_n, self.left.1 + by_constant_n * by_constant_n);
    }

    /// An application is over: older ones count for less.
    pub(super) fn fade(&mut self) {
        self.count *= 0.5;
        self.left = (0.5 * self.left.0, 0.5 * self.left.1);
    }

    /// What a share and a constant leave, root mean square, N; `None` while too little has moved.
    pub(super) fn left_n(&self) -> Option<(f64, f64)> {
        (self.count >= MOVED).then(|| ((self.left.0 / self.count).sqrt(), (self.left.1 / self.count).sqrt()))
    }
}

impl Pair {
    pub(super) fn add(&mut self, x: f64, y: f64) {
        self.n += 1.0;
        self.x += x;
        self.y += y;
        self.xx += x * x;
        self.xy += x * y;
        self.yy += y * y;
        self.pressed_s += SECOND_S;
        if self.pressed_s <= FRESH_S {
            self.fresh = (self.fresh.0 + 1.0, self.fresh.1 + y / x);
        } else if self.pressed_s > AGED_S {
            self.aged = (self.aged.0 + 1.0, self.aged.1 + y / x);
        }
    }

    /// What told enough is over; what was too short is completed by the next application.
    pub(super) fn end(&mut self) {
        if let Some(beside) = self.read() {
            let differs = (beside.ratio - 1.0).abs() > DIFFERS;
            let runs = if differs { self.with_this() } else { [0.0; 6] };
            *self = Self { runs, ..Self::default() };
        }
        self.pressed_s = 0.0;
    }

    /// Sums over applications with this one.
    fn with_this(&self) -> [f64; 6] {
        let (x, d) = (self.x / self.n, (self.y - self.x) / self.n);
        let own = [1.0, x, d, x * x, x * d, d * d];
        std::array::from_fn(|index| self.runs[index] + own[index])
    }

    /// What a share and a constant leave unexplained of the differences of several applications, if their forces differ enough.
    fn left_over_runs_n(&self) -> Option<(f64, f64)> {
        let [n, x, d, xx, xd, dd] = self.with_this();
        let spread = (xx / n - (x / n).powi(2)).max(0.0).sqrt();
        let share = xd / xx;
        let by_share = (dd - share * xd).max(0.0) / n;
        let by_constant = dd / n - (d / n).powi(2);
        (n >= 2.0 && spread > FORCES_APART * x / n).then(|| (by_share.sqrt(), by_constant.max(0.0).sqrt()))
    }

    pub(super) fn read(&self) -> Option<Beside> {
        if self.n < ENOUGH || self.xx <= 0.0 {
            return None;
        }
        let ratio = self.xy / self.xx;
        let offset_n = (self.y - self.x) / self.n;
        let by_share = (self.yy - ratio * self.xy).max(0.0) / self.n;
        let by_constant = (self.yy - 2.0 * self.xy + self.xx) / self.n - offset_n * offset_n;
        let tells = self.fresh.0 >= 3.0 && self.aged.0 >= 3.0;
        Some(Beside {
            seconds: self.n,
            ratio,
            offset_n,
            left_n: self.left_over_runs_n().unwrap_or((by_share.sqrt(), by_constant.max(0.0).sqrt())),
            over_time: tells.then(|| (self.fresh.1 / self.fresh.0, self.aged.1 / self.aged.0)),
            looks: Looks::Either,
        })
    }
}
