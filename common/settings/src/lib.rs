//! Config files: read, checked once, and turned into types that the services trust.
//!
//! A train's config ([`TrainSettings`]) names the wagons, where their samples come from and how each process behaves;
//! a [`vehicle`] file says what a wagon is. Unknown keys are refused, units stand in the keys, and every error names
//! file, line, key, value and what is allowed. The defaults are those of `config/railgrip.toml`, which is built in.

mod access;
mod alerts;
mod capability;
mod consist;
mod diagnosis;
mod error;
mod fieldbus;
mod file;
mod form;
mod history;
mod identity;
mod instance;
mod mapping;
mod microphones;
mod mistakes;
mod nominal;
mod overrides;
pub mod own_effects;
mod place;
pub mod plant;
mod receivers;
mod reference;
mod runs;
mod source;
mod topics;
mod train;
pub mod vehicle;
mod wagons;

pub use access::{AccessLimits, AccessSettings, AuditSettings, TlsFiles, is_loopback};
pub use alerts::AlertSettings;
pub use capability::CapabilitySettings;
pub use consist::{RecordedTrain, RecordedWagon};
pub use diagnosis::DiagnosisSettings;
pub use error::SettingsError;
pub use fieldbus::{CanLog, CanSource, Messages, TrdpSource};
pub use file::LogFormat;
pub use history::{HistorySettings, TierLimits};
pub use identity::VehicleNumber;
pub use instance::Instance;
pub use microphones::{AcousticSettings, AudioSource, MicrophoneSettings};
pub use mistakes::{examine, mistakes, wrong_file};
pub use nominal::nominal;
pub use overrides::Overrides;
pub use plant::{BrakeController, RigProgramme};
pub use receivers::{
    BrokerTls, MqttSettings, NotifySettings, ReceiverSettings, ReceiverWay, WebhookSettings, has_login,
};
pub use reference::{Key, keys, reference};
pub use runs::ReplayRun;
pub use source::{MqttSource, Source, Subjects};
pub use topics::{Meaning, OfWagon, TopicPattern, Topics, WantedInputs};
pub use train::{HttpSettings, LoggingSettings, ReportingSettings, TrainSettings};
pub use wagons::{MAX_WAGONS, WagonSettings};
