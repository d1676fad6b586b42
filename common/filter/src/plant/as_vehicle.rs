//! A rig with one wheelset as a wagon, for what asks about wagons.

use railgrip_vehicle::{Body, Brake, Contact, Rail, Resistance, Sensors, VehicleParameters, Wheelset};

/// Adhesion available by class where a rig's file says nothing.
pub(super) fn usual_rail() -> Rail {
    Rail { dry: 0.3, wet: 0.12, low: 0.06 }
}

/// A wagon with one wheelset, without resistance and effects.
pub(super) fn one_wheelset(
    name: &str,
    mass_kg: f64,
    wheelset: Wheelset,
    brake: Brake,
    contact: &Contact,
    rail: Rail,
    sensors: Sensors,
) -> VehicleParameters {
    VehicleParameters {
        schema: 1,
        name: name.into(),
        body: Body {
            mass_kg,
            com_height_m: 0.0,
            wheelbase_m: 1.0,
            wheelset_positions_m: Some(vec![0.0]),
            mass_sigma: None,
        },
        wheelset,
        brake,
        resistance: Resistance { constant_n: 0.0, linear_n_s_per_m: 0.0, drag_n_s2_per_m2: 0.0 },
        contact: contact.clone(),
        rail,
        sensors,
        bogie: None,
        train: None,
        effects: Vec::new(),
    }
}
