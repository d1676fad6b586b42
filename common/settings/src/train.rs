//! The settings of a train, checked once and then trusted everywhere.

use crate::access::AccessSettings;
use crate::alerts::{AlertSettings, CapabilitySettings, DeliverySettings};
use crate::file::{LogFormat, SourceKind, SourceTable, TrainFile};
use crate::history::HistorySettings;
use crate::microphones::{self, AcousticSettings, MicrophoneSettings};
use crate::place::ConfigText;
use crate::plant::RigProgramme;
use crate::runs::{self, ReplayRun};
use crate::wagons::wagons;
use crate::{SettingsError, instance::Instance};
use railgrip_filter::{ConfigError, EstimatorConfig, Plant};
use railgrip_indicators::IndicatorSettings;
use railgrip_simulation::Scenario;
use railgrip_vehicle::VehicleParameters;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

/// Most wagons of one train.
pub const MAX_WAGONS: u32 = 200;

/// The default config, `config/railgrip.toml`, built in so that the program runs without any file.
pub(crate) const DEFAULT_CONFIG: &str = include_str!("../../../config/railgrip.toml");
/// The vehicle file that the default config names.
pub(crate) const DEFAULT_VEHICLE: &str = include_str!("../../../config/vehicle.toml");
/// The scenario that the default config names.
const DEFAULT_SCENARIO: &str = include_str!("../../../config/scenarios/demo.toml");
/// Its name.
const DEFAULT_SCENARIO_NAME: &str = "demo";
/// Where scenarios with a name lie, seen from the config.
const SCENARIO_FOLDER: &str = "scenarios";
/// Where the default config lies, seen from the directory in which people call the program.
const DEFAULT_PATH: &str = "config/railgrip.toml";

/// A train: its wagons, where their samples come from, and how each process behaves.
#[derive(Debug, Clone)]
pub struct TrainSettings {
    /// The config file; its folder is the base of the paths in it.
    pub file: PathBuf,
    /// Name of the train.
    pub name: String,
    /// The wagons from the front; wagon number `n` stands at index `n − 1`.
    pub wagons: Vec<WagonSettings>,
    /// The microphones; a wagon has one or none.
    pub microphones: Vec<MicrophoneSettings>,
    /// How they are listened to.
    pub acoustics: AcousticSettings,
    /// Where this instance keeps its channels and files.
    pub instance: Instance,
    /// Where samples come from.
    pub source: Source,
    /// Samples of so many seconds travel as one batch.
    pub batch_s: f64,
    /// The filter of every wagon.
    pub estimator: EstimatorConfig,
    /// How often estimators report and save.
    pub reporting: ReportingSettings,
    /// How indicators are computed and judged.
    pub indicators: IndicatorSettings,
    /// The HTTP service.
    pub http: HttpSettings,
    /// Who may come in to it.
    pub access: AccessSettings,
    /// When an alert is raised, grouped and cleared.
    pub alerts: AlertSettings,
    /// Where alerts and what waits for delivery are kept.
    pub alert_journal: PathBuf,
    /// How people are told of alerts.
    pub delivery: DeliverySettings,
    /// What full braking of this train is, and the adhesion map.
    pub capability: CapabilitySettings,
    /// What is remembered.
    pub history: HistorySettings,
    /// Log lines.
    pub logging: LoggingSettings,
}

/// One wagon.
#[derive(Debug, Clone)]
pub struct WagonSettings {
    /// Number in the train, 1 first.
    pub number: u32,
    /// Name for people.
    pub name: String,
    /// What it is; of a rig, what it would be as a wagon with one wheelset.
    pub vehicle: VehicleParameters,
    /// What it is, rigs too.
    pub plant: Plant,
    /// What the simulation makes of it, where that shall differ from what its estimator believes.
    pub simulated: Option<VehicleParameters>,
    /// Its own filter, where it is not that of the train.
    pub filter: Option<String>,
}

