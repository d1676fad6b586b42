//! The one interface of every filter: samples in, estimates and innovations out, whatever is watched.

use crate::estimator::WagonEstimator;
use crate::models::{Build, FilterEntry, find, names};
use crate::smoothing::StepTrace;
use crate::{
    ConfigError, EstimatorConfig, EstimatorInput, EstimatorOutput, EstimatorSnapshot, FilterError, Plant,
};

/// A filter with everything around it, for one wagon or rig. A step is pure: no clock, channel, file or allocation.
pub trait Estimator: Send {
    /// Takes one sample and says what is known after it. Never fails; what it did to bad data is in flags and state.
    fn step(&mut self, input: &EstimatorInput) -> EstimatorOutput;

    /// The last estimate.
    fn last(&self) -> &EstimatorOutput;

    /// Wheelsets of what is watched.
    fn wheelsets(&self) -> usize;

    /// Everything that a restart needs to go on from here.
    fn snapshot(&self) -> EstimatorSnapshot;

    /// Goes on from a snapshot. After an error the estimator is as before.
    ///
    /// # Errors
    /// A snapshot of another filter, vehicle or shape, or one that is not sound.
    fn restore(&mut self, snapshot: &EstimatorSnapshot) -> Result<(), FilterError>;

    /// A copy that goes on by itself.
    fn boxed_clone(&self) -> Box<dyn Estimator>;

    /// The same step with what a smoother needs on the way back; `None` if this filter cannot be smoothed.
    fn traced_step(&mut self, input: &EstimatorInput) -> Option<StepTrace>;

    /// The estimate of a traced step with another belief in its place.
    fn read_smoothed(&mut self, trace: &StepTrace, mean: &[f64], covariance: &[f64]) -> EstimatorOutput;
}

/// Name that stands for the filter that suits what is watched.
pub const DEFAULT_FILTER: &str = "default";

/// Builds the filter that `config` names for a wagon or rig.
///
/// # Errors
/// Settings or parameters out of range, an unknown filter, or one that does not handle what is watched.
pub fn estimator(config: &EstimatorConfig, plant: &Plant) -> Result<Box<dyn Estimator>, FilterError> {
    config.check()?;
    let entry = entry_for(&config.filter, plant)?;
    match entry.build {
        Build::Own(build) => build(config, plant),
        Build::Wagon(_) => match plant {
            Plant::Wagon(vehicle) => Ok(Box::new(WagonEstimator::new(config, vehicle)?)),
            Plant::Roller(rig) => {
                rig.check()?;
                let (vehicle, model) = (rig.as_vehicle(), rig.model());
                Ok(Box::new(WagonEstimator::with_model(config, &vehicle, model)?))
            }
            Plant::Traction(_) | Plant::Bogie(_) => Err(unfit(entry, plant)),
        },
    }
}

/// The entry of a filter's name; `"default"` is the first of the table that handles the plant.
fn entry_for(name: &str, plant: &Plant) -> Result<&'static FilterEntry, FilterError> {
    let kind = plant.kind();
    let handles = |entry: &&FilterEntry| entry.plants.contains(&kind);
    if name == DEFAULT_FILTER {
        let first = crate::models::FILTERS.iter().find(handles);
        return first.ok_or_else(|| ConfigError::UnknownFilter { name: name.into(), known: names() }.into());
    }
    let entry =
        find(name).ok_or_else(|| ConfigError::UnknownFilter { name: name.to_owned(), known: names() })?;
    if handles(&entry) { Ok(entry) } else { Err(unfit(entry, plant)) }
}

fn unfit(entry: &FilterEntry, plant: &Plant) -> FilterError {
    let kind = plant.kind();
    let fitting = crate::models::FILTERS.iter().filter(|entry| entry.plants.contains(&kind));
    FilterError::Plant {
        filter: entry.name,
        plant: kind.name(),
        known: fitting.map(|entry| format!("\"{}\"", entry.name)).collect::<Vec<_>>().join(", "),
    }
}
