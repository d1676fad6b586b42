//! Departures of what holds the wagon back: slope, rolling, wind.

use std::f64::consts::PI;

use super::Drawn;
use crate::{
    departure::{Departure, Moment},
    random::{Stream, Wander},
    sheet::Sheet,
};

/// A slope that the map does not have, with rounded ends.
pub(super) struct UnmappedSlope {
    pub slope_rad: f64,
    pub from_m: f64,
    pub to_m: f64,
    pub round_m: f64,
}

impl Departure for UnmappedSlope {
    fn grade_error_rad(&self, now: &Moment) -> f64 {
        let ramp = |from_m: f64| {
            let share = ((now.position_m - from_m) / self.round_m).clamp(0.0, 1.0);
            0.5 * (1.0 - (PI * share).cos())
        };
        self.slope_rad * (ramp(self.from_m) - ramp(self.to_m))
    }
}

/// More rolling resistance than the data sheet, part constant, part with a broken power of speed.
pub(super) struct StiffRunning {
    pub constant_n: f64,
    pub at_20_m_s_n: f64,
}

impl Departure for StiffRunning {
    fn body_force_n(&self, now: &Moment) -> f64 {
        let moving = (now.v_m_s / 0.5).tanh();
        -moving * (self.constant_n + self.at_20_m_s_n * (now.v_m_s.max(0.0) / 20.0).powf(1.5))
    }
}

/// Wind against the train that breathes slowly.
pub(super) struct Wind {
    pub mean_m_s: f64,
    pub stream: Stream,
    pub breath: Option<Wander>,
    pub now_m_s: f64,
    pub until_next: u32,
}

impl Departure for Wind {
    fn begin(&mut self) {
        self.breath = Some(Wander::new(self.stream.clone(), 0.06 * self.mean_m_s, 12.0, 0.01));
        self.now_m_s = self.mean_m_s;
        self.until_next = 0;
    }

    fn advance(&mut self, now: &Moment) {
        if self.until_next == 0 {
            self.until_next = (0.01 / now.step_s).round() as u32;
            if let Some(breath) = &mut self.breath {
                self.now_m_s = self.mean_m_s + breath.advance();
            }
        }
        self.until_next -= 1;
    }

    fn headwind_m_s(&self, _now: &Moment) -> f64 {
        self.now_m_s
    }
}

pub(super) fn grade(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let slope_rad = strength * stream.sign() * stream.uniform(0.003, 0.006);
    let from_m = stream.uniform(60.0, 260.0);
    let to_m = from_m + stream.uniform(120.0, 350.0);
    let departure = UnmappedSlope { slope_rad, from_m, to_m, round_m: stream.uniform(10.0, 30.0) };
    (Box::new(departure), vec![("slope_rad", slope_rad), ("from_m", from_m), ("to_m", to_m)])
}

pub(super) fn running_resistance(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let extra_n = strength * sheet.mass_kg * stream.uniform(0.02, 0.04);
    let share = stream.uniform(0.2, 0.8);
    let (constant_n, at_20_m_s_n) = (extra_n * share, extra_n * (1.0 - share));
    let departure = StiffRunning { constant_n, at_20_m_s_n };
    (Box::new(departure), vec![("constant_n", constant_n), ("at_20_m_s_n", at_20_m_s_n)])
}

pub(super) fn headwind(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let mean_m_s = strength * stream.uniform(6.0, 11.0);
    let departure = Wind {
        mean_m_s,
        stream: Stream::new(stream.below(1 << 30) as u64, "breath", 0),
        breath: None,
        now_m_s: mean_m_s,
        until_next: 0,
    };
    (Box::new(departure), vec![("mean_m_s", mean_m_s)])
}