/// Where samples come from.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// The simulated train.
    Simulate {
        /// What the train does.
        scenario: Box<Scenario>,
        /// Seed of everything random.
        seed: u64,
        /// Samples per second; that of each vehicle's sensors if absent.
        sample_rate_hz: Option<f64>,
        /// Simulated seconds in a second.
        speed: f64,
    },
    /// Simulated rigs under a published test, each with a seed of its own.
    Rig {
        /// Which test.
        programme: RigProgramme,
        /// Seed of everything random; that of wagon `n` is larger by `n − 1`.
        seed: u64,
        /// Simulated seconds in a second.
        speed: f64,
        /// Begin again at the end.
        repeat: bool,
    },
    /// Recordings, one a wagon.
    Replay {
        /// In the order of the wagons.
        runs: Vec<ReplayRun>,
        /// Recorded seconds in a second.
        speed: f64,
        /// Begin again at the end.
        repeat: bool,
    },
    /// One JSON object a line on the standard input.
    Stdin,
}

/// How often estimators report and save.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReportingSettings {
    /// Time between two snapshots, s.
    pub snapshot_period_s: f64,
    /// Indicators are published so often, Hz.
    pub health_rate_hz: f64,
}

/// The HTTP service.
#[derive(Debug, Clone, PartialEq)]
pub struct HttpSettings {
    /// Address and port to listen on; port 0 takes any free one.
    pub listen: SocketAddr,
    /// What is served is renewed after so many seconds.
    pub refresh_s: f64,
    /// A wagon without news for so many seconds is stale.
    pub stale_after_s: f64,
    /// Other origins whose pages may read the interface; none by default.
    pub cors_origins: Vec<String>,
}

/// Log lines.
#[derive(Debug, Clone, PartialEq)]
pub struct LoggingSettings {
    /// Level, or a filter such as `info,railgrip_bus=debug`.
    pub level: String,
    /// How lines look.
    pub format: LogFormat,
}

/// What the command line overrides. Every process of a train must be given the same.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overrides {
    /// Replays these recordings: files, folders or globs, relative to the working directory.
    pub runs: Vec<String>,
    /// Plays or simulates so many seconds in a second.
    pub speed: Option<f64>,
    /// Listens here instead.
    pub listen: Option<SocketAddr>,
    /// Keeps the instance here instead.
    pub instance_dir: Option<PathBuf>,
}

impl TrainSettings {
    /// Reads a config file; without one `config/railgrip.toml`, and where that is missing the same settings built in.
    ///
    /// # Errors
    /// The first thing that is wrong, with file, line, key and what is allowed.
    pub fn load(file: Option<&Path>, overrides: &Overrides) -> Result<Self, SettingsError> {
        let path = file.unwrap_or(Path::new(DEFAULT_PATH));
        match std::fs::read_to_string(path) {
            Ok(text) => Self::parse(path, &text, overrides),
            Err(error) if file.is_none() && error.kind() == std::io::ErrorKind::NotFound => {
                Self::parse(Path::new(DEFAULT_PATH), DEFAULT_CONFIG, overrides)
            }
            Err(source) => Err(SettingsError::Read { file: path.to_owned(), source }),
        }
    }

