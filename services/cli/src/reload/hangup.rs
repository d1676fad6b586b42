//! SIGHUP, which means two things: read the config again, or that the terminal is gone.

use std::io::{IsTerminal, stdin};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use railgrip_bus::Lifecycle;
use signal_hook::consts::SIGHUP;

use crate::CliError;

/// Listens for SIGHUP.
pub(crate) struct Hangup {
    asked: Arc<AtomicBool>,
    /// Somebody sat before it when it began.
    terminal: bool,
}

impl Hangup {
    /// From now on SIGHUP does not end this process any more.
    pub(crate) fn listen() -> Result<Self, CliError> {
        let asked = Arc::new(AtomicBool::new(false));
        signal_hook::flag::register(SIGHUP, Arc::clone(&asked))
            .map_err(|error| CliError::failed(format!("cannot handle signals ({error})")))?;
        Ok(Self { asked, terminal: stdin().is_terminal() })
    }

    /// True if the config is to be read again; of several signals since the last look, once. If the terminal is gone, the
    /// process ends, as it would have without this.
    pub(crate) fn asked(&self, lifecycle: &Lifecycle) -> bool {
        let asked = self.asked.swap(false, Ordering::AcqRel);
        if asked && self.terminal && !stdin().is_terminal() {
            lifecycle.stop();
            return false;
        }
        asked
    }
}
