//! Departures of the rail: how much it holds, where, when and at which slip.

use super::Drawn;
use crate::{
    departure::{Departure, Moment},
    random::Stream,
    sheet::Sheet,
};

/// Adhesion that falls with slip velocity, along a hyperbola.
pub(super) struct FallingFriction {
    pub depth: f64,
    pub half_m_s: f64,
}

impl Departure for FallingFriction {
    fn rail_friction(&self, _wheelset: usize, slip_velocity_m_s: f64, _now: &Moment) -> f64 {
        1.0 - self.depth * slip_velocity_m_s / (slip_velocity_m_s + self.half_m_s)
    }
}

/// The rear wheelset runs on what the leading one has cleaned: partly by rolling, partly by what it burns in sliding.
pub(super) struct CleanedRail {
    pub rolling: f64,
    pub sliding: f64,
    pub power_w: f64,
    pub smooth_s: f64,
    pub recent_w: f64,
}

impl Departure for CleanedRail {
    fn begin(&mut self) {
        self.recent_w = 0.0;
    }

    fn advance(&mut self, now: &Moment) {
        let share = now.step_s / self.smooth_s;
        self.recent_w += share * (now.sliding_power_w[0] - self.recent_w);
    }

    fn rail_friction(&self, wheelset: usize, _slip_velocity_m_s: f64, _now: &Moment) -> f64 {
        if wheelset == 0 {
            return 1.0;
        }
        1.0 + self.rolling + self.sliding * (1.0 - (-self.recent_w / self.power_w).exp())
    }
}

/// A stretch of track with a film on it; its edges are smeared.
pub(super) struct SlipperyStretch {
    pub loss: f64,
    pub from_m: f64,
    pub to_m: f64,
    pub edge_m: f64,
}

impl Departure for SlipperyStretch {
    fn rail_friction(&self, wheelset: usize, _slip_velocity_m_s: f64, now: &Moment) -> f64 {
        let x = now.contact_m[wheelset];
        let inside =
            0.5 * (((x - self.from_m) / self.edge_m).tanh() - ((x - self.to_m) / self.edge_m).tanh());
        1.0 - self.loss * inside
    }
}

/// Adhesion that decays exponentially with the speed of the wagon.
pub(super) struct SpeedDecay {
    pub speed_m_s: f64,
}

impl SpeedDecay {
    /// Speed at which the level of the rail is quoted, m/s.
    const QUOTED_AT_M_S: f64 = 12.0;
}

impl Departure for SpeedDecay {
    fn rail_friction(&self, _wheelset: usize, _slip_velocity_m_s: f64, now: &Moment) -> f64 {
        (-(now.v_m_s - Self::QUOTED_AT_M_S) / self.speed_m_s).exp()
    }
}

/// Sand between wheel and rail: it takes a moment to fall and stays a moment.
pub(super) struct Sand {
    pub gain: f64,
    pub fall_s: f64,
    pub stay_s: f64,
    pub cover: f64,
}

impl Departure for Sand {
    fn begin(&mut self) {
        self.cover = 0.0;
    }

    fn advance(&mut self, now: &Moment) {
        let (target, time_s) = if now.sanding { (1.0, self.fall_s) } else { (0.0, self.stay_s) };
        self.cover += now.step_s / time_s * (target - self.cover);
    }

    fn rail_friction(&self, _wheelset: usize, _slip_velocity_m_s: f64, _now: &Moment) -> f64 {
        1.0 + self.gain * self.cover.sqrt()
    }
}

pub(super) fn falling_friction(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let depth = (strength * stream.uniform(0.3, 0.5)).min(0.8);
    let half_m_s = stream.uniform(0.6, 2.5);
    (Box::new(FallingFriction { depth, half_m_s }), vec![("depth", depth), ("half_m_s", half_m_s)])
}

pub(super) fn self_cleaning(strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
    let gain = strength * stream.uniform(0.15, 0.35);
    let share = stream.uniform(0.4, 0.8);
    let departure = CleanedRail {
        rolling: gain * share,
        sliding: gain * (1.0 - share),
        power_w: sheet.mass_kg * stream.uniform(0.1, 0.4),
        smooth_s: 0.4,
        recent_w: 0.0,
    };
    let parameters = vec![("rolling", departure.rolling), ("sliding", departure.sliding)];
    (Box::new(departure), parameters)
}

pub(super) fn low_adhesion_patch(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let loss = (strength * stream.uniform(0.4, 0.65)).min(0.85);
    let from_m = stream.uniform(120.0, 230.0);
    let to_m = from_m + stream.uniform(50.0, 130.0);
    let departure = SlipperyStretch { loss, from_m, to_m, edge_m: stream.uniform(1.5, 5.0) };
    (Box::new(departure), vec![("loss", loss), ("from_m", from_m), ("to_m", to_m)])
}

pub(super) fn adhesion_speed(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let speed_m_s = stream.uniform(30.0, 60.0) / strength;
    (Box::new(SpeedDecay { speed_m_s }), vec![("speed_m_s", speed_m_s)])
}

pub(super) fn sanding(strength: f64, stream: &mut Stream, _sheet: &Sheet) -> Drawn {
    let gain = strength * stream.uniform(0.3, 0.6);
    let departure =
        Sand { gain, fall_s: stream.uniform(0.4, 1.0), stay_s: stream.uniform(0.8, 2.0), cover: 0.0 };
    (Box::new(departure), vec![("gain", gain)])
}
