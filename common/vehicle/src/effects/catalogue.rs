//! The effects that railgrip brings along.

use super::{
    Effect, EffectSpec, adhesion, brake_actuation, brake_friction, drivetrain, inertia, kinematics,
    load_distribution, longitudinal_force, resistance, sensor_speed, sensor_wheel_speed,
};

/// Builds an effect from its parameter values, in the order of its spec.
pub type Constructor = &'static (dyn Fn(&[f64]) -> Box<dyn Effect> + Send + Sync);

/// Every effect that railgrip brings along.
pub static CATALOGUE: &[(&EffectSpec, Constructor)] = &[
    (&brake_friction::SPEED, &brake_friction::Speed::boxed),
    (&brake_friction::FADE, &brake_friction::Fade::boxed),
    (&brake_friction::PRESSURE, &brake_friction::Pressure::boxed),
    (&brake_friction::WET_DELAY, &brake_friction::WetDelay::boxed),
    (&brake_friction::CAST_IRON, &brake_friction::CastIron::boxed),
    (&brake_actuation::LAG, &brake_actuation::Lag::boxed),
    (&brake_actuation::HYSTERESIS, &brake_actuation::Hysteresis::boxed),
    (&brake_actuation::OFFSET, &brake_actuation::Offset::boxed),
    (&brake_actuation::DRAGGING, &brake_actuation::Dragging::boxed),
    (&brake_actuation::DUMP, &brake_actuation::Dump::boxed),
    (&adhesion::FALLING, &adhesion::Falling::boxed),
    (&adhesion::SELF_CLEANING, &adhesion::SelfCleaning::boxed),
    (&adhesion::PATCH, &adhesion::Patch::boxed),
    (&adhesion::SPEED, &adhesion::Speed::boxed),
    (&adhesion::SANDING, &adhesion::Sanding::boxed),
    (&load_distribution::LOAD_TRANSFER, &load_distribution::LoadTransfer::boxed),
    (&inertia::MASS, &inertia::Mass::boxed),
    (&inertia::ROTATING, &inertia::Rotating::boxed),
    (&kinematics::WHEEL_RADIUS, &kinematics::WheelRadius::boxed),
    (&resistance::GRADE, &resistance::Grade::boxed),
    (&resistance::RUNNING, &resistance::Running::boxed),
    (&resistance::HEADWIND, &resistance::Headwind::boxed),
    (&longitudinal_force::COUPLER, &longitudinal_force::Coupler::boxed),
    (&sensor_wheel_speed::ECCENTRICITY, &sensor_wheel_speed::Eccentricity::boxed),
    (&sensor_wheel_speed::WINDOW, &sensor_wheel_speed::Window::boxed),
    (&sensor_wheel_speed::CLOCK_SKEW, &sensor_wheel_speed::ClockSkew::boxed),
    (&sensor_speed::LATENCY, &sensor_speed::Latency::boxed),
    (&sensor_speed::SCALE, &sensor_speed::Scale::boxed),
    (&drivetrain::TORSION, &drivetrain::Torsion::boxed),
];
