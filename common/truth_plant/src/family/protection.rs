//! Slide protection, sanders and brake cylinders of a family wagon.

use super::units::PerWheelset;
use crate::random::Stream;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Valve {
    Fill,
    Hold,
    Vent,
}

/// Valves and cylinders of all wheelsets, and the sander.
#[derive(Debug, Clone)]
pub(super) struct Protection {
    protected: bool,
    wheelsets: usize,
    vent_above: f64,
    fill_below: f64,
    fill_s: f64,
    rate_per_s: f64,
    vent_s: f64,
    release_s: f64,
    floor_share: f64,
    valve: [Valve; 4],
    force_n: PerWheelset,
    speed_before: PerWheelset,
    active_until_s: f64,
    sliding_since_s: Option<f64>,
    sander: bool,
    /// Whether the sanders run.
    pub sanding: bool,
}

impl Protection {
    /// Timings differ from case to case.
    pub(super) fn new(stream: &mut Stream, wheelsets: usize, protected: bool, sander: bool) -> Self {
        Self {
            protected,
            wheelsets,
            vent_above: stream.uniform(0.06, 0.14),
            fill_below: stream.uniform(0.01, 0.03),
            fill_s: stream.uniform(0.2, 0.5),
            rate_per_s: stream.uniform(0.5, 2.0),
            vent_s: stream.uniform(0.08, 0.15),
            release_s: stream.uniform(0.3, 0.8),
            floor_share: stream.uniform(0.1, 0.3),
            valve: [Valve::Fill; 4],
            force_n: [0.0; 4],
            speed_before: [0.0; 4],
            active_until_s: -1.0,
            sliding_since_s: None,
            sander,
            sanding: false,
        }
    }

    /// A run begins, with this force in the cylinders, N.
    pub(super) fn begin(&mut self, force_n: f64) {
        *self = Self {
            valve: [Valve::Fill; 4],
            force_n: [force_n; 4],
            speed_before: [0.0; 4],
            active_until_s: -1.0,
            sliding_since_s: None,
            sanding: false,
            ..self.clone()
        };
    }

    /// Decides the valves and the sander; every 10 ms or slower. `rim_m_s` are rim speeds.
    pub(super) fn decide(&mut self, time_s: f64, v_m_s: f64, rim_m_s: PerWheelset, demand_n: f64) {
        if !self.protected {
            return;
        }
        for (k, rim) in rim_m_s.into_iter().enumerate().take(self.wheelsets) {
            let slide = (v_m_s - rim) / v_m_s.max(2.0);
            let recovering = rim > self.speed_before[k] + 1e-4;
            self.valve[k] = match self.valve[k] {
                Valve::Fill if slide > self.vent_above => Valve::Vent,
                Valve::Vent if recovering && self.force_n[k] < 0.5 * demand_n => Valve::Hold,
                Valve::Hold if slide > self.vent_above && !recovering => Valve::Vent,
                Valve::Vent | Valve::Hold if slide < self.fill_below => Valve::Fill,
                valve => valve,
            };
            self.speed_before[k] = rim;
            if self.valve[k] != Valve::Fill {
                self.active_until_s = time_s + 4.0;
            }
        }
        let active = self.sander && time_s < self.active_until_s;
        self.sliding_since_s = if active { self.sliding_since_s.or(Some(time_s)) } else { None };
        self.sanding = self.sliding_since_s.is_some_and(|since_s| time_s > since_s + 0.5);
    }

    /// Cylinder forces after a step, N: choked at first, then towards the demand.
    pub(super) fn fill(&mut self, step_s: f64, demand_n: f64, full_n: f64) -> PerWheelset {
        for k in 0..self.wheelsets {
            let (target_n, time_s) = match self.valve[k] {
                Valve::Fill if demand_n >= self.force_n[k] => (demand_n, self.fill_s),
                Valve::Fill => (demand_n, self.release_s),
                Valve::Hold => continue,
                Valve::Vent => ((self.floor_share * demand_n).min(self.force_n[k]), self.vent_s),
            };
            let most_n = self.rate_per_s * full_n * step_s;
            let vents = self.valve[k] == Valve::Vent;
            let change_n = step_s / time_s * (target_n - self.force_n[k]);
            self.force_n[k] += if vents { change_n } else { change_n.clamp(-most_n, most_n) };
        }
        self.force_n
    }
}
