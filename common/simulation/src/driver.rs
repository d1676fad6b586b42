//! The driver's programme: what is asked for at which time, and at which speed.

use crate::scenario::{DemandTable, Scenario};

/// What one wagon is asked for at an instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Demand {
    /// Share of full traction, 0 to 1.
    pub traction: f64,
    /// Share of full service braking, 0 to 1.
    pub brake: f64,
    /// Sanding, 0 to 1.
    pub sanding: f64,
}

/// Share of traction a metre per second below the cruising speed.
const CRUISE_GAIN_S_PER_M: f64 = 1.0;
/// Overspeed at which cruising begins to brake.
const CRUISE_MARGIN_M_S: f64 = 0.8;
/// Share of braking a metre per second beyond that margin, and its limit.
const CRUISE_BRAKE_S_PER_M: f64 = 0.15;
const CRUISE_BRAKE_LIMIT: f64 = 0.4;

/// The phases of a scenario in the order of time.
#[derive(Clone, Debug)]
pub(crate) struct Programme {
    phases: Vec<DemandTable>,
    repeat_s: Option<f64>,
}

impl Programme {
    pub fn new(scenario: &Scenario) -> Self {
        Self { phases: scenario.demand.clone(), repeat_s: scenario.repeat_s }
    }

    /// Time within the programme at train time `t_s`; what reaches a wagon late is still the first phase at the very start.
    pub fn time_s(&self, t_s: f64) -> f64 {
        match self.repeat_s {
            Some(repeat_s) if t_s >= 0.0 => t_s % repeat_s,
            _ => t_s.max(0.0),
        }
    }

    /// Demand at train time `t_s` on a wagon of speed `v_m_s`.
    pub fn demand(&self, t_s: f64, v_m_s: f64) -> Demand {
        let time_s = self.time_s(t_s);
        let after = self.phases.partition_point(|phase| phase.from_s <= time_s);
        let Some(phase) = self.phases.get(after.saturating_sub(1)) else { return Demand::default() };
        let mut demand = Demand {
            traction: phase.traction.unwrap_or_default(),
            brake: phase.brake.unwrap_or_default(),
            sanding: phase.sanding,
        };
        if let Some(speed_m_s) = phase.cruise_m_s {
            let missing_m_s = speed_m_s - v_m_s;
            demand.traction = (CRUISE_GAIN_S_PER_M * missing_m_s).clamp(0.0, 1.0);
            let beyond_m_s = -missing_m_s - CRUISE_MARGIN_M_S;
            demand.brake = (CRUISE_BRAKE_S_PER_M * beyond_m_s).clamp(0.0, CRUISE_BRAKE_LIMIT);
        }
        demand
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn programme(repeat_s: Option<f64>) -> Programme {
        let brake = DemandTable { from_s: 0.0, brake: Some(0.5), ..DemandTable::default() };
        let cruise = DemandTable { from_s: 10.0, cruise_m_s: Some(20.0), ..DemandTable::default() };
        Programme { phases: vec![brake, cruise], repeat_s }
    }

    #[test]
    fn phases_follow_time_and_repeat() {
        let once = programme(None);
        assert_eq!((once.demand(-0.3, 0.0).brake, once.demand(9.99, 0.0).brake), (0.5, 0.5));
        assert_eq!(once.demand(10.0, 0.0).traction, 1.0);
        assert_eq!(once.demand(99.0, 0.0).traction, 1.0);
        let again = programme(Some(20.0));
        assert_eq!((again.demand(20.0, 0.0).brake, again.demand(35.0, 0.0).traction), (0.5, 1.0));
    }

    #[test]
    fn cruising_pulls_below_and_brakes_above() {
        let programme = programme(None);
        let at = |v_m_s| programme.demand(12.0, v_m_s);
        assert_eq!((at(20.0).traction, at(20.0).brake), (0.0, 0.0));
        assert!(at(19.5).traction == 0.5 && at(19.5).brake == 0.0);
        assert!(at(22.0).brake > 0.1 && at(22.0).traction == 0.0);
    }
}
