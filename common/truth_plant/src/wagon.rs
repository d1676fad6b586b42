//! The wagon as it really is: the data sheet with the tolerances of manufacture, load and weather on it, and the contact
//! law of its wheels.

use std::f64::consts::PI;

use crate::{
    random::Stream,
    sheet::{Rail, Sheet},
};

/// The real parameters of one wagon. Index 0 is the leading wheelset.
#[derive(Debug, Clone, PartialEq)]
pub struct TrueWagon {
    /// Mass that is accelerated, kg.
    pub mass_kg: f64,
    /// Height of the centre of mass over the wheelbase.
    pub height_over_wheelbase: f64,
    /// Distance of the wheelsets, m.
    pub wheelbase_m: f64,
    /// Rolling radius of each wheelset, m.
    pub radius_m: [f64; 2],
    /// Inertia that turns with the wheel, kg m².
    pub inertia_kg_m2: [f64; 2],
    /// Effective disc radius, m.
    pub brake_radius_m: f64,
    /// Level of pad friction of each wheelset.
    pub pad_friction: [f64; 2],
    /// Constant, linear and quadratic running resistance (N, N s/m, N s²/m²).
    pub resistance: [f64; 3],
    /// Contact stiffness, N.
    pub stiffness_n: f64,
    /// Polach's reduction factors of adhesion and slip area.
    pub reduction: [f64; 2],
    /// Peak adhesion of dry, wet and low rail.
    pub rail: [f64; 3],
}

/// Relative tolerances that every real wagon has; none of them is an effect.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Nuisances {
    /// Pad friction level of each wheelset.
    pub pad: [f64; 2],
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
}

impl Nuisances {
    /// Draws them uniformly over their whole range.
    #[must_use]
    pub fn draw(stream: &mut Stream) -> Self {
        let mut within = |bound: f64| stream.uniform(-bound, bound);
        Self {
            pad: [within(0.15), within(0.15)],
            rail: [within(0.15), within(0.15), within(0.15)],
            constant: within(0.10),
            drag: within(0.10),
            mass: within(0.015),
            inertia: within(0.03),
        }
    }
}

impl TrueWagon {
    /// The wagon of a data sheet with these tolerances.
    #[must_use]
    pub fn new(sheet: &Sheet, nuisances: &Nuisances) -> Self {
        Self {
            mass_kg: sheet.mass_kg * (1.0 + nuisances.mass),
            height_over_wheelbase: sheet.com_height_m / sheet.wheelbase_m,
            wheelbase_m: sheet.wheelbase_m,
            radius_m: [sheet.radius_m; 2],
            inertia_kg_m2: [sheet.inertia_kg_m2 * (1.0 + nuisances.inertia); 2],
            brake_radius_m: sheet.brake_radius_m,
            pad_friction: nuisances.pad.map(|error| sheet.pad_friction * (1.0 + error)),
            resistance: [
                sheet.constant_n * (1.0 + nuisances.constant),
                sheet.linear_n_s_per_m,
                sheet.drag_n_s2_per_m2 * (1.0 + nuisances.drag),
            ],
            stiffness_n: sheet.stiffness_n,
            reduction: [sheet.k_a, sheet.k_s],
            rail: std::array::from_fn(|k| sheet.rail[k] * (1.0 + nuisances.rail[k])),
        }
    }

    /// Peak adhesion of a rail class.
    #[must_use]
    pub fn rail_friction(&self, rail: Rail) -> f64 {
        self.rail[rail as usize]
    }

    /// Contact force of one wheel pair (forward positive, N) and its slope with creepage (N), after Polach (2005), eq. 5
    /// with the tangential stress gradient of pure longitudinal creep.
    #[must_use]
    pub fn creep_force(&self, creepage: f64, load_n: f64, friction: f64) -> (f64, f64) {
        let limit_n = load_n * friction;
        if limit_n <= 0.0 {
            return (0.0, 0.0);
        }
        let [k_a, k_s] = self.reduction;
        let gradient = self.stiffness_n / limit_n;
        let stress = gradient * creepage;
        let (a, s) = (k_a * stress, k_s * stress);
        let area = 1.0 + a * a;
        let force = 2.0 * limit_n / PI * (a / area + s.atan());
        let slope =
            2.0 * limit_n / PI * gradient * (k_a * (1.0 - a * a) / (area * area) + k_s / (1.0 + s * s));
        (force, slope)
    }
}
