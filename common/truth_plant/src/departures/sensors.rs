//! Departures of what is shown from what is.

use std::{collections::VecDeque, f64::consts::TAU};

use super::Drawn;
use crate::{
    departure::{Departure, Moment, Sensed},
    random::Stream,
    sheet::Sheet,
};

/// An encoder wheel off its centre: once a turn, with a little second order.
pub(super) struct OffCentreEncoder {
    pub wheelset: usize,
    pub amplitude: f64,
    pub phase_rad: f64,
    pub second_order: f64,
}

impl Departure for OffCentreEncoder {
    fn sense(&mut self, now: &Moment, shown: &mut Sensed) {
        let angle = now.wheel_angle_rad[self.wheelset] + self.phase_rad;
        let ripple = self.amplitude * (angle.sin() + self.second_order * (2.0 * angle).sin());
        shown.wheel_speed_rad_s[self.wheelset] *= 1.0 + ripple;
    }
}

/// Pulses counted over a window: the shown speed is the mean over the past window.
pub(super) struct CountingWindow {
    pub window_s: f64,
    pub past: VecDeque<[f64; 2]>,
}

impl Departure for CountingWindow {
    fn begin(&mut self) {
        self.past.clear();
    }

    fn sense(&mut self, _now: &Moment, shown: &mut Sensed) {
        self.past.push_back(shown.wheel_speed_rad_s);
        let samples = (self.window_s / 0.01).max(1.0);
        while self.past.len() > samples.ceil() as usize {
            self.past.pop_front();
        }
        let whole = samples.floor() as usize;
        let rest = samples - whole as f64;
        for wheelset in 0..2 {
            let newest = self.past.iter().rev().take(whole);
            let (sum, count) = newest.fold((0.0, 0.0), |(s, n), w| (s + w[wheelset], n + 1.0));
            let (tail, weight) = match self.past.iter().rev().nth(whole) {
                Some(oldest) => (rest * oldest[wheelset], rest),
                None => (0.0, 0.0),
            };
            shown.wheel_speed_rad_s[wheelset] = (sum + tail) / (count + weight);
        }
    }
}

/// The wheel-speed channels come from a clock that runs slow, slower as it warms.
pub(super) struct SlowClock {
    pub drift: f64,
    pub warming_per_s: f64,
    pub past: VecDeque<[f64; 2]>,
}

impl Departure for SlowClock {
    fn begin(&mut self) {
        self.past.clear();
    }

    fn sense(&mut self, now: &Moment, shown: &mut Sensed) {
        self.past.push_front(shown.wheel_speed_rad_s);
        let behind = self.drift * now.time_s * (1.0 + self.warming_per_s * now.time_s) / 0.01;
        for wheelset in 0..2 {
            shown.wheel_speed_rad_s[wheelset] = at(&self.past, behind, |w| w[wheelset]);
        }
    }
}

/// A speed sensor that shows the past: half transport delay, half smoothing.
pub(super) struct LateSpeed {
    pub delay_s: f64,
    pub smooth_s: f64,
    pub past: VecDeque<f64>,
    pub smoothed: Option<f64>,
}

impl Departure for LateSpeed {
    fn begin(&mut self) {
        self.past.clear();
        self.smoothed = None;
    }

    fn sense(&mut self, _now: &Moment, shown: &mut Sensed) {
        self.past.push_front(shown.v_m_s);
        self.past.truncate(200);
        let late = at(&self.past, self.delay_s / 0.01, |v| *v);
        let before = self.smoothed.unwrap_or(late);
        let value = before + (1.0 - (-0.01 / self.smooth_s).exp()) * (late - before);
        self.smoothed = Some(value);
        shown.v_m_s = value;
    }
}

/// A speed sensor of the wrong scale, a little worse at speed.
pub(super) struct WrongScale {
    pub relative: f64,
    pub bend_per_m_s: f64,
}

impl Departure for WrongScale {
    fn sense(&mut self, _now: &Moment, shown: &mut Sensed) {
        shown.v_m_s *= 1.0 + self.relative * (1.0 + self.bend_per_m_s * (shown.v_m_s - 15.0));
    }
}

/// The value this many samples back in a newest-first history, between samples linearly, the oldest beyond its end.
fn at<T>(newest_first: &VecDeque<T>, back: f64, value: impl Fn(&T) -> f64) -> f64 {
    let last = newest_first.len().saturating_sub(1);
    let index = (back.max(0.0).floor() as usize).min(last);
    let next = (index + 1).min(last);
    let share = (back - index as f64).clamp(0.0, 1.0);
    let (a, b) = (newest_first.get(index).map_or(0.0, &value), newest_first.get(next).map_or(0.0, &value));
    a + share * (b - a)
}

pub(super) fn wheel_encoder_eccentricity(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let departure = OffCentreEncoder {
        wheelset: stream.below(2),
        amplitude: strength * stream.uniform(0.005, 0.010),
        phase_rad: stream.uniform(0.0, TAU),
        second_order: stream.uniform(0.05, 0.15),
    };
    let parameters = vec![
        ("wheelset", departure.wheelset as f64),
        ("amplitude", departure.amplitude),
        ("phase_rad", departure.phase_rad),
    ];
    (Box::new(departure), parameters)
}

pub(super) fn wheel_encoder_window(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let window_s = strength * stream.uniform(0.08, 0.16);
    (Box::new(CountingWindow { window_s, past: VecDeque::new() }), vec![("window_s", window_s)])
}

pub(super) fn clock_skew(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let drift = strength * stream.uniform(0.003, 0.007);
    let departure = SlowClock { drift, warming_per_s: stream.uniform(0.0, 0.004), past: VecDeque::new() };
    (Box::new(departure), vec![("drift", drift)])
}

pub(super) fn speed_latency(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let latency_s = strength * stream.uniform(0.18, 0.35);
    let share = stream.uniform(0.5, 0.9);
    let departure = LateSpeed {
        delay_s: share * latency_s,
        smooth_s: (1.0 - share) * latency_s,
        past: VecDeque::new(),
        smoothed: None,
    };
    (Box::new(departure), vec![("latency_s", latency_s)])
}

pub(super) fn speed_scale(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let relative = strength * stream.sign() * stream.uniform(0.006, 0.015);
    let bend_per_m_s = stream.uniform(-0.004, 0.004);
    (Box::new(WrongScale { relative, bend_per_m_s }), vec![("relative", relative)])
}
