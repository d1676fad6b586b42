//! The wagons of a train as its settings give them.

use crate::SettingsError;
use crate::file::TrainFile;
use crate::identity::{self, VehicleNumber};
use crate::place::{ConfigText, folder, name};
use crate::plant;
use crate::runs::ReplayRun;
use crate::source::Source;
use railgrip_filter::{EstimatorConfig, Plant};
use railgrip_vehicle::VehicleParameters;
use std::path::{Path, PathBuf};

/// Most wagons of one train.
pub const MAX_WAGONS: u32 = 200;

/// The default config, `config/railgrip.toml`, built in so that the program runs without any file.
pub(crate) const DEFAULT_CONFIG: &str = include_str!("../../../config/railgrip.toml");
/// The vehicle file that the default config names.
pub(crate) const DEFAULT_VEHICLE: &str = include_str!("../../../config/vehicle.toml");
/// One wagon.
#[derive(Debug, Clone)]
pub struct WagonSettings {
    /// Number in the train, 1 first.
    pub number: u32,
    /// Name for people.
    pub name: String,
    /// Who it is, wherever it runs; without it nobody knows whether it is the same as last time.
    pub vehicle_number: Option<VehicleNumber>,
    /// It runs with its other end first: its last wheelset leads.
    pub turned: bool,
    /// What it is; of a rig, what it would be as a wagon with one wheelset.
    pub vehicle: VehicleParameters,
    /// What it is, rigs too.
    pub plant: Plant,
    /// What the simulation makes of it, where that shall differ from what its estimator believes.
    pub simulated: Option<VehicleParameters>,
    /// Its own filter, where it is not that of the train.
    pub filter: Option<String>,
}

/// The wagons of a train: their names, vehicles and filters; what is wrong with one is noted.
pub(crate) fn wagons(at: &ConfigText<'_>, form: &TrainFile, source: &Source) -> Vec<WagonSettings> {
    let runs: &[ReplayRun] = if let Source::Replay { runs, .. } = source { runs } else { &[] };
    let count = at.or(count(at, form, runs), 1);
    let mut cache = VehicleFiles { base: folder(at.file), read: Vec::new() };
    let mut wagons: Vec<WagonSettings> = Vec::with_capacity(count as usize);
    for number in 1..=count {
        let index = number as usize - 1;
        let table = form.wagon.get(index);
        let wagon_name = match (table.and_then(|wagon| wagon.name.as_deref()), runs.get(index)) {
            (Some(given), _) => {
                at.or(name(at, &format!("wagon.{number}.name"), given), format!("wagon-{number}"))
            }
            (None, Some(run)) => run.name.clone(),
            (None, None) => format!("wagon-{number}"),
        };
        if wagons.iter().any(|other| other.name == wagon_name) {
            let key = format!("wagon.{number}.name");
            at.note(at.refuse(&key, &wagon_name, "a name that no other wagon has"));
        }
        let earlier = wagons.iter().filter_map(|other| other.vehicle_number.as_ref());
        let given = table.and_then(|wagon| wagon.number.as_deref());
        let vehicle_number = at.or(identity::number(at, number, given, earlier), None);
        let turned = table.is_some_and(|wagon| wagon.turned);
        let own = table.and_then(|wagon| wagon.vehicle.as_deref());
        let beside = runs.get(index).and_then(|run| run.vehicle_file.clone());
        let plant = match (own, beside, form.train.vehicle.as_deref()) {
            (Some(own), _, _) => cache.load(at, &format!("wagon.{number}.vehicle"), own),
            (None, Some(file), _) => cache.load_path(at, "source.runs", &file),
            (None, None, Some(common)) => cache.load(at, "train.vehicle", common),
            (None, None, None) if at.doubts("source") => continue,
            (None, None, None) => {
                Err(at.refuse("train.vehicle", "absent", "a vehicle file, relative to this file"))
            }
        };
        let plant = match plant {
            Ok(plant) => plant,
            Err(error) => {
                at.note(error);
                continue;
            }
        };
        let filter = table.and_then(|wagon| wagon.filter.clone());
        check_filter(at, number, filter.as_deref(), &form.estimator, &plant);
        let simulated = table.and_then(|wagon| wagon.simulated.as_deref());
        let simulated =
            simulated.map(|file| simulated_wagon(at, number, file, source, &mut cache)).transpose();
        let simulated = at.or(simulated, None);
        let vehicle = plant.as_vehicle();
        wagons.push(WagonSettings {
            number,
            name: wagon_name,
            vehicle_number,
            turned,
            vehicle,
            plant,
            simulated,
            filter,
        });
    }
    wagons
}

