//! Every effect of the family, each in several functional forms. This table is what drawing, labels, scores and tests loop
//! over.

mod actuation;
mod body;
mod pad;
mod rail;
mod resistance;
mod sensors;

use super::forms::Effect;

/// All effects: those with an id of the contract, those that the catalogue is to gain, those that no id names.
pub static EFFECTS: [Effect; 41] = [
    Effect::named("brake_friction_speed", "brake_friction", &pad::SPEED),
    Effect::named("brake_fade", "brake_friction", &pad::FADE),
    Effect::named("brake_friction_pressure", "brake_friction", &pad::PRESSURE),
    Effect::named("brake_wet_delay", "brake_friction", &pad::WET),
    Effect::named("brake_lag", "brake_actuation", &actuation::LAG),
    Effect::named("rigging_hysteresis", "brake_actuation", &actuation::HYSTERESIS),
    Effect::named("pressing_force_offset", "brake_actuation", &actuation::OFFSET),
    Effect::named("dragging_brake", "brake_actuation", &actuation::DRAGGING),
    Effect::named("falling_friction", "adhesion", &rail::FALLING).on_low_rail(),
    Effect::named("self_cleaning", "adhesion", &rail::CLEANING).on_low_rail(),
    Effect::named("low_adhesion_patch", "adhesion", &rail::PATCH).on_low_rail(),
    Effect::named("adhesion_speed", "adhesion", &rail::SPEED).on_low_rail(),
    Effect::named("sanding", "adhesion", &rail::SAND).on_low_rail().with_sander(),
    Effect::named("load_transfer", "load_distribution", &body::TRANSFER).on_low_rail(),
    Effect::named("mass_error", "inertia", &body::MASS),
    Effect::named("rotating_inertia", "inertia", &body::INERTIA),
    Effect::named("wheel_radius", "kinematics", &body::RADIUS),
    Effect::named("grade", "resistance", &resistance::GRADE),
    Effect::named("running_resistance", "resistance", &resistance::RUNNING),
    Effect::named("headwind", "resistance", &resistance::WIND),
    Effect::named("coupler_force", "longitudinal_force", &body::COUPLER),
    Effect::named("wheel_encoder_eccentricity", "sensor_wheel_speed", &sensors::ECCENTRIC),
    Effect::named("wheel_encoder_window", "sensor_wheel_speed", &sensors::WINDOW),
    Effect::named("clock_skew", "sensor_wheel_speed", &sensors::CLOCK),
    Effect::named("speed_latency", "sensor_speed", &sensors::LATENCY),
    Effect::named("speed_scale", "sensor_speed", &sensors::SCALE),
    Effect::named("axle_torsion", "drivetrain", &body::TORSION),
    // What the catalogue is to gain: named as soon as it has the id.
    Effect::nameless("cast_iron", "brake_friction", &pad::CAST_IRON),
    Effect::nameless("air_resistance", "resistance", &resistance::DRAG),
    Effect::nameless("pressure_dump", "brake_actuation", &actuation::DUMP).on_low_rail(),
    Effect::nameless("wheel_radius_all", "kinematics", &body::RADIUS_OF_ALL),
    Effect::nameless("track_brake_at_full_braking", "longitudinal_force", &body::TRACK_BRAKE),
    Effect::nameless("initial_bite", "brake_friction", &pad::BITE),
    Effect::nameless("pad_friction_periodic_with_wheel_angle", "brake_friction", &pad::UNEVEN_DISC),
    Effect::nameless("cold_bearings", "resistance", &resistance::COLD_BEARINGS),
    Effect::nameless("contact_conditioning_by_sliding", "adhesion", &rail::CONDITIONING).on_low_rail(),
    Effect::nameless("speed_ripple_with_position", "sensor_speed", &sensors::RADAR),
    Effect::nameless("tachometer_disturbed_by_braking", "sensor_wheel_speed", &sensors::DISTURBED),
    Effect::nameless("drive_torque_short_of_command", "drivetrain", &body::WEAK_DRIVE).with_motor(),
    Effect::nameless("leaking_cylinder", "brake_actuation", &actuation::LEAK),
    Effect::nameless("static_load_uneven", "load_distribution", &body::UNEVEN_LOAD).on_low_rail(),
];

/// The effect of this id.
#[must_use]
pub fn effect(id: &str) -> Option<&'static Effect> {
    EFFECTS.iter().find(|effect| effect.id == id)
}
