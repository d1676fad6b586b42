//! One supervised process.

use std::os::fd::BorrowedFd;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

use super::restart::Restarts;
use super::watchdog::{self, Watchdog};
use crate::reload::Role;
use crate::supervisor::SUPERVISOR_VARIABLE;
use crate::train::ACCEPTED_VARIABLE;
use crate::{CliError, own_effects};

/// How long a process may take to end in order.
pub(super) const STOP_PATIENCE: Duration = Duration::from_secs(5);

/// What became of a process since the last look.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum News {
    /// Nothing to tell.
    None,
    /// It died (or ended against expectation) and waits to be started again.
    Died,
    /// It did all its work and ended.
    Finished,
    /// It refused its config.
    Refused,
}

/// Where a process stands on its way to another config.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Renewal {
    /// It goes by the config that holds.
    None,
    /// Its turn has not come.
    Waits,
    /// Its turn has come, and it is not ready by the new config yet.
    Runs,
}

/// One process, started again when it dies.
pub(super) struct Unit {
    role: Role,
    name: String,
    options: Vec<String>,
    /// File with what the config says.
    accepted: PathBuf,
    stdin: bool,
    may_finish: bool,
    child: Option<Child>,
    watchdog: Watchdog,
    started: Option<Instant>,
    next_start: Option<Instant>,
    restarts: Restarts,
    /// It has been ready once: its config and input were sound.
    worked: bool,
    renewal: Renewal,
    /// When it was asked to end in order to start again.
    leaves: Option<Instant>,
    /// It shall read the config again as soon as it can.
    tell: bool,
}

impl Unit {
    pub(super) fn new(role: Role, options: Vec<String>, accepted: PathBuf, watchdog: Watchdog) -> Self {
        Self {
            role,
            name: role.to_string(),
            options,
            accepted,
            stdin: false,
            may_finish: false,
            child: None,
            watchdog,
            started: None,
            next_start: Some(Instant::now()),
            restarts: Restarts::default(),
            worked: false,
            renewal: Renewal::None,
            leaves: None,
            tell: false,
        }
    }

    pub(super) const fn role(&self) -> Role {
        self.role
    }

    /// The process reads our standard input.
    pub(super) fn with_stdin(mut self, stdin: bool) -> Self {
        self.stdin = stdin;
        self
    }

