//! Wheel-slide protection of the rig, small and coarse like an early one.

use super::programme::{Programme, SAMPLE_PERIOD_S};

/// Slide protection of the rig: vents when slip is large and still grows, holds when it is moderate, gives pressure
/// back in pulses.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SlideProtection {
    last_rim_m_s: f64,
    rim_acceleration_m_s2: f64,
    since_pulse_s: f64,
    acting: bool,
}

/// What its valve does.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Valve {
    /// Cylinder follows the demand.
    Apply,
    /// Cylinder keeps its pressure.
    Hold,
    /// Cylinder is emptied.
    Vent,
}

impl SlideProtection {
    /// A protection at rest.
    pub fn new(rim_m_s: f64) -> Self {
        Self { last_rim_m_s: rim_m_s, ..Self::default() }
    }

    /// True while it holds pressure back.
    pub fn acting(&self) -> bool {
        self.acting
    }

    /// One control period; `filled` is the share of the demanded pressure in the cylinder.
    pub fn control(&mut self, programme: &Programme, v_m_s: f64, rim_m_s: f64, filled: f64) -> Valve {
        let raw = (rim_m_s - self.last_rim_m_s) / SAMPLE_PERIOD_S;
        self.last_rim_m_s = rim_m_s;
        self.rim_acceleration_m_s2 += 0.2 * (raw - self.rim_acceleration_m_s2);
        self.since_pulse_s += SAMPLE_PERIOD_S;
        if v_m_s < 1.5 {
            self.acting = false;
            return Valve::Apply;
        }
        let slip = (v_m_s - rim_m_s) / v_m_s;
        if slip > programme.vent_slip && self.rim_acceleration_m_s2 < 0.5 {
            self.acting = true;
            return Valve::Vent;
        }
        if slip > programme.hold_slip {
            self.acting = true;
            return Valve::Hold;
        }
        if !self.acting {
            return Valve::Apply;
        }
        self.acting = filled < 0.95;
        let (pulse_s, pause_s) = programme.pulse_s;
        self.since_pulse_s %= pulse_s + pause_s;
        if self.since_pulse_s < pulse_s { Valve::Apply } else { Valve::Hold }
    }
}
