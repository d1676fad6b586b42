//! Constants of the rig. The paper gives geometry and ratios of the belt; the rest is chosen, each with its reason.

use super::{Generator, MotorParameters};
use crate::Contact;
use serde::{Deserialize, Serialize};

/// What lies between wheel and roller.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Surface {
    /// Clean and dry.
    Base,
    /// Water.
    Water,
    /// Oil.
    Oil,
}

impl Surface {
    /// All, in the paper's order.
    pub const ALL: [Self; 3] = [Self::Base, Self::Water, Self::Oil];

    /// Name for people and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Base => "base",
            Self::Water => "water",
            Self::Oil => "oil",
        }
    }

    /// Friction coefficient μ0 that the paper identified on this surface.
    pub fn adhesion_peak(self) -> f64 {
        match self {
            Self::Base => 0.28,
            Self::Water => 0.08,
            Self::Oil => 0.04,
        }
    }

    /// Decay B of friction with slip velocity, s/m: Table 1, columns dry, wet and low, with the exchange of rows B
    /// and D undone (the paper prints these numbers in row D).
    pub fn friction_decay_s_per_m(self) -> f64 {
        match self {
            Self::Base => 0.60,
            Self::Water | Self::Oil => 0.20,
        }
    }
}

/// Gear, wheels and rollers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drivetrain {
    /// Transmission ratio i, motor speed over wheel speed.
    pub gear_ratio: f64,
    /// J_motor, kg m².
    pub motor_inertia_kg_m2: f64,
    /// Inertia of the wheelset, kg m².
    pub wheel_inertia_kg_m2: f64,
    /// Inertia of the roller axle with what turns with it, kg m².
    pub roller_inertia_kg_m2: f64,
    /// R_wheel, m.
    pub wheel_radius_m: f64,
    /// R_roller, m.
    pub roller_radius_m: f64,
    /// Normal force of one wheel F_N, N.
    pub normal_load_n: f64,
}

impl Drivetrain {
    /// J_eqv = J_motor + J_wheel / i², kg m².
    #[inline]
    pub fn equivalent_inertia_kg_m2(&self) -> f64 {
        self.motor_inertia_kg_m2 + self.wheel_inertia_kg_m2 / (self.gear_ratio * self.gear_ratio)
    }

    /// Rim speed of the wheel over motor speed, m.
    #[inline]
    pub fn rim_per_motor_m(&self) -> f64 {
        self.wheel_radius_m / self.gear_ratio
    }
}

/// The whole rig. [`Default`] is the paper's, with case 4 on the base surface.
#[derive(Clone, Debug, PartialEq)]
pub struct RigParameters {
    /// Induction motor.
    pub motor: MotorParameters,
    /// Gear, wheels and rollers.
    pub drivetrain: Drivetrain,
    /// Contact law of one wheel.
    pub contact: Contact,
    /// Generator with its load.
    pub generator: Generator,
}

impl Default for RigParameters {
    fn default() -> Self {
        Self::new(Surface::Base, 0.0)
    }
}

impl RigParameters {
    /// The paper's rig on a surface, with a load resistance (infinite: generator not connected).
    ///
    /// From the paper: wheel and roller diameters 200 and 400 mm, belt ratio 17.64, F_N = 2 kN (section 3.3), k_A, k_S
    /// and falling friction (Table 1). Chosen:
    ///
    /// * Motor: a common 4 kW, 400 V, 50 Hz, 1430 rpm machine with two pole pairs, in the values that simulation
    ///   packages ship as their example; a test checks that they reproduce the nameplate torque. Case 4 on the base
    ///   surface asks for 34 N m, 1.3 times rated, for 5 s at a time.
    /// * Gear ratio 3: puts (5-5) at 0.67 and 1.0 m/s.
    /// * Inertias: solid steel wheels and rollers of those diameters, 20 and 60 mm wide, with axles; a generator
    ///   rotor of 4e-3 kg m² behind the belt.
    /// * Creep stiffness G π a b C11 / 4 = 8.08e10 · π · (0.94 mm)² · 4.2 / 4: Hertz for 2 kN on R = 0.1 and 0.2 m with a
    ///   lateral radius of 60 mm (1/5 of the 300 mm rail head), nearly circular; C11 of Kalker for a/b = 1.
    /// * k_φ and R_a: from the paper's own pattern of which cases slip. Full slip on water at 1 Ω but not at 1.5 Ω,
    ///   on oil at 1.5 Ω but not at 3 Ω, and large creepage on base at 0 Ω leave R_a < 1 Ω and with 0.5 Ω a demand of
    ///   F/F_N = 0.13/(R_a + R_L) at 30 rad/s.
    pub fn new(surface: Surface, load_resistance_ohm: f64) -> Self {
        Self {
            motor: MotorParameters {
                stator_resistance_ohm: 1.405,
                rotor_resistance_ohm: 1.395,
                stator_inductance_h: 0.005_839 + 0.172_2,
                rotor_inductance_h: 0.005_839 + 0.172_2,
                mutual_inductance_h: 0.172_2,
                pole_pairs: 2.0,
            },
            drivetrain: Drivetrain {
                gear_ratio: 3.0,
                motor_inertia_kg_m2: 0.0131,
                wheel_inertia_kg_m2: 0.10,
                roller_inertia_kg_m2: 4.0,
                wheel_radius_m: 0.1,
                roller_radius_m: 0.2,
                normal_load_n: 2000.0,
            },
            contact: Contact {
                stiffness_n: 2.35e5,
                k_a: 1.0,
                k_s: 0.4,
                friction_ratio: 0.40,
                friction_decay_s_per_m: surface.friction_decay_s_per_m(),
            },
            generator: Generator {
                constant_v_s_per_rad: 0.258,
                armature_resistance_ohm: 0.5,
                belt_ratio: 17.64,
                load_resistance_ohm,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adhesion::friction;

    #[test]
    fn erratum_6_friction_falls_to_two_fifths_on_every_surface() {
        for surface in Surface::ALL {
            let contact = RigParameters::new(surface, 1.0).contact;
            let peak = surface.adhesion_peak();
            let (far, _) = friction(&contact, peak, 1e3);
            assert!((far / peak - 0.40).abs() < 1e-12, "{surface:?}");
            // At 1 m/s of slip velocity the dry surface has lost more of its friction than the wet one.
            let (near, _) = friction(&contact, peak, 1.0);
            let expected = 0.6 * (-surface.friction_decay_s_per_m()).exp() + 0.4;
            assert!((near / peak - expected).abs() < 1e-12);
        }
        assert!(Surface::Base.friction_decay_s_per_m() > Surface::Water.friction_decay_s_per_m());
    }
}
