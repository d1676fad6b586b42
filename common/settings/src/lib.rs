//! Config files: read, checked once, and turned into types that the services trust.
//!
//! A train's config ([`TrainSettings`]) names the wagons, where their samples come from and how each process behaves;
//! a [`vehicle`] file says what a wagon is. Unknown keys are refused, units stand in the keys, and every error names
//! file, line, key, value and what is allowed. The defaults are those of `config/railgrip.toml`, which is built in.

mod error;
mod file;
mod instance;
mod place;
mod runs;
mod train;
pub mod vehicle;

pub use error::SettingsError;
pub use file::LogFormat;
pub use instance::Instance;
pub use runs::ReplayRun;
pub use train::{
    AlertSettings, HttpSettings, LoggingSettings, MAX_WAGONS, Overrides, ReportingSettings, Source,
    TrainSettings, WagonSettings,
};
