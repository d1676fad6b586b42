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
mod catalogue;
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

pub use catalogue::{CATALOGUE, Constructor};
pub use drivetrain::LARGEST_DISC_SHARE;
pub use effect::{Effect, EffectSpec, Lateness, Likeness, Observation, Operating, ParameterSpec, Term, Twin};
pub use error::ModelError;
pub use stretch::window_share;

use crate::EffectEntry;

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

/// Checks what a vehicle file says of an effect against the wagon that it joins.
///
/// # Errors
/// A value that is larger than such a wagon can have.
pub(crate) fn check_on(
    effect: &dyn Effect,
    entry: &EffectEntry,
    constants: &crate::Constants,
) -> Result<(), ModelError> {
    let spec = effect.spec();
    for parameter in spec.parameters {
        if let Some(value) = entry.parameters.get(parameter.name).copied()
            && let Some(largest) = effect.largest(parameter.name, constants)
            && value > largest * (1.0 + ROUNDED)
        {
            return Err(ModelError::MoreThanWagonAllows {
                id: spec.id,
                name: parameter.name,
                value,
                largest,
            });
        }
    }
    Ok(())
}

/// What writing and reading a value may change of it, relative.
const ROUNDED: f64 = 1e-6;
