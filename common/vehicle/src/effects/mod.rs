//! Effects: what a simple longitudinal model leaves out, as modifiers that compose with its laws.
//!
//! An [`Effect`] answers at the places of the equations that it concerns and leaves the others as they are; a
//! [`crate::WagonModel`] passes the value of each law through all its effects in turn. An effect may carry hidden
//! states (a temperature, a film, a delay line), which advance once a sample, outside of the integrator's stages.
//!
//! **Adding an effect**: write it in the file of its term (one file a term) and name its constructor in the table
//! [`CATALOGUE`]; or, without Rust, write it in a file of its own, see [`own`].

mod adhesion;
mod brake_actuation;
mod brake_friction;
mod delay;
mod drivetrain;
mod effect;
mod error;
mod inertia;
mod kinematics;
mod load_distribution;
mod longitudinal_force;
pub mod own;
mod resistance;
mod sensor_speed;
mod sensor_wheel_speed;
mod stretch;

pub use effect::{Effect, EffectSpec, Lateness, Likeness, Observation, Operating, ParameterSpec, Term, Twin};
pub use error::ModelError;
pub use stretch::window_share;

use crate::EffectEntry;

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

/// Every effect there is: those of the [`CATALOGUE`], then those that were read from files of [`own`] effects.
pub fn all() -> Vec<(&'static EffectSpec, Constructor)> {
    CATALOGUE.iter().copied().chain(own::known()).collect()
}

/// The effect of that id, from the catalogue or a file of [`own`] effects.
pub fn find(id: &str) -> Option<(&'static EffectSpec, Constructor)> {
    CATALOGUE.iter().copied().chain(own::known()).find(|(spec, _)| spec.id == id)
}

/// Builds the effect of a vehicle file.
///
/// # Errors
/// An unknown id or parameter, or a value outside its bounds.
pub fn build(entry: &EffectEntry) -> Result<Box<dyn Effect>, ModelError> {
    let (spec, constructor) =
        find(&entry.id).ok_or_else(|| ModelError::UnknownEffect { id: entry.id.clone() })?;
    if let Some(name) = entry.parameters.keys().find(|name| spec.parameters.iter().all(|p| p.name != **name))
    {
        return Err(ModelError::UnknownParameter { id: spec.id, name: name.clone() });
    }
    let mut values = Vec::with_capacity(spec.parameters.len());
    for parameter in spec.parameters {
        let value = entry.parameters.get(parameter.name).copied().unwrap_or(parameter.default);
        if !(parameter.lower..=parameter.upper).contains(&value) {
            return Err(ModelError::ParameterOutOfBounds {
                id: spec.id,
                name: parameter.name,
                value,
                lower: parameter.lower,
                upper: parameter.upper,
            });
        }
        values.push(value);
    }
    Ok(constructor(&values))
}
