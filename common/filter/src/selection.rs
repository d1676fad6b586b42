//! Which filter runs: from the name in the config and from what is watched to an estimator.

use crate::estimator::WagonEstimator;
use crate::models::{Build, FILTERS, FilterEntry, find, names};
use crate::{ConfigError, Estimator, EstimatorConfig, FilterError, Plant};

/// Name that stands for the filter that suits what is watched.
pub const DEFAULT_FILTER: &str = "default";

/// Builds the filter that `config` names for a wagon or rig.
///
/// # Errors
/// Settings or parameters out of range, an unknown filter, one that does not handle what is watched, or one that knows no couplers
/// for a wagon that is coupled.
pub fn estimator(config: &EstimatorConfig, plant: &Plant) -> Result<Box<dyn Estimator>, FilterError> {
    config.check()?;
    let entry = entry_for(&config.filter, plant)?;
    match (entry.build, plant) {
        (Build::Wagon(_), Plant::Wagon(vehicle)) => Ok(Box::new(WagonEstimator::new(config, vehicle)?)),
        (Build::Wagon(_), Plant::Roller(rig)) => {
            rig.check()?;
            let (vehicle, model) = (rig.as_vehicle(), rig.model());
            Ok(Box::new(WagonEstimator::with_model(config, &vehicle, model)?))
        }
        (Build::Traction(build), Plant::Traction(rig)) => build(rig),
        (Build::Bogie(build), Plant::Bogie(rig)) => build(rig),
        _ => Err(unfit(entry, plant)),
    }
}

impl EstimatorConfig {
    /// Checks the filter's name and every value.
    ///
    /// # Errors
    /// An unknown filter, or the first value out of range, with its dotted key.
    pub fn check(&self) -> Result<(), ConfigError> {
        self.wrong().into_iter().next().map_or(Ok(()), Err)
    }

    /// Everything that is wrong with it: an unknown filter, and each value out of range with its dotted key.
    #[must_use]
    pub fn wrong(&self) -> Vec<ConfigError> {
        let filter = find(&self.filter).is_none().then(|| unknown(&self.filter));
        filter.into_iter().chain(self.out_of_range()).collect()
    }
}

fn unknown(name: &str) -> ConfigError {
    ConfigError::UnknownFilter { name: name.to_owned(), known: names() }
}

/// The entry of a filter's name; `"default"` is the first of the table that handles the plant.
fn entry_for(name: &str, plant: &Plant) -> Result<&'static FilterEntry, FilterError> {
    let kind = plant.kind();
    let handles = |entry: &&FilterEntry| entry.plants.contains(&kind);
    if name == DEFAULT_FILTER {
        let first = FILTERS.iter().find(handles);
        return first.ok_or_else(|| unknown(name).into());
    }
    let entry = find(name).ok_or_else(|| unknown(name))?;
    if !handles(&entry) {
        return Err(unfit(entry, plant));
    }
    match plant {
        Plant::Wagon(vehicle) if vehicle.is_coupled() && !entry.couplers => Err(FilterError::Coupled {
            filter: entry.name,
            known: listed(FILTERS.iter().filter(|entry| entry.couplers)),
        }),
        _ => Ok(entry),
    }
}

fn listed<'a>(entries: impl Iterator<Item = &'a FilterEntry>) -> String {
    entries.map(|entry| format!("\"{}\"", entry.name)).collect::<Vec<_>>().join(", ")
}

fn unfit(entry: &FilterEntry, plant: &Plant) -> FilterError {
    let kind = plant.kind();
    let fitting = FILTERS.iter().filter(|entry| entry.plants.contains(&kind));
    FilterError::Plant { filter: entry.name, plant: kind.name(), known: listed(fitting) }
}
