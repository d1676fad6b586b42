//! The settings of a train, checked once and then trusted everywhere.

use crate::access::AccessSettings;
use crate::alerts::AlertSettings;
use crate::capability::CapabilitySettings;
use crate::consist::RecordedTrain;
use crate::diagnosis::DiagnosisSettings;
use crate::file::{LogFormat, TrainFile, WagonTable};
use crate::history::HistorySettings;
use crate::mapping;
use crate::microphones::{self, AcousticSettings, MicrophoneSettings};
use crate::overrides::Overrides;
use crate::place::{ConfigText, folder, name};
use crate::receivers::{NotifySettings, ReceiverTables};
use crate::source::{Source, resolve, source};
use crate::wagons::{DEFAULT_CONFIG, WagonSettings, check_filter, wagons};
use crate::{SettingsError, form, instance::Instance};
use railgrip_filter::{ConfigError, EstimatorConfig, Plant};
use railgrip_indicators::IndicatorSettings;
use railgrip_recording::Mapping;
use railgrip_vehicle::Running;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

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
    /// Its wagons are judged together, by one process: they are coupled, so that none can be judged alone.
    pub judged_together: bool,
    /// The microphones; a wagon has one or none.
    pub microphones: Vec<MicrophoneSettings>,
    /// How they are listened to.
    pub acoustics: AcousticSettings,
    /// Where this instance keeps its channels and files.
    pub instance: Instance,
    /// Where samples come from.
    pub source: Source,
    /// What the source calls the columns of a run, and how it measures them.
    pub mapping: Mapping,
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
    /// Where alerts and the notification log are kept.
    pub alert_journal: PathBuf,
    /// How people are told of alerts.
    pub notify: NotifySettings,
    /// What full braking of this train is, and the adhesion map.
    pub capability: CapabilitySettings,
    /// Whether the train diagnoses by itself what its model does not explain.
    pub diagnosis: DiagnosisSettings,
    /// What is remembered.
    pub history: HistorySettings,
    /// Log lines.
    pub logging: LoggingSettings,
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

impl TrainSettings {
    /// Reads a config file; without one `config/railgrip.toml`, and where that is missing the same settings built in.
    ///
    /// # Errors
    /// The first thing that is wrong, with file, line, key and what is allowed.
    pub fn load(file: Option<&Path>, overrides: &Overrides) -> Result<Self, SettingsError> {
        let (path, text) = Self::text(file)?;
        Self::parse(&path, &text, overrides)
    }

