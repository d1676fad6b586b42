//! Traction of one wagon: the same effort on every wheelset, taken back where a wheelset spins.

use crate::scenario::TractionTable;
use railgrip_vehicle::{MAX_WHEELSETS, PerWheelset};

/// Spin of a rim, relative and at least, from which effort is taken back.
const SPIN_SHARE: f64 = 0.03;
const SPIN_M_S: f64 = 0.3;
/// Rates at which effort is taken back and returned, 1/s.
const SPIN_CUT_PER_S: f64 = 4.0;
const SPIN_RETURN_PER_S: f64 = 0.4;

/// Traction of one wagon.
#[derive(Clone, Debug)]
pub(crate) struct Traction {
    table: TractionTable,
    /// Torque of one wheelset at full effort, N m.
    full_torque_nm: f64,
    torque_nm: f64,
    share: PerWheelset,
}

impl Traction {
    /// Traction that gives `mass_kg` the table's acceleration through so many wheels of this radius.
    pub fn new(table: &TractionTable, mass_kg: f64, wheel_radius_m: f64, wheelsets: usize) -> Self {
        let full_torque_nm = mass_kg * table.acceleration_m_s2 * wheel_radius_m / wheelsets as f64;
        Self { table: table.clone(), full_torque_nm, torque_nm: 0.0, share: [1.0; MAX_WHEELSETS] }
    }

    /// Advances by `dt_s` towards a demanded share of full effort at this vehicle speed: constant effort, then constant power.
    pub fn step(&mut self, demand: f64, v_m_s: f64, dt_s: f64) {
        let power_share = (self.table.full_power_speed_m_s / v_m_s.max(0.1)).min(1.0);
        let wanted_nm = self.full_torque_nm * power_share * demand;
        self.torque_nm += (wanted_nm - self.torque_nm) * dt_s / (self.table.response_time_s + dt_s);
    }

    /// Spin protection of one wheelset over a control period.
    pub fn control(&mut self, wheelset: usize, v_m_s: f64, rim_m_s: f64, period_s: f64) {
        let spins = rim_m_s - v_m_s > (SPIN_SHARE * v_m_s).max(SPIN_M_S);
        let rate_per_s =
            if self.table.spin_protection && spins { -SPIN_CUT_PER_S } else { SPIN_RETURN_PER_S };
        self.share[wheelset] = (self.share[wheelset] + rate_per_s * period_s).clamp(0.0, 1.0);
    }

    /// Torque on a wheelset, N m.
    pub fn torque_nm(&self, wheelset: usize) -> f64 {
        self.torque_nm * self.share[wheelset]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn effort_is_constant_then_power_and_spin_takes_it_back() {
        let mut traction = Traction::new(&TractionTable::default(), 4e4, 0.45, 2);
        let run = |traction: &mut Traction, v_m_s| (0..5000).for_each(|_| traction.step(1.0, v_m_s, 1e-3));
        run(&mut traction, 10.0);
        assert!((traction.torque_nm(0) / (4e4 * 0.8 * 0.45 / 2.0) - 1.0).abs() < 1e-4);
        run(&mut traction, 32.0);
        assert!((traction.torque_nm(1) / (4e4 * 0.4 * 0.45 / 2.0) - 1.0).abs() < 1e-4);
        (0..100).for_each(|_| traction.control(1, 10.0, 11.0, 5e-3));
        assert!(traction.torque_nm(1) == 0.0 && traction.torque_nm(0) > 0.0);
        (0..1000).for_each(|_| traction.control(1, 10.0, 10.1, 5e-3));
        assert_eq!(traction.torque_nm(1), traction.torque_nm(0));
    }
}
