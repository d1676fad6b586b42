//! A second of samples, summarised: means, slopes, and the ripple of wheel speeds with the wheel's angle.

use crate::input::{MAX_WHEELSETS, Reading};

/// A summary takes this long, s.
pub(crate) const SECOND_S: f64 = 1.0;
/// With more missing than this the mean belongs to another instant.
const WHOLE_SHARE: f64 = 0.97;

/// A channel over a second.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line {
    /// Mean; NaN if too much is missing.
    pub mean: f64,
    /// Slope, 1/s.
    pub slope: f64,
    /// Share of samples present.
    pub present: f64,
}

/// One wheelset over a second.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WheelSecond {
    /// Wheel speed, rad/s.
    pub omega: Line,
    /// Share of its values that are missing while the wagon says something; NaN while it says nothing.
    pub missing: f64,
    /// Standard deviation about a line and the first harmonic of the wheel's angle, rad/s.
    pub scatter: f64,
    /// Largest deviation from them, rad/s.
    pub largest: f64,
    /// Amplitude of the first harmonic of the wheel's angle, rad/s.
    pub once_a_turn: f64,
    /// Pressing force, N.
    pub press_n: f64,
    /// Drive torque, N m; 0 where none is given.
    pub drive_nm: f64,
}

/// One wagon over a second.
#[derive(Debug, Clone)]
pub(crate) struct WagonSecond {
    /// Speed.
    pub v: Line,
    /// Its wheelsets.
    pub wheel: [WheelSecond; MAX_WHEELSETS],
    /// Mass by load sensors, kg.
    pub load_kg: f64,
    /// Brake that is ordered.
    pub demand: f64,
    /// Slope of the track, rad.
    pub grade_rad: f64,
    /// Share of samples with anything at all.
    pub heard: f64,
}

/// Samples of one wagon while the second lasts.
#[derive(Debug, Clone, Default)]
pub(crate) struct Buffer {
    readings: Vec<Reading>,
    deviation: Vec<f64>,
}

impl Buffer {
    pub(crate) fn push(&mut self, reading: &Reading) {
        self.readings.push(*reading);
    }

    /// Sums up the second and begins the next.
    pub(crate) fn close(&mut self, wheelsets: usize, dt_s: f64) -> WagonSecond {
        let rows = std::mem::take(&mut self.readings);
        let heard = rows.iter().filter(|row| speaks(row));
        let nothing = WheelSecond {
            omega: Line { mean: f64::NAN, slope: f64::NAN, present: 0.0 },
            missing: f64::NAN,
            scatter: f64::NAN,
            largest: f64::NAN,
            once_a_turn: f64::NAN,
            press_n: f64::NAN,
            drive_nm: 0.0,
        };
        let mut wheel = [nothing; MAX_WHEELSETS];
        for (k, place) in wheel.iter_mut().enumerate().take(wheelsets) {
            *place = self.wheel(&rows, k, dt_s);
        }
        let second = WagonSecond {
            v: line(rows.iter().map(|row| row.v_m_s), rows.len(), dt_s),
            wheel,
            load_kg: mean(rows.iter().map(|row| row.load_kg)),
            demand: mean(rows.iter().map(|row| row.brake_demand)),
            grade_rad: mean(rows.iter().map(|row| row.grade_rad)),
            heard: heard.count() as f64 / rows.len().max(1) as f64,
        };
        self.readings = rows;
        self.readings.clear();
        second
    }

    fn wheel(&mut self, rows: &[Reading], k: usize, dt_s: f64) -> WheelSecond {
        let omega = line(rows.iter().map(|row| row.wheel_speed_rad_s[k]), rows.len(), dt_s);
        let (scatter, largest, once_a_turn) = self.ripple(rows, k, &omega, dt_s);
        let drive_nm = mean(rows.iter().map(|row| row.drive_torque_nm[k]));
        let heard = || rows.iter().filter(|row| speaks(row));
        let lost = heard().filter(|row| row.wheel_speed_rad_s[k].is_nan()).count();
        WheelSecond {
            omega,
            missing: lost as f64 / heard().count() as f64,
            scatter,
            largest,
            once_a_turn,
            press_n: mean(rows.iter().map(|row| row.pressing_force_n[k])),
            drive_nm: if drive_nm.is_finite() { drive_nm } else { 0.0 },
        }
    }