/// Notes a filter that does not suit what it is to watch; `own` is the wagon's own, before that of the train.
pub(crate) fn check_filter(
    at: &ConfigText<'_>,
    number: u32,
    own: Option<&str>,
    train: &EstimatorConfig,
    plant: &Plant,
) {
    if at.doubts("estimator") {
        return;
    }
    let (key, filter) = match own {
        Some(own) => (format!("wagon.{number}.filter"), own),
        None => ("estimator.filter".to_owned(), train.filter.as_str()),
    };
    let named = EstimatorConfig { filter: filter.to_owned(), ..train.clone() };
    if let Err(error) = railgrip_filter::estimator(&named, plant) {
        at.note(at.refuse(&key, format!("{filter:?}"), error));
    }
}

/// The vehicle that the simulation takes for a wagon, whatever its estimator believes.
fn simulated_wagon(
    at: &ConfigText<'_>,
    number: u32,
    file: &str,
    source: &Source,
    cache: &mut VehicleFiles,
) -> Result<VehicleParameters, SettingsError> {
    let key = format!("wagon.{number}.simulated");
    if !matches!(source, Source::Simulate { .. }) && !at.doubts("source") {
        return Err(at.refuse(&key, file, "nothing, unless [source] kind is simulate"));
    }
    match cache.load(at, &key, file)? {
        Plant::Wagon(vehicle) => Ok(vehicle),
        _ => Err(at.refuse(&key, file, "the vehicle file of a wagon")),
    }
}

/// How many wagons: as many as there are recordings, else as listed, else as counted.
fn count(at: &ConfigText<'_>, form: &TrainFile, runs: &[ReplayRun]) -> Result<u32, SettingsError> {
    let listed = u32::try_from(form.wagon.len()).unwrap_or(u32::MAX);
    let (key, count) = match (form.train.wagons, listed, runs.len()) {
        (Some(count), _, recordings @ 1..)
            if form.source.runs.is_some()
                && usize::try_from(count) != Ok(recordings)
                && !at.is_blamed("source.runs") =>
        {
            let allowed = format!("{recordings}, the number of recordings");
            return Err(at.refuse("train.wagons", count, allowed));
        }
        (_, _, recordings @ 1..) => ("source.runs", u32::try_from(recordings).unwrap_or(u32::MAX)),
        (Some(count), 0, 0) => ("train.wagons", count),
        (None, 1.., 0) => ("wagon", listed),
        (Some(count), listed, 0) if count == listed => ("train.wagons", count),
        // Tables of which one is broken, or recordings that are not found, cannot be counted.
        (Some(count), _, 0) if at.is_blamed("wagon") => ("train.wagons", count),
        (Some(count), listed, 0) => {
            return Err(at.refuse(
                "train.wagons",
                count,
                format!("{listed}, the number of [[wagon]] tables"),
            ));
        }
        (None, 0, 0) if at.doubts("source") => return Ok(1),
        (None, 0, 0) => {
            return Err(at.refuse("train.wagons", "absent", "a number of wagons, or [[wagon]] tables"));
        }
    };
    if (1..=MAX_WAGONS).contains(&count) {
        return Ok(count);
    }
    Err(at.refuse(key, format!("{count} wagons"), format!("1 to {MAX_WAGONS} wagons")))
}

/// Vehicle files read so far; the wagons of a train mostly share one.
struct VehicleFiles {
    base: PathBuf,
    read: Vec<(PathBuf, Plant)>,
}

impl VehicleFiles {
    fn load(&mut self, at: &ConfigText<'_>, key: &str, file: &str) -> Result<Plant, SettingsError> {
        let path = self.base.join(file);
        if path.is_file() {
            return self.load_path(at, key, &path);
        }
        if at.text == DEFAULT_CONFIG && !path.exists() {
            return plant::parse(&path, DEFAULT_VEHICLE).map_err(|error| at.refuse_file(key, error));
        }
        Err(at.refuse(key, format!("{file:?}"), format!("a vehicle file; {} is none", path.display())))
    }

    fn load_path(&mut self, at: &ConfigText<'_>, key: &str, path: &Path) -> Result<Plant, SettingsError> {
        if let Some((_, vehicle)) = self.read.iter().find(|(read, _)| read == path) {
            return Ok(vehicle.clone());
        }
        let vehicle = plant::load(path).map_err(|error| at.refuse_file(key, error))?;
        self.read.push((path.to_owned(), vehicle.clone()));
        Ok(vehicle)
    }
}
