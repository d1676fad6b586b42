//! What vehicle files say, as the watch over a train takes it.

use railgrip_causes::WagonFile;
use railgrip_vehicle::VehicleParameters;

/// Mass is believed to this share where a file says nothing.
const PLATE_SIGMA: f64 = 0.015;

/// What is believed of a wagon, by its vehicle file.
#[must_use]
pub fn believed(vehicle: &VehicleParameters) -> WagonFile {
    let contact = &vehicle.contact;
    // Slope of Polach's law at the origin.
    let slope_n = 2.0 / std::f64::consts::PI * (contact.k_a + contact.k_s) * contact.stiffness_n;
    WagonFile {
        wheelsets: vehicle.wheelsets(),
        mass_kg: vehicle.body.mass_kg,
        mass_sigma: vehicle.body.mass_sigma.unwrap_or(PLATE_SIGMA),
        radius_m: vehicle.wheelset.radius_m,
        inertia_kg_m2: vehicle.wheelset.inertia_kg_m2,
        pad_radius_m: vehicle.brake.radius_m,
        pad_friction: vehicle.brake.friction_coefficient,
        compliance_per_n: 1.0 / slope_n,
        resistance: [
            vehicle.resistance.constant_n,
            vehicle.resistance.linear_n_s_per_m,
            vehicle.resistance.drag_n_s2_per_m2,
        ],
        speed_sigma_m_s: vehicle.sensors.speed_sigma_m_s,
        wheel_speed_sigma_rad_s: vehicle.sensors.wheel_speed_sigma_rad_s,
    }
}
