//! Departures of the rail: how much it holds, where, when and at which slip.

use crate::departure::{Departure, Moment};

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
