//! The air of one wagon: a command travels along the train, the distributor fills the supply, valves of the wheel-slide
//! protection pass it on to the cylinders.

use crate::scenario::{BrakeTable, WspTable};
use crate::wsp::Valve;
use railgrip_vehicle::brake::{BrakeCylinder, pressing_force_for_n};
use railgrip_vehicle::{PerWheelset, VehicleParameters};

/// Pressing force of one wheelset, N, that gives the deceleration of full service braking with nominal pads:
/// `F = m a r_W / (n μ_B r_B)`, level, without running resistance and without the wheelsets' inertia.
pub(crate) fn full_pressing_force_n(vehicle: &VehicleParameters, deceleration_m_s2: f64) -> f64 {
    let force_n = vehicle.body.mass_kg * deceleration_m_s2 / vehicle.wheelsets() as f64;
    let brake = &vehicle.brake;
    pressing_force_for_n(force_n, vehicle.wheelset.radius_m, brake.friction_coefficient, brake.radius_m)
}

/// Supply and cylinders of one wagon.
#[derive(Clone, Debug)]
pub(crate) struct Pneumatics {
    supply: BrakeCylinder,
    chamber: BrakeCylinder,
    supply_pressure_pa: f64,
    cylinder_pressure_pa: PerWheelset,
    isolated: [bool; railgrip_vehicle::MAX_WHEELSETS],
    /// Delay from the driver's handle to this wagon's distributor, s.
    pub delay_s: f64,
}

impl Pneumatics {
    /// `isolated` names wheelsets, from 1, whose cylinders get no air.
    pub fn new(
        brake: &BrakeTable,
        wsp: &WspTable,
        full_pressing_force_n: f64,
        distance_m: f64,
        isolated: &[usize],
    ) -> Self {
        let supply = BrakeCylinder {
            fill_time_s: brake.fill_time_s,
            vent_time_s: brake.vent_time_s,
            full_pressure_pa: brake.full_pressure_pa,
            full_pressing_force_n,
            spring_pressure_pa: brake.spring_pressure_pa,
        };
        let chamber = BrakeCylinder {
            fill_time_s: wsp.valve_fill_time_s,
            vent_time_s: wsp.valve_vent_time_s,
            ..supply
        };
        Self {
            supply,
            chamber,
            supply_pressure_pa: 0.0,
            cylinder_pressure_pa: [0.0; railgrip_vehicle::MAX_WHEELSETS],
            isolated: std::array::from_fn(|index| isolated.contains(&(index + 1))),
            delay_s: brake.dead_time_s + distance_m / brake.propagation_speed_m_s,
        }
    }

    /// Advances by `dt_s` under a share of full braking, with the valves as given.
    pub fn step(&mut self, brake_share: f64, valves: &[Valve], dt_s: f64) {
        let demand_pa = brake_share * self.supply.full_pressure_pa;
        self.supply_pressure_pa = self.supply.step(self.supply_pressure_pa, demand_pa, dt_s);
        for ((pressure_pa, valve), isolated) in
            self.cylinder_pressure_pa.iter_mut().zip(valves).zip(self.isolated)
        {
            let target_pa = match valve {
                _ if isolated => 0.0,
                Valve::Apply => self.supply_pressure_pa,
                // Air can always flow back when the driver releases.
                Valve::Hold => self.supply_pressure_pa.min(*pressure_pa),
                Valve::Vent => 0.0,
            };
            *pressure_pa = self.chamber.step(*pressure_pa, target_pa, dt_s);
        }
    }

    /// Pressing force of a wheelset, N.
    pub fn pressing_force_n(&self, wheelset: usize) -> f64 {
        self.chamber.pressing_force_n(self.cylinder_pressure_pa[wheelset])
    }

    /// Supply pressure as a share of full service braking.
    pub fn supply_share(&self) -> f64 {
        self.supply_pressure_pa / self.supply.full_pressure_pa
    }

    /// Share of the supply's pressure that a cylinder has.
    pub fn filled(&self, wheelset: usize) -> f64 {
        if self.supply_pressure_pa > 0.0 {
            self.cylinder_pressure_pa[wheelset] / self.supply_pressure_pa
        } else {
            1.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fills_holds_vents_and_releases() {
        let (brake, wsp) = (BrakeTable::default(), WspTable::default());
        let mut air = Pneumatics::new(&brake, &wsp, 5e4, 280.0, &[]);
        assert!((air.delay_s - 1.25).abs() < 1e-12);
        let run = |air: &mut Pneumatics, share, valve, seconds: usize| {
            (0..1000 * seconds).for_each(|_| air.step(share, &[valve, Valve::Apply], 1e-3));
            (air.pressing_force_n(0), air.pressing_force_n(1))
        };
        let (front, rear) = run(&mut air, 1.0, Valve::Apply, 10);
        assert!((front / 5e4 - 1.0).abs() < 0.01 && (rear / 5e4 - 1.0).abs() < 0.01);
        let (front, rear) = run(&mut air, 1.0, Valve::Vent, 1);
        assert!(front == 0.0 && rear > 4.9e4);
        let (front, _) = run(&mut air, 1.0, Valve::Hold, 5);
        assert_eq!(front, 0.0);
        let (front, rear) = run(&mut air, 0.0, Valve::Hold, 20);
        assert!(front == 0.0 && rear == 0.0);
    }
}
