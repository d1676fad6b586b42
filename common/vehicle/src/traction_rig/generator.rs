//! Permanent-magnet DC generator with a load resistance: Zhao et al. (3-13) to (3-15).

use serde::{Deserialize, Serialize};

/// A generator on its belt, with what is connected to it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Generator {
    /// Magnetic constant k_φ, V s/rad (= N m/A).
    pub constant_v_s_per_rad: f64,
    /// Armature resistance R_a, Ω.
    pub armature_resistance_ohm: f64,
    /// Speed of the generator over that of the roller.
    pub belt_ratio: f64,
    /// Load resistance R_L, Ω; infinite: not connected.
    pub load_resistance_ohm: f64,
}

impl Generator {
    /// Armature current I_a at a roller speed, A.
    #[inline]
    pub fn current_a(&self, roller_speed_rad_s: f64) -> f64 {
        let voltage = self.constant_v_s_per_rad * self.belt_ratio * roller_speed_rad_s;
        voltage / (self.armature_resistance_ohm + self.load_resistance_ohm)
    }

    /// T_load / ω_roller, N m s/rad: belt ratio² k_φ² / (R_a + R_L).
    #[inline]
    pub fn load_coefficient_nm_s(&self) -> f64 {
        let constant = self.constant_v_s_per_rad * self.belt_ratio;
        constant * constant / (self.armature_resistance_ohm + self.load_resistance_ohm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn takes_from_the_shaft_what_the_circuit_burns() {
        let mut generator = Generator {
            constant_v_s_per_rad: 0.25,
            armature_resistance_ohm: 0.5,
            belt_ratio: 17.64,
            load_resistance_ohm: 1.5,
        };
        let speed = 4.0;
        let current = generator.current_a(speed);
        let shaft = generator.load_coefficient_nm_s() * speed * speed;
        assert!((shaft - current * current * 2.0).abs() < 1e-9);
        generator.load_resistance_ohm = f64::INFINITY;
        assert_eq!((generator.current_a(speed), generator.load_coefficient_nm_s()), (0.0, 0.0));
    }
}