    /// Parses and checks the text of a config file; paths in it are relative to the folder of `file`.
    ///
    /// # Errors
    /// As [`TrainSettings::load`].
    pub fn parse(file: &Path, text: &str, overrides: &Overrides) -> Result<Self, SettingsError> {
        let at = ConfigText { file, text };
        let form: TrainFile = at.parse()?;
        at.within("schema", f64::from(form.schema), 1.0..=1.0)?;
        let name = name(&at, "train.name", &form.train.name)?;
        let source = source(&at, &form.source, overrides)?;
        form.estimator.check().map_err(|wrong| match wrong {
            ConfigError::OutOfRange { key, value, allowed } => {
                at.refuse(&format!("estimator.{key}"), value, allowed)
            }
            ConfigError::UnknownFilter { name, known } => {
                at.refuse("estimator.filter", format!("{name:?}"), known)
            }
        })?;
        let wagons = wagons(&at, &form, &source)?;
        let base = folder(file);
        let microphones =
            microphones::microphones(&at, &form.microphone, wagons.len() as u32, &source, &base)?;
        let acoustics = form.acoustics.check(&at, &base)?;
        form.indicators
            .check()
            .map_err(|wrong| at.refuse(&format!("indicators.{}", wrong.key), wrong.value, wrong.allowed))?;
        let listen = match overrides.listen {
            Some(listen) => listen,
            None => form.http.listen.parse().map_err(|_| {
                at.refuse("http.listen", &form.http.listen, "ADDRESS:PORT, for example 127.0.0.1:8080")
            })?,
        };
        let instance = Instance::of(&at, &form.instance, &name, overrides.instance_dir.as_deref())?;
        let access = AccessSettings::of(&at, &form.http, listen, overrides.listen.is_some(), &instance.dir)?;
        let history = HistorySettings::of(&at, &form.history, &name, overrides.instance_dir.as_deref())?;
        Ok(Self {
            file: file.to_owned(),
            access,
            wagons,
            microphones,
            acoustics,
            source,
            batch_s: at.within("samples.batch_ms", form.samples.batch_ms, 0.0..=1000.0)? * 1e-3,
            estimator: form.estimator,
            reporting: ReportingSettings {
                snapshot_period_s: at.within(
                    "reporting.snapshot_period_s",
                    form.reporting.snapshot_period_s,
                    0.1..=60.0,
                )?,
                health_rate_hz: at.within(
                    "reporting.health_rate_hz",
                    form.reporting.health_rate_hz,
                    0.2..=50.0,
                )?,
            },
            indicators: form.indicators,
            http: HttpSettings {
                listen,
                refresh_s: at.within("http.refresh_ms", form.http.refresh_ms, 20.0..=5000.0)? * 1e-3,
                stale_after_s: at.within("http.stale_after_s", form.http.stale_after_s, 0.2..=600.0)?,
                cors_origins: cors_origins(&at, &form.http.cors_origins)?,
            },
            alerts: form.alerts.check(&at)?,
            alert_journal: form.alerts.journal(&at, &history.dir),
            delivery: form.delivery.check(&at, &name)?,
            capability: form.capability.check(&at)?,
            history,
            instance,
            name,
            logging: LoggingSettings { level: form.logging.level, format: form.logging.format },
        })
    }

    /// The microphone of that wagon.
    #[must_use]
    pub fn microphone(&self, wagon: u32) -> Option<&MicrophoneSettings> {
        self.microphones.iter().find(|microphone| microphone.wagon == wagon)
    }

    /// The wagon of that number.
    #[must_use]
    pub fn wagon(&self, number: u32) -> Option<&WagonSettings> {
        self.wagons.get((number as usize).checked_sub(1)?)
    }
}

/// Origins as browsers send them: scheme, host and port, no path.
fn cors_origins(at: &ConfigText<'_>, origins: &[String]) -> Result<Vec<String>, SettingsError> {
    let sound = |origin: &&String| {
        let host = origin.strip_prefix("https://").or_else(|| origin.strip_prefix("http://"));
        host.is_some_and(|host| !host.is_empty() && host.chars().all(|c| c.is_ascii_graphic() && c != '/'))
    };
    match origins.iter().find(|origin| !sound(origin)) {
        None => Ok(origins.to_vec()),
        Some(origin) => Err(at.refuse(
            "http.cors_origins",
            format!("{origin:?}"),
            "origins such as \"https://depot.example:8443\", without a path",
        )),
    }
}

/// Letters, digits, `-`, `_` and `.`, at most 32 of them: fit for names of files.
pub(crate) fn name(at: &ConfigText<'_>, key: &str, name: &str) -> Result<String, SettingsError> {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.');
    if (1..=32).contains(&name.len()) && name.chars().all(plain) && !name.starts_with('.') {
        return Ok(name.to_owned());
    }
    Err(at.refuse(key, format!("{name:?}"), "1 to 32 letters, digits, `-`, `_`, `.`"))
}