    /// The process may end without being asked to, when its source ends.
    pub(super) fn may_finish(mut self) -> Self {
        self.may_finish = true;
        self
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Process id while it runs.
    pub(super) fn pid(&self) -> Option<u32> {
        self.child.as_ref().map(Child::id)
    }

    /// True if it keeps dying.
    pub(super) fn crashing(&self) -> bool {
        self.restarts.still_crashing(self.child.as_ref().and(self.started))
    }

    pub(super) fn deaths(&self) -> u32 {
        self.restarts.deaths()
    }

    /// Starts the process if it is due. It leads a process group of its own, so that Ctrl-C in a terminal reaches the
    /// supervisor only, which then stops all in order.
    pub(super) fn start_if_due(&mut self, now: Instant, program: &Path) -> Result<(), CliError> {
        if self.child.is_some() || self.next_start.is_none_or(|due| now < due) {
            return Ok(());
        }
        self.watchdog.begin();
        let stdin = if self.stdin { Stdio::inherit() } else { Stdio::null() };
        let child = Command::new(program)
            .args(&self.options)
            .env(SUPERVISOR_VARIABLE, std::process::id().to_string())
            .env("NOTIFY_SOCKET", self.watchdog.path())
            .env("WATCHDOG_USEC", watchdog::LIMIT.as_micros().to_string())
            .env_remove("WATCHDOG_PID")
            .env(ACCEPTED_VARIABLE, &self.accepted)
            .envs(own_effects::environment())
            .stdin(stdin)
            .process_group(0)
            .spawn()
            .map_err(|error| CliError::failed(format!("cannot start {}: {error}", self.name)))?;
        tracing::debug!(process = self.name, pid = child.id(), "started");
        self.child = Some(child);
        self.started = Some(Instant::now());
        self.next_start = None;
        // What it reads as it starts is the newest.
        self.tell = false;
        if self.renewal != Renewal::None {
            self.renewal = Renewal::Runs;
        }
        Ok(())
    }

    /// Looks whether the process still runs. One that hangs is killed, and has died at the next look.
    pub(super) fn look(&mut self, now: Instant) -> Result<News, CliError> {
        let Some(child) = &mut self.child else { return Ok(News::None) };
        self.watchdog.listen_now();
        if self.watchdog.ready().is_some() {
            self.worked = true;
            if std::mem::take(&mut self.tell) {
                let _ = kill_process(Pid::from_child(child), Signal::HUP);
            }
            if self.renewal == Renewal::Runs && self.leaves.is_none() {
                self.renewal = Renewal::None;
                tracing::info!(process = self.name, "works by the new config");
            }
        }
        if self.leaves.is_some_and(|asked| asked.elapsed() > STOP_PATIENCE) {
            tracing::warn!(process = self.name, "does not stop; killed");
            let _ = child.kill();
        }
        if let Some(silent) = self.watchdog.silent() {
            tracing::warn!(process = self.name, silent_s = silent.as_secs_f64(), "hangs; killed");
            self.watchdog.begin();
            let _ = child.kill();
        }
        let Some(status) = child.try_wait().map_err(CliError::failed)? else { return Ok(News::None) };
        self.child = None;
        if self.leaves.take().is_some() {
            self.next_start = Some(now);
            return Ok(News::None);
        }
        if status.success() && self.may_finish {
            tracing::info!(process = self.name, "finished");
            self.renewal = Renewal::None;
            return Ok(News::Finished);
        }
        if status.code() == Some(2) {
            if !self.worked {
                return Ok(News::Refused);
            }
            // A train that runs is not given up because a file that it needs was changed meanwhile.
            tracing::error!(
                process = self.name,
                "refuses its input or config, which it took before; see above"
            );
        }
        self.report(status, now);
        Ok(News::Died)
    }

    fn report(&mut self, status: ExitStatus, now: Instant) {
        let lived = self.started.map_or(Duration::ZERO, |started| started.elapsed());
        let worked = self.watchdog.ready().map_or(Duration::ZERO, |ready| ready.elapsed());
        let pause = self.restarts.died(lived, worked);
        self.next_start = Some(now + pause);
        let (process, lived_s, pause_s) = (&self.name, lived.as_secs_f64(), pause.as_secs_f64());
        if self.restarts.crash_loop() {
            let deaths = self.restarts.deaths();
            tracing::error!(process, %status, deaths, pause_s, "keeps dying; its log says why");
        } else {
            tracing::warn!(process, %status, lived_s, pause_s, "died; will be started again");
        }
    }

    /// Asks the process to end.
    pub(super) fn terminate(&mut self) {
        self.next_start = None;
        if let Some(child) = &self.child {
            let _ = kill_process(Pid::from_child(child), Signal::TERM);
        }
    }

    /// Has the process read the config again, once it works; one that starts later reads it anyway.
    pub(super) fn tell(&mut self) {
        self.tell = self.child.is_some();
    }

    /// Has the process started again on another config when its turn comes. One that has been, and does not get ready, may be
    /// helped by that.
    pub(super) fn wait_for_renewal(&mut self) {
        self.renewal = Renewal::Waits;
    }

    /// True until its turn comes.
    pub(super) fn waits_for_renewal(&self) -> bool {
        self.renewal == Renewal::Waits
    }

    /// True while it is being started again.
    pub(super) fn is_renewed(&self) -> bool {
        self.renewal == Renewal::Runs
    }

    /// Its turn has come.
    pub(super) fn renew(&mut self) {
        tracing::info!(process = self.name, "starts again, by the new config");
        self.renewal = Renewal::Runs;
        self.start_again();
    }

    /// Asks the process to end, and has it started again as soon as it has, or if it does not run.
    pub(super) fn start_again(&mut self) {
        match &self.child {
            Some(child) => {
                self.leaves.get_or_insert_with(Instant::now);
                let _ = kill_process(Pid::from_child(child), Signal::TERM);
            }
            None => self.next_start = Some(Instant::now()),
        }
    }

    /// When the process is to be started, if it does not run and is to be.
    pub(super) fn due(&self) -> Option<Instant> {
        self.next_start
    }

    /// Can be read as soon as the process has said something.
    pub(super) fn socket(&self) -> BorrowedFd<'_> {
        self.watchdog.socket()
    }

    /// True once the process is gone.
    pub(super) fn gone(&mut self) -> bool {
        self.watchdog.listen_now();
        match &mut self.child {
            None => true,
            Some(child) => match child.try_wait() {
                Ok(None) => false,
                _ => {
                    self.child = None;
                    true
                }
            },
        }
    }

    /// Ends a process that did not want to; one that has ended meanwhile, unnoticed because of another, is left in peace.
    pub(super) fn kill(&mut self) {
        if self.gone() {
            return;
        }
        if let Some(mut child) = self.child.take() {
            tracing::warn!(process = self.name, "does not stop; killed");
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}
