//! Sensors that are wrong: what is missing, what rings or wobbles, what is late, and speed that is not the train's.

use crate::second::WheelSecond;

/// Memory of the share of missing values, s.
const MISSING_S: f64 = 90.0;
/// Memory of ripple, s.
const RIPPLE_S: f64 = 60.0;

/// A wheel's tachometer over the latest minutes.
#[derive(Debug, Clone, Copy, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct Tachometer {
    /// Share of values missing.
    pub missing: f64,
    /// Amplitude of what comes once a turn, relative.
    pub once_a_turn: f64,
    /// Scatter over what was declared.
    pub scatter: f64,
    /// Amplitude of what comes once a turn over what was declared.
    pub once: f64,
    /// Largest deviation of a second over the scatter declared.
    pub largest: f64,
    /// Seconds in which it rolled and could be judged.
    pub seconds: f64,
    silent_s: f64,
}

impl Tachometer {
    pub(crate) fn take(
        &mut self,
        wheel: &WheelSecond,
        radius_m: f64,
        v_m_s: f64,
        sigma_rad_s: f64,
        coasts: bool,
    ) {
        let share = 1.0 / MISSING_S;
        if wheel.missing.is_finite() {
            self.missing += share * (wheel.missing - self.missing);
        }
        self.silent_s = if wheel.omega.present > 0.0 { 0.0 } else { self.silent_s + 1.0 };
        // Driven or in a slide a wheel does as it likes.
        let rolls = coasts && (wheel.omega.mean * radius_m - v_m_s).abs() < 0.05 * v_m_s && v_m_s > 4.0;
        if rolls && wheel.scatter.is_finite() && wheel.omega.slope.abs() * radius_m < 1.5 {
            self.seconds += 1.0;
            let share = 1.0 / self.seconds.min(RIPPLE_S);
            let omega = wheel.omega.mean.abs();
            self.once_a_turn += share * (wheel.once_a_turn / omega - self.once_a_turn);
            self.scatter += share * (wheel.scatter / sigma_rad_s - self.scatter);
            self.once += share * (wheel.once_a_turn / sigma_rad_s - self.once);
            self.largest += share * (wheel.largest / sigma_rad_s - self.largest);
        }
    }

    /// For how long nothing has come, s.
    pub(crate) const fn silent_s(&self) -> f64 {
        self.silent_s
    }
}

/// A speed (of a wagon, or at the rim of a wheel) against that of the train: scale and lag, by fading least squares.
#[derive(Debug, Clone, Copy, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct SpeedSensor {
    n: f64,
    x: f64,
    xx: f64,
    y: f64,
    xy: f64,
    /// Seconds taken.
    pub seconds: f64,
}

impl SpeedSensor {
    /// Takes a second: deviation of its speed, relative, and acceleration over speed of the train, 1/s.
    pub(crate) fn take(&mut self, deviation: f64, rate: f64) {
        let keep = 1.0 - 1.0 / 150.0;
        self.seconds += 1.0;
        self.n = keep * self.n + 1.0;
        self.x = keep * self.x + rate;
        self.xx = keep * self.xx + rate * rate;
        self.y = keep * self.y + deviation;
        self.xy = keep * self.xy + rate * deviation;
    }

    /// Scale error and lag (s) of the latest minutes; the lag is `None` while the train hardly changes its speed.
    pub(crate) fn errors(&self) -> (f64, Option<f64>) {
        let mean = self.x / self.n.max(1.0);
        let spread = self.xx - mean * self.x;
        if spread < 0.006 {
            return (self.y / self.n.max(1.0), None);
        }
        let slope = (self.xy - mean * self.y) / spread;
        ((self.y - slope * self.x) / self.n.max(1.0), Some(-slope))
    }
}