fn source(at: &ConfigText<'_>, table: &SourceTable, overrides: &Overrides) -> Result<Source, SettingsError> {
    let speed = match overrides.speed {
        Some(speed) if (0.01..=1000.0).contains(&speed) => speed,
        Some(speed) => {
            let problem = "allowed is 0.01 to 1000".to_owned();
            return Err(SettingsError::Option { option: "--speed", value: speed.to_string(), problem });
        }
        None => at.within("source.speed", table.speed.unwrap_or(1.0), 0.01..=1000.0)?,
    };
    if !overrides.runs.is_empty() {
        let runs = runs::find(&overrides.runs, Path::new("")).map_err(|problem| SettingsError::Option {
            option: "--runs",
            value: overrides.runs.join(" "),
            problem,
        })?;
        return Ok(Source::Replay { runs, speed, repeat: table.repeat.unwrap_or(true) });
    }
    check_keys_of_kind(at, table)?;
    match table.kind {
        SourceKind::Stdin => Ok(Source::Stdin),
        SourceKind::Simulate => {
            if let Some(rate) = table.sample_rate_hz {
                at.within("source.sample_rate_hz", rate, 10.0..=2000.0)?;
            }
            Ok(Source::Simulate {
                scenario: Box::new(scenario(at, table.scenario.as_deref().unwrap_or(DEFAULT_SCENARIO_NAME))?),
                seed: table.seed.unwrap_or(1),
                sample_rate_hz: table.sample_rate_hz,
                speed,
            })
        }
        SourceKind::Rig => {
            let given = table.programme.as_deref().unwrap_or_default();
            let programme = RigProgramme::from_name(given)
                .ok_or_else(|| at.refuse("source.programme", format!("{given:?}"), RigProgramme::NAMES))?;
            let (seed, repeat) = (table.seed.unwrap_or(1), table.repeat.unwrap_or(true));
            Ok(Source::Rig { programme, seed, speed, repeat })
        }
        SourceKind::Replay => {
            let patterns = table.runs.clone().unwrap_or_default();
            if patterns.is_empty() {
                return Err(at.refuse("source.runs", "absent", "recordings, folders of them, or globs"));
            }
            let runs = runs::find(&patterns, &folder(at.file))
                .map_err(|problem| at.refuse("source.runs", problem, "what finds recordings"))?;
            Ok(Source::Replay { runs, speed, repeat: table.repeat.unwrap_or(true) })
        }
    }
}

/// A scenario by its file, or by its name: `scenarios/NAME.toml` beside the config.
fn scenario(at: &ConfigText<'_>, given: &str) -> Result<Scenario, SettingsError> {
    let named = folder(at.file).join(SCENARIO_FOLDER).join(format!("{given}.toml"));
    let file = folder(at.file).join(given);
    let found = [named.clone(), file].into_iter().find(|path| path.is_file());
    match found {
        Some(path) => Ok(Scenario::read(&path)?),
        None if given == DEFAULT_SCENARIO_NAME => Ok(Scenario::parse(&named, DEFAULT_SCENARIO)?),
        None => {
            let allowed = format!("a scenario file, or the name of one in {SCENARIO_FOLDER}/");
            Err(at.refuse("source.scenario", format!("{given:?}"), allowed))
        }
    }
}

/// A key that another kind of source understands is as wrong as an unknown one.
fn check_keys_of_kind(at: &ConfigText<'_>, table: &SourceTable) -> Result<(), SettingsError> {
    let kind = table.kind;
    let keys = [
        ("source.scenario", table.scenario.is_some(), kind == SourceKind::Simulate),
        ("source.programme", table.programme.is_some(), kind == SourceKind::Rig),
        ("source.seed", table.seed.is_some(), matches!(kind, SourceKind::Simulate | SourceKind::Rig)),
        ("source.sample_rate_hz", table.sample_rate_hz.is_some(), kind == SourceKind::Simulate),
        ("source.runs", table.runs.is_some(), kind == SourceKind::Replay),
        ("source.loop", table.repeat.is_some(), matches!(kind, SourceKind::Replay | SourceKind::Rig)),
        ("source.speed", table.speed.is_some(), kind != SourceKind::Stdin),
    ];
    match keys.into_iter().find(|(_, given, fits)| *given && !fits) {
        None => Ok(()),
        Some((key, ..)) => {
            let kind = format!("{kind:?}").to_lowercase();
            Err(at.refuse(key, "given", format!("nothing here for kind = \"{kind}\"")))
        }
    }
}

pub(crate) fn folder(file: &Path) -> PathBuf {
    file.parent().map_or_else(PathBuf::new, Path::to_owned)
}
