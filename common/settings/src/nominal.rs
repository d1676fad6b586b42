//! What the indicators need of a vehicle file.

use railgrip_indicators::Nominal;
use railgrip_vehicle::VehicleParameters;

/// What a wagon is, as the indicators see it.
#[must_use]
pub fn nominal(vehicle: &VehicleParameters) -> Nominal {
    Nominal {
        brake_friction: vehicle.brake.friction_coefficient,
        rail: [vehicle.rail.dry, vehicle.rail.wet, vehicle.rail.low],
        wheelsets: vehicle.wheelsets(),
        mass_kg: vehicle.body.mass_kg,
        inertia_kg_m2: vehicle.wheelset.inertia_kg_m2,
        wheel_radius_m: vehicle.wheelset.radius_m,
        brake_radius_m: vehicle.brake.radius_m,
        resistance: [
            vehicle.resistance.constant_n,
            vehicle.resistance.linear_n_s_per_m,
            vehicle.resistance.drag_n_s2_per_m2,
        ],
        coupled: vehicle.is_coupled(),
    }
}
