//! What a wagon is by its vehicle file, as far as indicators need it.

use railgrip_messages::GRAVITY_M_S2;

/// What a wagon is by its vehicle file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nominal {
    /// Pad friction.
    pub brake_friction: f64,
    /// Adhesion of dry, wet and low rail.
    pub rail: [f64; 3],
    /// Number of wheelsets.
    pub wheelsets: usize,
    /// Mass of the wagon, kg.
    pub mass_kg: f64,
    /// Rotating inertia of a wheelset, kg m².
    pub inertia_kg_m2: f64,
    /// Radius of the wheels, m.
    pub wheel_radius_m: f64,
    /// Radius at which the pads act, m.
    pub brake_radius_m: f64,
    /// Running resistance: constant N, N s/m, N s²/m².
    pub resistance: [f64; 3],
    /// Other wagons pull and push it.
    pub coupled: bool,
}

impl Nominal {
    /// Weight, N.
    #[must_use]
    pub fn weight_n(&self) -> f64 {
        self.mass_kg * GRAVITY_M_S2
    }

    /// What the inertia of all wheelsets adds to the mass when the wagon rolls, kg: Σ J / r².
    #[must_use]
    pub fn rotating_mass_kg(&self) -> f64 {
        self.wheelsets as f64 * self.inertia_kg_m2 / (self.wheel_radius_m * self.wheel_radius_m)
    }

    /// Running resistance at a speed, N.
    #[must_use]
    pub fn resistance_n(&self, v_m_s: f64) -> f64 {
        let [constant_n, linear, square] = self.resistance;
        constant_n + linear * v_m_s + square * v_m_s * v_m_s
    }
}
