//! The plant's own wheel-slide protection, sanders and brake cylinders.

use crate::random::Stream;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Valve {
    Fill,
    Hold,
    Vent,
}

/// Valves and cylinders of both wheelsets, and the sander.
#[derive(Debug, Clone)]
pub struct Protection {
    vent_above: f64,
    fill_below: f64,
    fill_s: f64,
    vent_s: f64,
    release_s: f64,
    floor_share: f64,
    valve: [Valve; 2],
    force_n: [f64; 2],
    speed_before: [f64; 2],
    active_until_s: f64,
    sliding_since_s: Option<f64>,
    sander: bool,
    /// Whether the sanders run.
    pub sanding: bool,
}

impl Protection {
    /// The protection of one case; timings differ from case to case.
    #[must_use]
    pub fn new(stream: &mut Stream, sander: bool) -> Self {
        Self {
            vent_above: stream.uniform(0.07, 0.13),
            fill_below: stream.uniform(0.012, 0.03),
            fill_s: stream.uniform(0.3, 0.42),
            vent_s: stream.uniform(0.09, 0.14),
            release_s: stream.uniform(0.35, 0.5),
            floor_share: stream.uniform(0.15, 0.3),
            valve: [Valve::Fill; 2],
            force_n: [0.0; 2],
            speed_before: [0.0; 2],
            active_until_s: -1.0,
            sliding_since_s: None,
            sander,
            sanding: false,
        }
    }

    /// Decides the valves and the sander; once a sample. `rim_m_s` are rim speeds.
    pub fn decide(&mut self, time_s: f64, v_m_s: f64, rim_m_s: [f64; 2], demand_n: f64) {
        for (k, rim) in rim_m_s.into_iter().enumerate() {
            let slide = (v_m_s - rim) / v_m_s.max(1.5);
            let recovering = rim > self.speed_before[k] + 1e-4;
            self.valve[k] = match self.valve[k] {
                Valve::Fill if slide > self.vent_above => Valve::Vent,
                Valve::Vent if recovering && self.force_n[k] < 0.45 * demand_n => Valve::Hold,
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

    /// Cylinder forces after a step, N.
    pub fn fill(&mut self, step_s: f64, demand_n: f64) -> [f64; 2] {
        for k in 0..2 {
            let (target_n, time_s) = match self.valve[k] {
                Valve::Fill if demand_n >= self.force_n[k] => (demand_n, self.fill_s),
                Valve::Fill => (demand_n, self.release_s),
                Valve::Hold => continue,
                Valve::Vent => ((self.floor_share * demand_n).min(self.force_n[k]), self.vent_s),
            };
            self.force_n[k] += (1.0 - (-step_s / time_s).exp()) * (target_n - self.force_n[k]);
        }
        self.force_n
    }
}
