//! What the filters of speeds know of a wagon's physics: the constants of `W` wheelsets, with the laws of
//! `railgrip_vehicle` applied to them.
//!
//! | law | source | stands in |
//! | --- | --- | --- |
//! | loads, exact acceleration at given adhesions | Schwarz & Keck (4), (5) with their errata | `railgrip_vehicle::load` |
//! | running resistance and its slope | Davis | `railgrip_vehicle::resistance` |
//! | creep of rolling, `s = F_x / C` with `C = (2/π)(k_A + k_S) K` | Polach at small creepage | here |
//! | relaxation of rolling, `λ = C r² / (J v)` | (6) linearised about rolling | here |

use railgrip_vehicle::adhesion::initial_creep_slope_n;
use railgrip_vehicle::brake::pressing_force_for_n;
use railgrip_vehicle::load::LoadDistribution;
use railgrip_vehicle::resistance::{running_resistance, running_resistance_slope};
use railgrip_vehicle::{CREEPAGE_SPEED_FLOOR_M_S, MAX_WHEELSETS, Resistance, WagonModel};

/// Pad friction over its nominal value that a belief may reach.
pub(super) const POSSIBLE_PAD_RATIO: std::ops::RangeInclusive<f64> = 0.25..=3.0;
/// Adhesion that no contact transmits.
pub(super) const IMPOSSIBLE_ADHESION: f64 = 0.9;
/// Loads are not taken to fall below this share of the load at rest: equations divide by them.
const LEAST_LOAD_SHARE: f64 = 0.1;

/// Constants of the equations for `W` wheelsets.
#[derive(Clone, Debug)]
pub struct WagonPhysics<const W: usize> {
    /// Mass m, kg.
    pub mass_kg: f64,
    /// Rolling radius of each wheelset, m.
    pub wheel_radius_m: [f64; W],
    /// Moment of inertia of each wheelset, kg m².
    pub inertia_kg_m2: [f64; W],
    /// Friction radius r_B, m.
    pub brake_radius_m: f64,
    /// Nominal pad friction of each wheelset.
    pub brake_friction: [f64; W],
    /// Normal loads and their transfer.
    pub loads: LoadDistribution<W>,
    /// Running resistance.
    pub resistance: Resistance,
    /// Slope of contact force over creepage where creepage is small, N.
    pub creep_slope_n: f64,
}

/// Acceleration of the body and what it depends on.
#[derive(Clone, Copy, Debug)]
pub(super) struct BodyAcceleration {
    /// v̇, m/s².
    pub value: f64,
    /// ∂v̇/∂v, 1/s.
    pub slope: f64,
    /// Mass over which the forces at rest accelerate the wagon, kg: ∂v̇/∂μ_i = F_z,i over it.
    pub mass_kg: f64,
}

impl<const W: usize> WagonPhysics<W> {
    /// The constants of `model`, which must have `W` wheelsets.
    pub fn new(model: &WagonModel) -> Self {
        let constants = model.constants();
        let first = |values: &[f64; MAX_WHEELSETS]| std::array::from_fn(|i| values[i]);
        Self {
            mass_kg: constants.mass_kg,
            wheel_radius_m: first(&constants.wheel_radius_m),
            inertia_kg_m2: first(&constants.inertia_kg_m2),
            brake_radius_m: constants.brake_radius_m,
            brake_friction: first(&constants.brake_friction),
            loads: model.load_distribution().leading(),
            resistance: constants.resistance.clone(),
            creep_slope_n: initial_creep_slope_n(&constants.contact),
        }
    }

    /// Acceleration of the body at these adhesions under `other_force_n` and a headwind. Loads and acceleration are
    /// consistent with each other (no term dropped as in Schwarz & Keck (11)).
    #[inline]
    pub(super) fn acceleration(
        &self,
        v_m_s: f64,
        adhesion: &[f64; W],
        other_force_n: f64,
        wind_m_s: f64,
    ) -> BodyAcceleration {
        let force_n = other_force_n - running_resistance(&self.resistance, v_m_s, wind_m_s);
        let mass_kg = self.loads.answering_mass_kg(self.mass_kg, adhesion);
        BodyAcceleration {
            value: self.loads.acceleration_m_s2(self.mass_kg, adhesion, force_n),
            slope: -running_resistance_slope(&self.resistance, v_m_s, wind_m_s) / mass_kg,
            mass_kg,
        }
    }

    /// Load of each wheelset at an acceleration, N, kept above a tenth of that at rest.
    #[inline]
    pub fn loads_n(&self, acceleration_m_s2: f64) -> [f64; W] {
        std::array::from_fn(|i| {
            let least = LEAST_LOAD_SHARE * self.loads.static_load_n[i];
            self.loads.load_n(i, acceleration_m_s2).max(least)
        })
    }

    /// Rate λ at which creep carries the adhesion of a rolling wheelset to its target, 1/s.
    #[inline]
    pub fn rolling_relaxation_per_s(&self, wheelset: usize, v_m_s: f64) -> f64 {
        let radius = self.wheel_radius_m[wheelset];
        self.creep_slope_n * radius * radius
            / (self.inertia_kg_m2[wheelset] * v_m_s.max(CREEPAGE_SPEED_FLOOR_M_S))
    }

    /// Slip velocity of a rolling wheelset that transmits `force_n`, m/s.
    #[inline]
    pub fn rolling_slip_m_s(&self, force_n: f64, v_m_s: f64) -> f64 {
        v_m_s.max(CREEPAGE_SPEED_FLOOR_M_S) * force_n / self.creep_slope_n
    }

    /// Pressing force at which nominal pads of a wheelset utilise `adhesion` of its load at rest, N. Below that of the
    /// least braking, a sample says nothing about the pads: Schwarz & Keck (17) has no solution for F_⊥ = 0.
    #[inline]
    pub(super) fn pressing_force_for_adhesion_n(&self, wheelset: usize, adhesion: f64) -> f64 {
        pressing_force_for_n(
            adhesion * self.loads.static_load_n[wheelset],
            self.wheel_radius_m[wheelset],
            self.brake_friction[wheelset],
            self.brake_radius_m,
        )
    }
}
