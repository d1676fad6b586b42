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
    /// For how long it has shown a wheelset that stands while the train runs and nothing brakes, s.
    pub stands_s: f64,
}

/// Speed at the rim below which a wheelset stands, and of the train above which it should not, m/s.
const STANDS_M_S: (f64, f64) = (0.3, 4.0);

impl Tachometer {
    /// Takes whether the wheelset stands while the train runs; in braking it may, and nothing is said.
    pub(crate) fn follow_standing(&mut self, rim_m_s: f64, v_m_s: f64, released: bool) {
        if rim_m_s.abs() > STANDS_M_S.0 {
            self.stands_s = 0.0;
        } else if rim_m_s.is_finite() && released && v_m_s > STANDS_M_S.1 {
            self.stands_s += 1.0;
        }
    }

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

/// A speed (of a wagon, or at the rim of a wheel) against that of the train: scale, lag, and creepage beyond what forces should
/// cause, by fading least squares. A wet rail gives way by more at the same force; without a term for that, the wheel that drives
/// first seems small, and early.
#[derive(Debug, Clone, Copy, Default, serde::Serialize, serde::Deserialize)]
pub(crate) struct SpeedSensor {
    /// Sums of products of the regressors: one, acceleration over speed, creepage that forces should cause.
    products: [[f64; 3]; 3],
    /// Sums of products of the deviation with them.
    deviation: [f64; 3],
    /// Sum of squares of the deviation.
    square: f64,
    /// Seconds taken.
    pub seconds: f64,
}

/// Memory of speeds, s.
const SPEED_MEMORY_S: f64 = 150.0;
/// The lag is told from this sum of squares of acceleration over speed on, 1/s².
const LEAST_CHANGE: f64 = 0.006;
/// Deviations of a second are so large; creepage differs from what forces should cause by so much of it.
const DEVIATION: f64 = 1e-3;
const CREEPS_OTHERWISE: f64 = 1.0;

impl SpeedSensor {
    /// Takes a second: deviation of its speed, relative, acceleration over speed of the train, 1/s, and the creepage that forces
    /// should cause, which the deviation is free of.
    pub(crate) fn take(&mut self, deviation: f64, rate: f64, creepage: f64) {
        let keep = 1.0 - 1.0 / SPEED_MEMORY_S;
        self.seconds += 1.0;
        let row = [1.0, rate, creepage];
        self.square = keep * self.square + deviation * deviation;
        for i in 0..3 {
            for j in 0..3 {
                self.products[i][j] = keep * self.products[i][j] + row[i] * row[j];
            }
            self.deviation[i] = keep * self.deviation[i] + row[i] * deviation;
        }
    }

    /// Share of the variance of the deviation that a lag explains: nearly all of it if it is one. Wheels that slip are behind by now more,
    /// now less.
    pub(crate) fn explained(&self) -> f64 {
        let n = self.products[0][0].max(1.0);
        let with = self.deviation[1] - self.products[0][1] * self.deviation[0] / n;
        let rates = self.products[1][1] - self.products[0][1] * self.products[0][1] / n;
        let deviations = self.square - self.deviation[0] * self.deviation[0] / n;
        if rates * deviations > 0.0 { with * with / (rates * deviations) } else { 0.0 }
    }

    /// Scale error of the latest minutes if there were no lag.
    pub(crate) fn plain(&self) -> f64 {
        self.deviation[0] / self.products[0][0].max(1.0)
    }

    /// Scale error and lag (s) of the latest minutes; the lag is `None` while the train hardly changes its speed. `creeps`: whether
    /// creepage may differ from what forces should cause. What is an error of a wheel is one either way.
    pub(crate) fn errors(&self, creeps: bool) -> (f64, Option<f64>) {
        let n = self.products[0][0].max(1.0);
        // Without the means, and without what creepage explains.
        let cross = |i: usize, j: usize| self.products[i][j] - self.products[0][i] * self.products[0][j] / n;
        let with = |i: usize| self.deviation[i] - self.products[0][i] * self.deviation[0] / n;
        let own = if creeps { 1.0 / (cross(2, 2) + (DEVIATION / CREEPS_OTHERWISE).powi(2)) } else { 0.0 };
        let spread = cross(1, 1) - cross(1, 2) * cross(1, 2) * own;
        let slope = match spread < LEAST_CHANGE {
            true => 0.0,
            false => (with(1) - cross(1, 2) * with(2) * own) / spread,
        };
        let creep = (with(2) - slope * cross(1, 2)) * own;
        let scale = (self.deviation[0] - slope * self.products[0][1] - creep * self.products[0][2]) / n;
        (scale, (spread >= LEAST_CHANGE).then_some(-slope))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wheel 0.1 % large and 0.05 s late, that drives hard on a wet rail: creepage is three times what forces should cause.
    #[test]
    fn creepage_of_a_wet_rail_is_no_error_of_a_wheel() {
        let mut sensor = SpeedSensor::default();
        for second in 0..300 {
            let v_m_s = 8.0 + 0.05 * f64::from(second);
            let drive = [0.0, 4e-4, 9e-4][(second / 20) as usize % 3];
            let rate = if drive > 0.0 { 700.0 * drive / v_m_s } else { -0.08 / v_m_s };
            sensor.take(1e-3 - 0.05 * rate + 2.0 * drive, rate, drive);
        }
        let (scale, lag_s) = sensor.errors(true);
        assert!((scale - 1e-3).abs() < 2e-4, "{scale}");
        assert!(lag_s.is_some_and(|lag_s| (lag_s - 0.05).abs() < 0.015), "{lag_s:?}");
        let (_, without_s) = sensor.errors(false);
        assert!(without_s.is_some_and(|lag_s| (lag_s - 0.05).abs() > 0.025), "{without_s:?}");
    }
}