    /// Deviation from the line: the part once a turn, by least squares, and what is left.
    fn ripple(&mut self, rows: &[Reading], k: usize, omega: &Line, dt_s: f64) -> (f64, f64, f64) {
        if !omega.mean.is_finite() || omega.mean.abs() < 3.0 {
            return (f64::NAN, f64::NAN, f64::NAN);
        }
        let middle = 0.5 * (rows.len() as f64 - 1.0);
        let fitted = |index: usize| omega.mean + omega.slope * dt_s * (index as f64 - middle);
        let (mut cc, mut cs, mut ss, mut c, mut s) = (0.0, 0.0, 0.0, 0.0, 0.0);
        let mut turned = 0.0_f64;
        self.deviation.clear();
        for (index, row) in rows.iter().enumerate() {
            turned += fitted(index) * dt_s;
            let off = row.wheel_speed_rad_s[k] - fitted(index);
            self.deviation.push(off);
            if off.is_finite() {
                let (sin, cos) = turned.sin_cos();
                (cc, cs, ss) = (cc + cos * cos, cs + cos * sin, ss + sin * sin);
                (c, s) = (c + off * cos, s + off * sin);
            }
        }
        let determinant = cc * ss - cs * cs;
        if determinant < 1e-3 * (cc + ss).powi(2) {
            return (f64::NAN, f64::NAN, f64::NAN);
        }
        let (a, b) = ((c * ss - s * cs) / determinant, (s * cc - c * cs) / determinant);
        turned = 0.0;
        let (mut sum, mut largest, mut count) = (0.0, 0.0_f64, 0.0);
        for (index, off) in self.deviation.iter().enumerate() {
            turned += fitted(index) * dt_s;
            if off.is_finite() {
                let (sin, cos) = turned.sin_cos();
                let left = off - a * cos - b * sin;
                sum += left * left;
                largest = largest.max(left.abs());
                count += 1.0;
            }
        }
        ((sum / count).sqrt(), largest, a.hypot(b))
    }
}

/// Whether a wagon says anything at that instant: where it does not, the way to it is lost, not a sensor.
fn speaks(row: &Reading) -> bool {
    row.v_m_s.is_finite() || row.pressing_force_n[0].is_finite()
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values
        .filter(|value| value.is_finite())
        .fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// Value in the middle and slope of the line through equally spaced values, by least squares. Where some are missing, the middle of
/// those that are there is not the middle of the second: without that, one gap in fifty turns 45 rad/s into a slope of 5 rad/s².
fn line(values: impl Iterator<Item = f64>, count: usize, dt_s: f64) -> Line {
    let middle = 0.5 * (count as f64 - 1.0);
    let (mut sum, mut moment, mut times, mut squares, mut present) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (index, value) in values.enumerate().filter(|(_, value)| value.is_finite()) {
        let t = (index as f64 - middle) * dt_s;
        sum += value;
        moment += t * value;
        times += t;
        squares += t * t;
        present += 1.0;
    }
    let share = if count > 0 { present / count as f64 } else { 0.0 };
    let weight = squares - times * times / present;
    if share < WHOLE_SHARE || weight.is_nan() || weight <= 0.0 {
        return Line { mean: f64::NAN, slope: f64::NAN, present: share };
    }
    let slope = (moment - times * sum / present) / weight;
    Line { mean: (sum - slope * times) / present, slope, present: share }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn second(omega: impl Fn(f64) -> f64) -> WheelSecond {
        let mut buffer = Buffer::default();
        for index in 0..50 {
            let mut reading = Reading { v_m_s: 20.0, ..Reading::default() };
            reading.wheel_speed_rad_s[0] = omega(0.02 * f64::from(index));
            buffer.push(&reading);
        }
        buffer.close(1, 0.02).wheel[0]
    }

    #[test]
    fn a_second_has_its_mean_its_slope_and_what_comes_once_a_turn() {
        let steady = second(|t| 44.0 - 2.0 * t);
        assert!((steady.omega.slope + 2.0).abs() < 1e-9 && steady.scatter < 1e-9);
        // The angle of 44 rad/s after t seconds is 44 t.
        let wobbling = second(|t| 44.0 + 0.5 * (44.0 * t).sin());
        assert!((wobbling.once_a_turn - 0.5).abs() < 0.03, "{}", wobbling.once_a_turn);
        assert!(wobbling.scatter < 0.1 * wobbling.once_a_turn);
    }

    #[test]
    fn one_missing_value_changes_neither_mean_nor_slope() {
        let whole = second(|t| 44.0 - 2.0 * t);
        for missing in [0.0, 0.5, 0.98] {
            let gappy = second(|t| if (t - missing).abs() < 1e-9 { f64::NAN } else { 44.0 - 2.0 * t });
            assert!((gappy.omega.slope + 2.0).abs() < 1e-9, "{} without {missing} s", gappy.omega.slope);
            assert!(
                (gappy.omega.mean - whole.omega.mean).abs() < 1e-9,
                "{} without {missing} s",
                gappy.omega.mean
            );
            assert!(gappy.largest < 1e-9, "rings by {} without {missing} s", gappy.largest);
        }
    }

    #[test]
    fn a_gap_gives_no_mean() {
        let gappy = second(|t| if t < 0.2 { f64::NAN } else { 44.0 });
        assert!(gappy.omega.mean.is_nan() && (gappy.omega.present - 0.8).abs() < 1e-9);
    }
}
