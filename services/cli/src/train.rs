//! Which train a command speaks about: the options that all processes of one train share.

use std::net::SocketAddr;
use std::path::PathBuf;

use railgrip_bus::BusConfig;
use railgrip_settings::{Overrides, TrainSettings};

use crate::{CliError, logging, supervisor};

/// The options by which every process of a train finds the same settings.
#[derive(Debug, Clone, Default, clap::Args)]
pub(crate) struct TrainArgs {
    /// Config of the train [default: config/railgrip.toml, else built-in settings]
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Replay these recordings, one a wagon: files, folders or globs
    #[arg(long, value_name = "PATH", num_args = 1..)]
    runs: Vec<String>,
    /// Replay this recorded train once: a folder with train.toml, and a folder a wagon with vehicle.toml and run.csv
    #[arg(long, value_name = "TRAIN", conflicts_with = "runs")]
    train: Option<PathBuf>,
    /// Speed of simulation or replay: seconds of the run in one second
    #[arg(long, value_name = "FACTOR")]
    speed: Option<f64>,
    /// Serve HTTP here; port 0 takes any free one
    #[arg(long, value_name = "ADDRESS:PORT")]
    listen: Option<SocketAddr>,
    /// Keep channels and files of this running train here
    #[arg(long, value_name = "DIR")]
    instance: Option<PathBuf>,
}

/// The settings of a train, and the options that lead a child to the same ones.
pub(crate) struct Train {
    pub settings: TrainSettings,
    pub bus: BusConfig,
    /// What its config file says.
    pub text: String,
}

/// Names the file with the text of the config that `railgrip up` has accepted.
pub(crate) const ACCEPTED_VARIABLE: &str = "RAILGRIP_ACCEPTED_CONFIG";

impl TrainArgs {
    /// Reads and checks the settings, and starts logging as they say.
    pub(crate) fn load(&self) -> Result<Train, CliError> {
        let (file, text) = self.text()?;
        let settings = TrainSettings::parse(&file, &text, &self.overrides())?;
        logging::start(&settings.logging)?;
        let bus = BusConfig::of(&settings);
        Ok(Train { settings, bus, text })
    }

    /// The config file and what it says. For a process of `railgrip up` it says what `up` has accepted, whatever has happened to
    /// the file since.
    pub(crate) fn text(&self) -> Result<(PathBuf, String), CliError> {
        let accepted = std::env::var_os(ACCEPTED_VARIABLE)
            .filter(|_| supervisor::is_of_up())
            .and_then(|accepted| std::fs::read_to_string(accepted).ok());
        match (accepted, TrainSettings::text(self.config.as_deref())) {
            (Some(text), Ok((file, _))) => Ok((file, text)),
            (Some(text), Err(_)) => Ok((self.config.clone().unwrap_or_default(), text)),
            (None, read) => Ok(read?),
        }
    }

    /// What the command line changes in the settings.
    pub(crate) fn overrides(&self) -> Overrides {
        Overrides {
            runs: self.runs.clone(),
            train: self.train.clone(),
            speed: self.speed,
            listen: self.listen,
            instance_dir: self.instance.clone(),
        }
    }

    /// The same options again, for a child in the same working directory.
    pub(crate) fn to_options(&self) -> Vec<String> {
        let mut options = Vec::new();
        let mut add = |name: &str, value: String| options.extend([name.to_owned(), value]);
        if let Some(config) = &self.config {
            add("--config", config.display().to_string());
        }
        if let Some(train) = &self.train {
            add("--train", train.display().to_string());
        }
        if let Some(speed) = self.speed {
            add("--speed", speed.to_string());
        }
        if let Some(listen) = self.listen {
            add("--listen", listen.to_string());
        }
        if let Some(instance) = &self.instance {
            add("--instance", instance.display().to_string());
        }
        if !self.runs.is_empty() {
            options.push("--runs".to_owned());
            options.extend(self.runs.iter().cloned());
        }
        options
    }
}
