//! The catalogue of departures: every id of the contract in this plant's own functional form, and a handful that no id
//! names. Each entry draws its parameters from a stream and scales its size by a strength.

mod actuation;
mod adhesion;
mod body;
mod brake;
mod nameless;
mod resistance;
mod sensors;

pub use crate::departure::Drawn;

use crate::{random::Stream, sheet::Sheet};

/// One entry of the catalogue.
#[derive(Clone, Copy)]
pub struct Kind {
    /// Id of the contract, or a name of its own for one that no id names.
    pub id: &'static str,
    /// Term of the equations.
    pub term: &'static str,
    /// Whether the contract has an id for it.
    pub named: bool,
    /// Whether it shows only on a vehicle with traction.
    pub needs_motor: bool,
    /// Whether it shows only on a vehicle with sanders.
    pub needs_sander: bool,
    /// Whether the holdout runs, which have no traction, can show it.
    pub shows_in_holdout: bool,
    /// Largest strength that is still plausible.
    pub strongest: f64,
    draw: fn(f64, &mut Stream, &Sheet) -> Drawn,
}

impl Kind {
    /// Draws the departure; the same stream and another strength give the same departure, larger or smaller.
    #[must_use]
    pub fn draw(&self, strength: f64, stream: &mut Stream, sheet: &Sheet) -> Drawn {
        (self.draw)(strength, stream, sheet)
    }

    /// The entry of this id.
    #[must_use]
    pub fn of(id: &str) -> Option<Self> {
        CATALOGUE.iter().copied().find(|kind| kind.id == id)
    }
}

impl std::fmt::Debug for Kind {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.id)
    }
}

const fn named(
    id: &'static str,
    term: &'static str,
    strongest: f64,
    draw: fn(f64, &mut Stream, &Sheet) -> Drawn,
) -> Kind {
    Kind {
        id,
        term,
        named: true,
        needs_motor: false,
        needs_sander: false,
        shows_in_holdout: true,
        strongest,
        draw,
    }
}

const fn nameless(
    id: &'static str,
    term: &'static str,
    strongest: f64,
    draw: fn(f64, &mut Stream, &Sheet) -> Drawn,
) -> Kind {
    Kind { named: false, ..named(id, term, strongest, draw) }
}

/// Every departure this plant knows.
pub const CATALOGUE: [Kind; 36] = [
    named("brake_friction_speed", "brake_friction", 2.5, brake::brake_friction_speed),
    named("brake_fade", "brake_friction", 2.0, brake::brake_fade),
    named("brake_friction_pressure", "brake_friction", 2.5, brake::brake_friction_pressure),
    named("brake_wet_delay", "brake_friction", 1.8, brake::brake_wet_delay),
    named("brake_lag", "brake_actuation", 2.0, actuation::brake_lag),
    named("rigging_hysteresis", "brake_actuation", 2.5, actuation::rigging_hysteresis),
    named("pressing_force_offset", "brake_actuation", 3.0, actuation::pressing_force_offset),
    named("dragging_brake", "brake_actuation", 3.0, actuation::dragging_brake),
    named("falling_friction", "adhesion", 1.7, adhesion::falling_friction),
    named("self_cleaning", "adhesion", 2.5, adhesion::self_cleaning),
    named("low_adhesion_patch", "adhesion", 1.5, adhesion::low_adhesion_patch),
    named("adhesion_speed", "adhesion", 3.0, adhesion::adhesion_speed),
    Kind { needs_sander: true, ..named("sanding", "adhesion", 2.5, adhesion::sanding) },
    named("load_transfer", "load_distribution", 3.5, body::load_transfer),
    Kind { needs_motor: true, ..named("mass_error", "inertia", 2.5, body::mass_error) },
    named("rotating_inertia", "inertia", 3.0, body::rotating_inertia),
    named("wheel_radius", "kinematics", 3.0, body::wheel_radius),
    named("grade", "resistance", 2.5, resistance::grade),
    named("running_resistance", "resistance", 3.0, resistance::running_resistance),
    named("headwind", "resistance", 2.0, resistance::headwind),
    named("coupler_force", "longitudinal_force", 2.5, body::coupler_force),
    named("wheel_encoder_eccentricity", "sensor_wheel_speed", 3.0, sensors::wheel_encoder_eccentricity),
    named("wheel_encoder_window", "sensor_wheel_speed", 3.0, sensors::wheel_encoder_window),
    named("clock_skew", "sensor_wheel_speed", 3.0, sensors::clock_skew),
    named("speed_latency", "sensor_speed", 2.5, sensors::speed_latency),
    named("speed_scale", "sensor_speed", 3.0, sensors::speed_scale),
    named("axle_torsion", "drivetrain", 2.0, body::axle_torsion),
    nameless("track_brake_at_full_braking", "longitudinal_force", 3.0, nameless::track_brake),
    nameless("initial_bite", "brake_friction", 2.5, nameless::initial_bite),
    nameless("pad_friction_periodic_with_wheel_angle", "brake_friction", 2.0, nameless::uneven_disc),
    nameless("cold_bearings", "resistance", 3.0, nameless::cold_bearings),
    nameless("contact_conditioning_by_sliding", "adhesion", 2.5, nameless::conditioning),
    nameless("speed_ripple_with_position", "sensor_speed", 3.0, nameless::sleeper_radar),
    nameless("tachometer_disturbed_by_braking", "sensor_wheel_speed", 3.0, nameless::disturbed_tachometer),
    Kind {
        needs_motor: true,
        shows_in_holdout: false,
        ..nameless("drive_torque_short_of_command", "drivetrain", 3.0, nameless::weak_drive)
    },
    nameless("leaking_cylinder", "brake_actuation", 3.0, nameless::leaking_cylinder),
];
