//! The config that a running train goes by: accepted once it is sound, kept for its processes, read again on SIGHUP.

use std::io::ErrorKind;
use std::net::{SocketAddr, TcpListener};
use std::path::{Path, PathBuf};

use railgrip_bus::Lifecycle;
use railgrip_settings::TrainSettings;

use super::fleet::Fleet;
use crate::reload::{Again, Hangup, read_again, refuse};
use crate::train::{Train, TrainArgs};
use crate::{CliError, logging};

/// What the train goes by.
pub(super) struct Config<'a> {
    args: &'a TrainArgs,
    settings: TrainSettings,
    /// File with the text of the config for the processes.
    accepted: PathBuf,
    hangup: Hangup,
}

impl<'a> Config<'a> {
    /// Goes by the config that was read.
    pub(super) fn accept(args: &'a TrainArgs, train: &Train) -> Result<Self, CliError> {
        let accepted = train.settings.instance.accepted_config();
        write_whole(&accepted, &train.text)?;
        Ok(Self { args, settings: train.settings.clone(), accepted, hangup: Hangup::listen()? })
    }

    /// Reads the config again if it was asked to, and has the train follow it.
    pub(super) fn look(&mut self, fleet: &mut Fleet, lifecycle: &Lifecycle) {
        if !self.hangup.asked(lifecycle) {
            return;
        }
        let again = match read_again(self.args, &self.settings) {
            Ok(again) => again,
            Err(problems) => return refuse(&problems),
        };
        if let Err(error) = self.take(again, fleet) {
            refuse(&[error.to_string()]);
        }
    }

    fn take(&mut self, again: Again, fleet: &mut Fleet) -> Result<(), CliError> {
        let Again { settings, text, plan } = again;
        if settings.http.listen != self.settings.http.listen {
            check_address(settings.http.listen)?;
        }
        write_whole(&self.accepted, &text)?;
        logging::set_level(&settings.logging.level);
        self.settings = settings;
        let changed = plan.keys().join(", ");
        if changed.is_empty() {
            tracing::info!("the config was read again and says nothing new");
        } else {
            tracing::info!(changed, "the config was read again and is followed");
        }
        fleet.follow(&plan);
        Ok(())
    }
}

impl Drop for Config<'_> {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.accepted);
    }
}

/// Says at once that the address is somebody else's: the HTTP service would try again and again, and nobody would see why.
pub(super) fn check_address(listen: SocketAddr) -> Result<(), CliError> {
    match TcpListener::bind(listen) {
        Err(error) if matches!(error.kind(), ErrorKind::AddrInUse | ErrorKind::AddrNotAvailable) => {
            Err(CliError::failed(format!(
                "{listen}: {error}; choose another with --listen ADDRESS:PORT, port 0 for any free one"
            )))
        }
        // Whatever else is wrong may pass; the service says so itself.
        _ => Ok(()),
    }
}

/// Writes beside and renames, so that no process reads half of it.
fn write_whole(path: &Path, text: &str) -> Result<(), CliError> {
    let beside = path.with_extension("new");
    std::fs::write(&beside, text)
        .and_then(|()| std::fs::rename(&beside, path))
        .map_err(|error| CliError::failed(format!("{}: {error}", path.display())))
}