    /// The config file that [`TrainSettings::load`] would parse, and what it says.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn text(file: Option<&Path>) -> Result<(PathBuf, String), SettingsError> {
        let path = file.unwrap_or(Path::new(DEFAULT_PATH)).to_owned();
        // Processes read it several times, and again on a signal: a pipe would block them.
        if std::fs::metadata(&path).is_ok_and(|found| !found.is_file() && !found.is_dir()) {
            let source = std::io::Error::other("is no plain file");
            return Err(SettingsError::Read { file: path, source });
        }
        match railgrip_recording::read_text(&path) {
            Ok(text) => Ok((path, text)),
            Err(error) if file.is_none() && error.kind() == std::io::ErrorKind::NotFound => {
                Ok((path, DEFAULT_CONFIG.to_owned()))
            }
            Err(source) => Err(SettingsError::Read { file: path, source }),
        }
    }

    /// Parses and checks the text of a config file; paths in it are relative to the folder of `file`.
    ///
    /// # Errors
    /// As [`TrainSettings::load`].
    pub fn parse(file: &Path, text: &str, overrides: &Overrides) -> Result<Self, SettingsError> {
        let at = ConfigText::new(file, text);
        let settings = Self::of(&at, overrides);
        match (at.into_found().into_iter().next(), settings) {
            (Some(first), _) => Err(first),
            (None, Some(settings)) => Ok(settings),
            (None, None) => Err(ConfigText::new(file, text).refuse("schema", "absent", "1")),
        }
    }

    /// The settings of a text; every mistake is noted in it. What is wrong is stood in for, so that no mistake hides another.
    pub(crate) fn of(at: &ConfigText<'_>, overrides: &Overrides) -> Option<Self> {
        let mut form: TrainFile = form::read(at)?;
        let recorded = match overrides.train.as_deref().map(RecordedTrain::read).transpose() {
            Ok(recorded) => recorded,
            Err(error) => {
                at.push(error);
                return None;
            }
        };
        if let Some(train) = &recorded {
            form.train.name.clone_from(&train.name);
            form.microphone.clear();
            let number =
                |number: &String| WagonTable { number: Some(number.clone()), ..WagonTable::default() };
            form.wagon = train.wagons.iter().map(|wagon| number(&wagon.number)).collect();
        }
        if !overrides.runs.is_empty() || recorded.is_some() {
            // There are as many wagons as recordings, whatever the config says of its own.
            form.train.wagons = None;
        }
        at.number("schema", f64::from(form.schema), 1.0..=1.0);
        let name = at.or(name(at, "train.name", &form.train.name), "x".to_owned());
        let mut source = at.or(source(at, &form.source, overrides, recorded.as_ref()), Source::External);
        check_estimator(at, &form.estimator);
        let mut wagons = wagons(at, &form, &source);
        let mapping = mapping::mapping(at, &form.mapping);
        let wheelsets: Vec<_> = wagons.iter().map(|wagon| wagon.vehicle.wheelsets()).collect();
        let unsure = ["source", "mapping", "train", "wagon"].iter().any(|table| at.doubts(table));
        if !unsure {
            at.or(resolve(at, &mut source, &mapping, &wheelsets), ());
        }
        let base = folder(at.file);
        let microphones = microphones::microphones(at, &form.microphone, wagons.len() as u32, &source, &base);
        let acoustics = form.acoustics.check(at, &base);
        for wrong in form.indicators.wrong() {
            at.note(at.refuse(&format!("indicators.{}", wrong.key), wrong.value, wrong.allowed));
        }
        let listen = overrides.listen.unwrap_or_else(|| listen(at, &form.http.listen));
        if let Source::Tcp(of_source) = &source
            && clash(*of_source, listen)
        {
            let allowed = "an address and port that [source] `listen` does not take";
            at.note(at.refuse("http.listen", listen, allowed));
        }
        let instance_dir = overrides.instance_dir.as_deref();
        let instance = Instance::of(at, &form.instance, &name, instance_dir);
        let instance = instance.map_err(|error| at.note(error)).ok()?;
        let history = HistorySettings::of(at, &form.history, &name, instance_dir);
        // The folder of an instance lies in memory, unless somebody says where it is.
        let lasting = instance.lasting_dir(instance_dir).unwrap_or(&history.dir);
        let access = AccessSettings::of(at, &form.http, listen, overrides.listen.is_some(), lasting);
        let judged_together =
            at.or(judged_together(at, form.train.coupled, recorded.is_some(), &wagons), false);
        let several = wagons.len() > 1;
        for (index, wagon) in wagons.iter_mut().enumerate().filter(|_| judged_together && several) {
            let free = recorded.as_ref().is_some_and(|train| !train.wagons[index].coupled);
            wagon.vehicle.train = Some(Running { free });
            let plant = Plant::Wagon(wagon.vehicle.clone());
            check_filter(at, wagon.number, wagon.filter.as_deref(), &form.estimator, &plant);
        }
        Some(Self {
            file: at.file.to_owned(),
            access,
            judged_together,
            wagons,
            microphones,
            acoustics,
            source,
            mapping,
            batch_s: at.number("samples.batch_ms", form.samples.batch_ms, 0.0..=1000.0) * 1e-3,
            estimator: form.estimator,
            reporting: ReportingSettings {
                snapshot_period_s: at.number(
                    "reporting.snapshot_period_s",
                    form.reporting.snapshot_period_s,
                    0.1..=60.0,
                ),
                health_rate_hz: at.number(
                    "reporting.health_rate_hz",
                    form.reporting.health_rate_hz,
                    0.2..=50.0,
                ),
            },
            indicators: form.indicators,
            http: HttpSettings {
                listen,
                refresh_s: at.number("http.refresh_ms", form.http.refresh_ms, 20.0..=5000.0) * 1e-3,
                stale_after_s: at.number("http.stale_after_s", form.http.stale_after_s, 0.2..=600.0),
                cors_origins: at.or(cors_origins(at, &form.http.cors_origins), Vec::new()),
            },
            alerts: form.alerts.check(at),
            alert_journal: form.alerts.journal(at, &history.dir),
            notify: ReceiverTables { receiver: form.receiver, notify: form.notify, delivery: form.delivery }
                .check(at, &name),
            capability: form.capability.check(at),
            diagnosis: form.diagnosis.check(at),
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

/// Notes what is wrong with `[estimator]`.
fn check_estimator(at: &ConfigText<'_>, estimator: &EstimatorConfig) {
    for wrong in estimator.wrong() {
        at.note(match wrong {
            ConfigError::OutOfRange { key, value, allowed } => {
                at.refuse(&format!("estimator.{key}"), value, allowed)
            }
            ConfigError::UnknownFilter { name, known } => {
                at.refuse("estimator.filter", format!("{name:?}"), known)
            }
        });
    }
}

/// The address that the HTTP service listens on.
fn listen(at: &ConfigText<'_>, given: &str) -> SocketAddr {
    let allowed = "ADDRESS:PORT, for example 127.0.0.1:8080";
    let parsed = given.parse().map_err(|_| at.refuse("http.listen", given, allowed));
    at.or(parsed, SocketAddr::from(([127, 0, 0, 1], 0)))
}

/// Whether two listeners of TCP cannot both have their address.
fn clash(a: SocketAddr, b: SocketAddr) -> bool {
    let everywhere = a.ip().is_unspecified() || b.ip().is_unspecified();
    a.port() != 0 && a.port() == b.port() && (everywhere || a.ip() == b.ip())
}

/// Whether the wagons are judged together: as the config says, else where every vehicle file says that its wagon runs
/// coupled. A recorded train always is, so that it is judged as `railgrip drill replay` does.
fn judged_together(
    at: &ConfigText<'_>,
    given: Option<bool>,
    recorded: bool,
    wagons: &[WagonSettings],
) -> Result<bool, SettingsError> {
    let are_wagons = wagons.iter().all(|wagon| matches!(wagon.plant, Plant::Wagon(_)));
    if given == Some(true) && !are_wagons {
        return Err(at.refuse("train.coupled", true, "false, as rigs are not coupled"));
    }
    let by_files = wagons.len() > 1 && wagons.iter().all(|wagon| wagon.vehicle.is_coupled());
    Ok(are_wagons && (recorded || given.unwrap_or(by_files)))
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
