//! Wheel-slide protection of one wagon: a reference speed from all its wheelsets and, where all of them slide, from the
//! train's bus; valves a wheelset or a bogie.

use super::units::PerWheelset;

/// Below this reference speed protection rests, m/s.
const RESTS_BELOW_M_S: f64 = 1.2;
/// Venting ends after so long, whatever the wheel does (a safety timer), s.
const LONGEST_VENT_S: f64 = 6.0;

/// The speed on the train's bus counts a little less than the wheelsets' own, so that its error vents nothing.
const BUS_SHARE: f64 = 0.985;

/// State of the valve between distributor and cylinder.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Valve {
    Fill,
    Hold,
    Vent,
}

/// Settings of one wagon's protection.
#[derive(Debug, Clone, Copy)]
pub struct ProtectionPlan {
    /// Slide at which a cylinder is vented: share of speed.
    pub vent_share: f64,
    /// And at least so much, m/s.
    pub vent_m_s: f64,
    /// One valve a bogie rather than a wheelset.
    pub by_bogie: bool,
}

/// Protection at work.
#[derive(Debug, Clone)]
pub(crate) struct Protection {
    plan: ProtectionPlan,
    reference_m_s: f64,
    before_m_s: PerWheelset,
    vented_s: PerWheelset,
    pub(crate) valve: [Valve; 4],
}

impl Protection {
    pub(crate) fn new(plan: ProtectionPlan) -> Self {
        Self { plan, reference_m_s: 0.0, before_m_s: [0.0; 4], vented_s: [0.0; 4], valve: [Valve::Fill; 4] }
    }

    /// Decides the valves from rim speeds and the speed on the bus, m/s; a wheelset without a reading (NaN) is left alone.
    pub(crate) fn decide(&mut self, rim_m_s: &[f64], bus_m_s: f64, braking: bool, step_s: f64) {
        let fastest = rim_m_s.iter().copied().fold(0.0, f64::max);
        self.reference_m_s = fastest.max(BUS_SHARE * bus_m_s);
        let active = braking && self.reference_m_s > RESTS_BELOW_M_S;
        for (k, rim) in rim_m_s.iter().copied().enumerate() {
            let speeding_up = rim > self.before_m_s[k] + 0.2 * step_s;
            self.before_m_s[k] = rim;
            self.valve[k] = if active && rim.is_finite() {
                self.next(k, self.reference_m_s - rim, speeding_up)
            } else {
                Valve::Fill
            };
            let venting = self.valve[k] == Valve::Vent;
            self.vented_s[k] = if venting { self.vented_s[k] + step_s } else { 0.0 };
        }
        if self.plan.by_bogie {
            self.tie_bogies(rim_m_s.len());
        }
    }

    fn next(&self, k: usize, slide_m_s: f64, speeding_up: bool) -> Valve {
        let vent_m_s = self.plan.vent_m_s.max(self.plan.vent_share * self.reference_m_s);
        match self.valve[k] {
            Valve::Vent if self.vented_s[k] > LONGEST_VENT_S => Valve::Fill,
            Valve::Fill | Valve::Hold if slide_m_s > vent_m_s && !speeding_up => Valve::Vent,
            Valve::Vent if speeding_up => Valve::Hold,
            Valve::Vent | Valve::Hold if slide_m_s < 0.4 * vent_m_s => Valve::Fill,
            valve => valve,
        }
    }

    /// The wheelset that slides more rules the bogie.
    fn tie_bogies(&mut self, wheelsets: usize) {
        for first in (0..wheelsets.saturating_sub(1)).step_by(2) {
            let pair = [self.valve[first], self.valve[first + 1]];
            let both = if pair.contains(&Valve::Vent) {
                Valve::Vent
            } else if pair.contains(&Valve::Hold) {
                Valve::Hold
            } else {
                Valve::Fill
            };
            self.valve[first..first + 2].fill(both);
        }
    }

    /// Whether any valve is at work.
    pub(crate) fn active(&self) -> bool {
        self.valve.iter().any(|valve| *valve != Valve::Fill)
    }
}
