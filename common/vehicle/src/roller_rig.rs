//! Roller rig with one wheelset (Schwarz & Keck, section 3): the roller stands for the wagon.
//!
//! ```text
//! J ω̇ = M_W − T_B sign(ω) − r_W F_x
//! m v̇ = F_x + F_roller ,  v = ω_roller r_roller ,  m = J_roller / r_roller²
//! ```
//!
//! These are the wagon's equations with one wheelset, a load that acceleration does not change, and no resistance
//! but what the roller's drive imitates (the `body_force_n` of [`crate::WagonInput`]), so the rig *is* a
//! [`WagonModel`] and shares its integrator and its effects.

use crate::{Constants, Contact, MAX_WHEELSETS, Resistance, WagonModel};

/// Constants of a rig.
#[derive(Clone, Debug, PartialEq)]
pub struct RigParameters {
    /// Rolling radius of the wheelset r_W, m.
    pub wheel_radius_m: f64,
    /// Moment of inertia of the wheelset J, kg m².
    pub inertia_kg_m2: f64,
    /// Friction radius r_B, m.
    pub brake_radius_m: f64,
    /// Pad friction.
    pub brake_friction: f64,
    /// Normal load of the wheelset, N.
    pub load_n: f64,
    /// Mass that roller and its drive represent, kg.
    pub equivalent_mass_kg: f64,
    /// Contact law.
    pub contact: Contact,
}

impl RigParameters {
    /// The rig's model; its state's `v_m_s` is the circumferential speed of the roller.
    pub fn model(&self) -> WagonModel {
        let constants = Constants {
            wheelsets: 1,
            mass_kg: self.equivalent_mass_kg,
            com_height_m: 0.0,
            wheelset_positions_m: [0.0; MAX_WHEELSETS],
            bogie: None,
            fixed_load_n: Some(self.load_n),
            inertia_kg_m2: [self.inertia_kg_m2; MAX_WHEELSETS],
            wheel_radius_m: [self.wheel_radius_m; MAX_WHEELSETS],
            brake_radius_m: self.brake_radius_m,
            brake_friction: [self.brake_friction; MAX_WHEELSETS],
            resistance: Resistance { constant_n: 0.0, linear_n_s_per_m: 0.0, drag_n_s2_per_m2: 0.0 },
            contact: self.contact.clone(),
        };
        WagonModel::from_constants(constants, Vec::new())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{WagonInput, WagonState};

    #[test]
    fn roller_slows_by_the_contact_force_alone() {
        let contact = Contact {
            stiffness_n: 6e6,
            k_a: 1.0,
            k_s: 0.4,
            friction_ratio: 1.0,
            friction_decay_s_per_m: 0.0,
        };
        let rig = RigParameters {
            wheel_radius_m: 0.46,
            inertia_kg_m2: 110.0,
            brake_radius_m: 0.25,
            brake_friction: 0.35,
            load_n: 6e4,
            equivalent_mass_kg: 6200.0,
            contact,
        };
        let model = rig.model();
        let input = WagonInput {
            pressing_force_n: [4e4, 0.0, 0.0, 0.0],
            adhesion_peak: [0.05; MAX_WHEELSETS],
            ..WagonInput::default()
        };
        let mut state = WagonState { v_m_s: 30.0, wheel_speed_rad_s: [30.0 / 0.46, 0.0, 0.0, 0.0] };
        let loading = model.loading(&model.operating(&state, &input), &input, 0.01, &[]);
        let mut acceleration = 0.0;
        for _ in 0..500 {
            state = model.step(&state, &loading, 0.01, &mut acceleration);
        }
        assert_eq!(state.wheel_speed_rad_s[0], 0.0);
        let limit = 0.05 * 6e4 / 6200.0;
        assert!((-acceleration / limit - 1.0).abs() < 0.01, "{acceleration} {limit}");
        assert_eq!(model.forces(&state, &loading).load_n[0], 6e4);
    }
}
