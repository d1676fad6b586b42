//! Departures between the cylinder pressure and the pad.

use std::collections::VecDeque;

use super::Drawn;
use crate::{
    departure::{Departure, Moment},
    random::Stream,
    sheet::Sheet,
};

/// Pad force behind the pressure: dead time, then two equal lags in a row.
pub(super) struct SlowRigging {
    pub dead_s: f64,
    pub lag_s: f64,
    pub waiting: VecDeque<[f64; 2]>,
    pub first: [f64; 2],
    pub second: [f64; 2],
}

impl Departure for SlowRigging {
    fn begin(&mut self) {
        self.waiting.clear();
        self.first = [0.0; 2];
        self.second = [0.0; 2];
    }

    fn advance(&mut self, now: &Moment) {
        self.waiting.push_back(now.cylinder_force_n);
        let late = if self.waiting.len() as f64 * now.step_s > self.dead_s {
            self.waiting.pop_front().unwrap_or_default()
        } else {
            [0.0; 2]
        };
        let share = 1.0 - (-2.0 * now.step_s / self.lag_s).exp();
        for wheelset in 0..2 {
            self.first[wheelset] += share * (late[wheelset] - self.first[wheelset]);
            self.second[wheelset] += share * (self.first[wheelset] - self.second[wheelset]);
        }
    }

    fn pad_force_n(&self, wheelset: usize, _cylinder_n: f64, _now: &Moment) -> f64 {
        self.second[wheelset]
    }
}

/// Friction in the rigging after Dahl (1968): the pad gets less while the pressure rises, more while it falls, and the
/// change of side takes a stretch of force.
pub(super) struct DahlRigging {
    pub relative: f64,
    pub reversal_n: f64,
    pub side: [f64; 2],
    pub before_n: [f64; 2],
}

impl Departure for DahlRigging {
    fn begin(&mut self) {
        self.side = [0.0; 2];
        self.before_n = [0.0; 2];
    }

    fn advance(&mut self, now: &Moment) {
        for wheelset in 0..2 {
            let change = now.cylinder_force_n[wheelset] - self.before_n[wheelset];
            self.before_n[wheelset] = now.cylinder_force_n[wheelset];
            let side = self.side[wheelset] + change / self.reversal_n
                - change.abs() / self.reversal_n * self.side[wheelset];
            self.side[wheelset] = side.clamp(-1.0, 1.0);
        }
    }

    fn pad_force_n(&self, wheelset: usize, cylinder_n: f64, _now: &Moment) -> f64 {
        cylinder_n * (1.0 - self.relative * self.side[wheelset])
    }
}

/// A return spring: the pad touches only above a force, softly.
pub(super) struct ReturnSpring {
    pub threshold_n: f64,
}

impl Departure for ReturnSpring {
    fn pad_force_n(&self, _wheelset: usize, cylinder_n: f64, _now: &Moment) -> f64 {
        let soft_n = 0.12 * self.threshold_n;
        let excess = (cylinder_n - self.threshold_n) / soft_n;
        if excess > 30.0 { excess * soft_n } else { soft_n * excess.exp().ln_1p() }
    }
}

/// A brake that never lets go on one wheelset.
pub(super) struct StuckBrake {
    pub wheelset: usize,
    pub torque_nm: f64,
}

impl Departure for StuckBrake {
    fn drag_torque_nm(&self, wheelset: usize, now: &Moment) -> f64 {
        if wheelset == self.wheelset { self.torque_nm * now.wheel_speed_rad_s[wheelset].tanh() } else { 0.0 }
    }
}

pub(super) fn brake_lag(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let dead_s = strength * stream.uniform(0.03, 0.12);
    let lag_s = strength * stream.uniform(0.12, 0.3);
    let departure =
        SlowRigging { dead_s, lag_s, waiting: VecDeque::new(), first: [0.0; 2], second: [0.0; 2] };
    (Box::new(departure), vec![("dead_s", dead_s), ("lag_s", lag_s)])
}

pub(super) fn rigging_hysteresis(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let relative = strength * stream.uniform(0.04, 0.09);
    let reversal_n = sheet.full_force_n() * stream.uniform(0.03, 0.08);
    let departure = DahlRigging { relative, reversal_n, side: [0.0; 2], before_n: [0.0; 2] };
    (Box::new(departure), vec![("relative", relative), ("reversal_n", reversal_n)])
}

pub(super) fn pressing_force_offset(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let threshold_n = strength * sheet.full_force_n() * stream.uniform(0.04, 0.09);
    (Box::new(ReturnSpring { threshold_n }), vec![("threshold_n", threshold_n)])
}

pub(super) fn dragging_brake(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let wheelset = stream.below(2);
    let torque_nm = strength * sheet.mass_kg * sheet.radius_m * stream.uniform(0.012, 0.03);
    let parameters = vec![("wheelset", wheelset as f64), ("torque_nm", torque_nm)];
    (Box::new(StuckBrake { wheelset, torque_nm }), parameters)
}
