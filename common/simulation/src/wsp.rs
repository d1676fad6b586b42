//! Wheel-slide protection of one wheelset, after the manner of EN 15595: pressure is vented when the rim slides too far or falls
//! too fast, held while it recovers or slides moderately, and given back in pulses.
//!
//! It sees the rim's and the vehicle's speed as they are: it has sensors of its own, finer than those that are recorded.

use crate::scenario::WspTable;

/// What the valve does between supply and cylinder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Valve {
    /// Cylinder follows the supply.
    #[default]
    Apply,
    /// Cylinder keeps its pressure.
    Hold,
    /// Cylinder is emptied.
    Vent,
}

/// Period of the control, s.
pub(crate) const CONTROL_PERIOD_S: f64 = 5e-3;
/// Time constant of the filter on the rim's acceleration, s.
const ACCELERATION_FILTER_S: f64 = 0.03;
/// Vehicle speed to which the slip thresholds are referred at least, m/s.
const SLIP_REFERENCE_M_S: f64 = 3.0;
/// Rim acceleration above which a wheel recovers by itself, m/s².
const RECOVERING_M_S2: f64 = 0.5;
/// Time without slide, at full pressure, after which the protection is no longer active, s.
const CALM_S: f64 = 0.3;
/// Share of the supply's pressure that counts as full.
const FULL_SHARE: f64 = 0.9;

/// Wheel-slide protection of one wheelset.
#[derive(Clone, Debug)]
pub(crate) struct WheelSlideProtection {
    table: WspTable,
    rim_m_s: f64,
    rim_acceleration_m_s2: f64,
    in_state_s: f64,
    calm_s: f64,
    wanted: Valve,
    pending_s: f64,
    valve: Valve,
    active: bool,
}

impl WheelSlideProtection {
    pub fn new(table: &WspTable, rim_m_s: f64) -> Self {
        Self {
            table: table.clone(),
            rim_m_s,
            rim_acceleration_m_s2: 0.0,
            in_state_s: 0.0,
            calm_s: 0.0,
            wanted: Valve::Apply,
            pending_s: 0.0,
            valve: Valve::Apply,
            active: false,
        }
    }

    /// Where the valve stands.
    pub fn valve(&self) -> Valve {
        self.valve
    }

    /// Whether the protection controls the wheelset.
    pub fn active(&self) -> bool {
        self.active
    }

    /// One control period: vehicle speed, rim speed r ω, and the share of the supply's pressure in the cylinder.
    pub fn control(&mut self, v_m_s: f64, rim_m_s: f64, filled: f64) {
        let raw = (rim_m_s - self.rim_m_s) / CONTROL_PERIOD_S;
        self.rim_m_s = rim_m_s;
        self.rim_acceleration_m_s2 += (raw - self.rim_acceleration_m_s2) * CONTROL_PERIOD_S
            / (ACCELERATION_FILTER_S + CONTROL_PERIOD_S);
        let wanted = if self.table.enabled && v_m_s > self.table.minimum_speed_m_s {
            self.decide(v_m_s, rim_m_s, filled)
        } else {
            self.active = false;
            Valve::Apply
        };
        self.switch(wanted);
    }

    fn decide(&mut self, v_m_s: f64, rim_m_s: f64, filled: f64) -> Valve {
        let slip = (v_m_s - rim_m_s) / v_m_s.max(SLIP_REFERENCE_M_S);
        let falling = self.rim_acceleration_m_s2 < -self.table.rim_deceleration_m_s2;
        let recovering = self.rim_acceleration_m_s2 > RECOVERING_M_S2;
        let sliding = slip > self.table.hold_slip;
        if (slip > self.table.vent_slip && !recovering) || (sliding && falling) {
            self.calm_s = 0.0;
            self.active = true;
            return Valve::Vent;
        }
        if sliding || (falling && slip > 0.4 * self.table.hold_slip) {
            self.calm_s = 0.0;
            self.active = true;
            return Valve::Hold;
        }
        if !self.active {
            return Valve::Apply;
        }
        if filled > FULL_SHARE {
            self.calm_s += CONTROL_PERIOD_S;
            self.active = self.calm_s < CALM_S;
            return Valve::Apply;
        }
        self.pulse()
    }

    /// Gives pressure back in pulses.
    fn pulse(&self) -> Valve {
        let length_s =
            if self.wanted == Valve::Apply { self.table.apply_pulse_s } else { self.table.apply_pause_s };
        let over = self.in_state_s >= length_s - 0.5 * CONTROL_PERIOD_S;
        match (self.wanted, over) {
            (Valve::Apply, false) | (Valve::Hold | Valve::Vent, true) => Valve::Apply,
            (Valve::Apply, true) | (Valve::Hold | Valve::Vent, false) => Valve::Hold,
        }
    }

    /// The valve follows a command after its dead time.
    fn switch(&mut self, wanted: Valve) {
        if wanted == self.wanted {
            self.in_state_s += CONTROL_PERIOD_S;
        } else {
            self.wanted = wanted;
            self.in_state_s = 0.0;
            self.pending_s = self.table.valve_dead_time_s;
        }
        if self.pending_s <= 0.5 * CONTROL_PERIOD_S {
            self.valve = self.wanted;
        } else {
            self.pending_s -= CONTROL_PERIOD_S;
        }
    }
}
