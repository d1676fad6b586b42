//! Hydraulic caliper brakes: one linear actuator on a master cylinder feeds the calipers of both wheelsets.

use super::BOGIE_WHEELSETS;
use std::f64::consts::PI;

/// Constants of the brakes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrakeParameters {
    /// Diameter of a caliper's piston, m.
    pub piston_diameter_m: f64,
    /// Discs, and calipers, of a wheelset.
    pub discs: f64,
    /// Radius at which the pads rub, m.
    pub friction_radius_m: f64,
    /// Pad friction of each wheelset.
    pub pad_friction: [f64; BOGIE_WHEELSETS],
    /// Time in which pressure follows its command, s.
    pub lag_s: f64,
    /// Fastest change of pressure, Pa/s.
    pub rate_limit_pa_s: f64,
    /// Largest pressure, Pa.
    pub pressure_limit_pa: f64,
}

impl Default for BrakeParameters {
    /// From the paper: two discs of 130 mm a wheelset, single pistons of 45 mm. Chosen: pads at 45 mm (disc radius less
    /// half a piston), organic pads of 0.40 with the second wheelset 3 % lower, an actuator of 40 ms and 12 MPa/s.
    fn default() -> Self {
        Self {
            piston_diameter_m: 0.045,
            discs: 2.0,
            friction_radius_m: 0.045,
            pad_friction: [0.40, 0.388],
            lag_s: 0.04,
            rate_limit_pa_s: 12e6,
            pressure_limit_pa: 3e6,
        }
    }
}

impl BrakeParameters {
    /// Brake torque of a wheelset per pressure and pad friction, N m/Pa: a floating caliper presses both faces of its disc.
    pub fn torque_per_pressure_nm_pa(&self) -> f64 {
        let piston = 0.25 * PI * self.piston_diameter_m * self.piston_diameter_m;
        self.discs * 2.0 * piston * self.friction_radius_m
    }

    /// Largest torque that each wheelset's pads can hold at a pressure, N m.
    pub fn torque_nm(&self, pressure_pa: f64) -> [f64; BOGIE_WHEELSETS] {
        self.pad_friction.map(|friction| friction * pressure_pa * self.torque_per_pressure_nm_pa())
    }

    /// Pressure at which pads of the first wheelset's friction hold a torque, Pa.
    pub fn pressure_pa(&self, torque_nm: f64) -> f64 {
        torque_nm / (self.pad_friction[0] * self.torque_per_pressure_nm_pa())
    }
}

/// The brakes in motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HydraulicBrake {
    parameters: BrakeParameters,
    /// Pressure at the calipers, Pa.
    pub pressure_pa: f64,
}

impl HydraulicBrake {
    /// Released brakes.
    pub fn released(parameters: BrakeParameters) -> Self {
        Self { parameters, pressure_pa: 0.0 }
    }

    /// Brake torques over the next `dt_s` under a pressure command, N m.
    #[inline]
    pub fn step(&mut self, command_pa: f64, dt_s: f64) -> [f64; BOGIE_WHEELSETS] {
        let p = &self.parameters;
        let wanted = command_pa.clamp(0.0, p.pressure_limit_pa);
        let rate = ((wanted - self.pressure_pa) / p.lag_s).clamp(-p.rate_limit_pa_s, p.rate_limit_pa_s);
        let share = dt_s.min(p.lag_s);
        self.pressure_pa = (self.pressure_pa + rate * share).max(0.0);
        p.torque_nm(self.pressure_pa)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calipers_of_the_papers_size_lock_a_dry_wheelset_at_a_common_pressure() {
        let brake = BrakeParameters::default();
        let pressure = brake.pressure_pa(0.45 * 4060.0 * 0.1);
        println!("0.45 of 4060 N at 0.1 m needs {:.2} MPa", pressure * 1e-6);
        assert!((0.5e6..brake.pressure_limit_pa).contains(&pressure));
        assert!((brake.torque_nm(pressure)[0] - 182.7).abs() < 0.1);
    }

    #[test]
    fn pressure_follows_within_its_limits() {
        let mut brake = HydraulicBrake::released(BrakeParameters::default());
        for _ in 0..100 {
            brake.step(2e6, 1e-3);
        }
        println!("100 ms after a command of 2 MPa: {:.3} MPa", brake.pressure_pa * 1e-6);
        assert!((0.9e6..1.3e6).contains(&brake.pressure_pa));
        for _ in 0..1000 {
            brake.step(-1.0, 1e-3);
        }
        assert!(brake.pressure_pa < 1.0);
    }
}
