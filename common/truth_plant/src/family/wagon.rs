//! The wagon as it really is: the data sheet with the tolerances of manufacture, load and weather on it.

use super::{creep::CreepLaw, sheet::FamilySheet, units::PerWheelset};
use crate::{
    random::Stream,
    sheet::{GRAVITY_M_S2, Rail},
};

/// Relative tolerances that every real wagon has; none of them is an effect.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize)]
pub struct FamilyNuisances {
    /// Pad friction level of each wheelset.
    pub pad: PerWheelset,
    /// Peak adhesion of dry, wet and low rail.
    pub rail: [f64; 3],
    /// Constant running resistance.
    pub constant: f64,
    /// Drag.
    pub drag: f64,
    /// Mass.
    pub mass: f64,
    /// Wheelset inertia.
    pub inertia: f64,
    /// Contact stiffness.
    pub stiffness: f64,
    /// Softness of the tail of the creep curve.
    pub tail: f64,
}

impl FamilyNuisances {
    /// Draws them uniformly over their whole range.
    #[must_use]
    pub fn draw(stream: &mut Stream, wheelsets: usize) -> Self {
        let mut within = |bound: f64| stream.uniform(-bound, bound);
        let mut drawn = Self {
            rail: [within(0.15), within(0.15), within(0.15)],
            constant: within(0.10),
            drag: within(0.10),
            mass: within(0.015),
            inertia: within(0.03),
            stiffness: within(0.05),
            tail: within(0.05),
            ..Self::default()
        };
        drawn.pad[..wheelsets].fill_with(|| within(0.15));
        drawn
    }
}

/// The real parameters of one wagon.
#[derive(Debug, Clone, PartialEq)]
pub struct FamilyWagon {
    /// Number of wheelsets.
    pub wheelsets: usize,
    /// Mass that is accelerated, kg.
    pub mass_kg: f64,
    /// Height of the centre of mass above the rail, m.
    pub com_height_m: f64,
    /// Place of each wheelset ahead of the middle, m.
    pub positions_m: PerWheelset,
    /// Wheelbase of a bogie and height of its pivot, m.
    pub bogie_m: Option<(f64, f64)>,
    /// Share of the weight that each wheelset carries at rest.
    pub load_share: PerWheelset,
    /// Rolling radius, m.
    pub radius_m: PerWheelset,
    /// Inertia that turns with the wheel, kg m².
    pub inertia_kg_m2: PerWheelset,
    /// Effective disc radius, m.
    pub brake_radius_m: f64,
    /// Level of pad friction of each wheelset.
    pub pad_friction: PerWheelset,
    /// Constant, linear and quadratic running resistance (N, N s/m, N s²/m²).
    pub resistance: [f64; 3],
    /// Contact stiffness, N.
    pub stiffness_n: f64,
    /// Softness of the tail of the creep curve, over that of the sheet.
    pub tail: f64,
    /// How the contact saturates.
    pub law: CreepLaw,
    /// Peak adhesion of dry, wet and low rail.
    pub rail: [f64; 3],
}

impl FamilyWagon {
    /// The wagon of a data sheet with these tolerances and this contact.
    #[must_use]
    pub fn new(sheet: &FamilySheet, nuisances: &FamilyNuisances, law: CreepLaw) -> Self {
        let [constant, linear, drag] = sheet.resistance;
        let count = sheet.wheelsets;
        let each = |value: f64| std::array::from_fn(|k| if k < count { value } else { 0.0 });
        Self {
            wheelsets: count,
            mass_kg: sheet.mass_kg * (1.0 + nuisances.mass),
            com_height_m: sheet.com_height_m,
            positions_m: sheet.positions_m,
            bogie_m: sheet.bogie_m,
            load_share: each(1.0 / count as f64),
            radius_m: each(sheet.radius_m),
            inertia_kg_m2: each(sheet.inertia_kg_m2 * (1.0 + nuisances.inertia)),
            brake_radius_m: sheet.brake_radius_m,
            pad_friction: std::array::from_fn(|k| sheet.pad_friction * (1.0 + nuisances.pad[k])),
            resistance: [constant * (1.0 + nuisances.constant), linear, drag * (1.0 + nuisances.drag)],
            stiffness_n: sheet.stiffness_n * (1.0 + nuisances.stiffness),
            tail: 1.0 + nuisances.tail,
            law,
            rail: std::array::from_fn(|k| sheet.rail[k] * (1.0 + nuisances.rail[k])),
        }
    }

    /// Peak adhesion of a rail class.
    #[must_use]
    pub fn rail_friction(&self, rail: Rail) -> f64 {
        self.rail[rail as usize]
    }

    /// Load of each wheelset (N, never below a twentieth of its share) at an acceleration, by the moments of inertia forces
    /// about the rail: on two wheelsets directly; with bogies the body about its pivots and every bogie about its middle.
    #[must_use]
    pub fn loads_n(&self, mass_kg: f64, acceleration_m_s2: f64, factor: f64) -> PerWheelset {
        let weight_n = mass_kg * GRAVITY_M_S2;
        let inertia_n = factor * mass_kg * acceleration_m_s2;
        let lift_n: PerWheelset = match self.bogie_m {
            None => {
                let span_m = self.positions_m[0] - self.positions_m[1];
                let moved = inertia_n * self.com_height_m / span_m;
                [-moved, moved, 0.0, 0.0]
            }
            Some((wheelbase_m, pivot_height_m)) => {
                let pivots_m =
                    (self.positions_m[0] + self.positions_m[1]) - (self.positions_m[2] + self.positions_m[3]);
                // Half of what moves between the pivots goes to each wheelset of a bogie.
                let body = inertia_n * (self.com_height_m - pivot_height_m) / pivots_m;
                let bogie = 0.5 * inertia_n * pivot_height_m / wheelbase_m;
                [-body - bogie, -body + bogie, body - bogie, body + bogie]
            }
        };
        std::array::from_fn(|k| {
            (weight_n * self.load_share[k] + lift_n[k]).max(0.05 * weight_n * self.load_share[k])
        })
    }
}
