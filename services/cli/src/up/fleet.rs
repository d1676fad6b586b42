//! All processes of one train, in the order in which they depend on each other.

use std::os::fd::BorrowedFd;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use railgrip_bus::{BusConfig, holder_pid};
use railgrip_settings::{Source, TrainSettings};

use super::unit::{News, STOP_PATIENCE, Unit};
use super::watchdog::Watchdog;
use crate::CliError;
use crate::reload::{Plan, Role, Way};

/// The holder itself waits for others to leave before it cleans up.
const HOLDER_STOP_PATIENCE: Duration = Duration::from_secs(8);
/// How long a new holder waits for an old one that is about to leave.
const HOLDER_START_PATIENCE: &str = "10";
const STOP_POLL: Duration = Duration::from_millis(5);

/// The holder and everything that lives on its channels.
pub(super) struct Fleet {
    program: PathBuf,
    bus: BusConfig,
    address_file: PathBuf,
    holder: Unit,
    others: Vec<Unit>,
}

impl Fleet {
    pub(super) fn new(
        bus: &BusConfig,
        settings: &TrainSettings,
        options: &[String],
    ) -> Result<Self, CliError> {
        let program = std::env::current_exe().map_err(CliError::failed)?;
        let mut sockets = (0..).map(|number: u32| settings.instance.dir.join(format!("notify-{number}")));
        let accepted = settings.instance.accepted_config();
        let mut unit = |role: Role, words: &[&str]| {
            let words = words.iter().map(|word| (*word).to_owned());
            let path = sockets.next().unwrap_or_default();
            let failed = |error| CliError::failed(format!("{}: {error}", path.display()));
            let watchdog = Watchdog::listen(path.clone()).map_err(failed)?;
            let words = words.chain(options.iter().cloned()).collect();
            Ok::<_, CliError>(Unit::new(role, words, accepted.clone(), watchdog))
        };
        let reads_stdin = settings.source == Source::Stdin;
        let mut others = vec![unit(Role::Health, &["health"])?];
        for wagon in &bus.wagons {
            let number = wagon.to_string();
            others.push(unit(Role::Estimator(*wagon), &["estimator", "--wagon", &number])?);
        }
        if settings.judged_together {
            others.push(unit(Role::Judge, &["judge"])?);
        }
        for wagon in &bus.microphones {
            let number = wagon.to_string();
            others.push(unit(Role::Listener(*wagon), &["listener", "--wagon", &number])?);
        }
        if settings.source != Source::External {
            others.push(unit(Role::Ingest, &["ingest"])?.with_stdin(reads_stdin).may_finish());
        }
        // Nobody waits for it, and everybody who starts before ingest keeps the figures waiting.
        if settings.diagnosis.automatic {
            others.push(unit(Role::Diagnoser, &["diagnoser"])?);
        }
        let address_file = settings.instance.http_address_file();
        let _ = std::fs::remove_file(&address_file);
        Ok(Self {
            program,
            bus: bus.clone(),
            address_file,
            holder: unit(Role::Holder, &["hold", "--patience", HOLDER_START_PATIENCE])?,
            others,
        })
    }

    /// Looks at every process once and starts what is due by `now`.
    pub(super) fn look(&mut self, now: Instant) -> Result<(), CliError> {
        match self.holder.look(now)? {
            News::Refused => return Err(refused(&self.holder)),
            News::Died | News::Finished => self.start_over(),
            News::None => {}
        }
        self.holder.start_if_due(now, &self.program)?;
        let held = self.holder.pid().is_some() && holder_pid(&self.bus) == self.holder.pid();
        for unit in &mut self.others {
            if unit.look(now)? == News::Refused {
                return Err(refused(unit));
            }
            if held {
                unit.start_if_due(now, &self.program)?;
            }
        }
        self.renew_next();
        Ok(())
    }

    /// When the next process is due after `now`. One that is due already waits for the holder, whose word will wake us.
    pub(super) fn due_after(&self, now: Instant) -> Option<Instant> {
        self.units().filter_map(Unit::due).filter(|due| *due > now).min()
    }

    /// Where the processes say how they are.
    pub(super) fn sockets(&self) -> impl Iterator<Item = BorrowedFd<'_>> {
        self.units().map(Unit::socket)
    }

    fn units(&self) -> impl Iterator<Item = &Unit> {
        std::iter::once(&self.holder).chain(&self.others)
    }

    /// Has everybody follow another config: at once who can, the others one after another.
    pub(super) fn follow(&mut self, plan: &Plan) {
        for unit in std::iter::once(&mut self.holder).chain(&mut self.others) {
            match plan.way(unit.role()) {
                Some(Way::Live) => unit.tell(),
                Some(Way::Restart) => unit.wait_for_renewal(),
                None => {}
            }
        }
    }

    /// Starts the next one again once the one before is ready: never are two away for that.
    fn renew_next(&mut self) {
        if self.others.iter().any(Unit::is_renewed) {
            return;
        }
        if let Some(unit) = self.others.iter_mut().find(|unit| unit.waits_for_renewal()) {
            unit.renew();
        }
    }

    /// The channels are gone with their holder: everybody stops and starts again on new ones. Who is slow to stop holds up
    /// nobody else: a new holder waits itself until the old channels have no users.
    fn start_over(&mut self) {
        tracing::warn!("the channels are gone with their holder; every process starts again");
        self.others.iter_mut().rev().for_each(Unit::start_again);
    }

    /// Stops all in order, or at once as soon as `asked_again`; true if nobody had to be killed.
    pub(super) fn stop(&mut self, asked_again: &AtomicBool) -> bool {
        let others = self.stop_others(asked_again);
        self.holder.terminate();
        let holder = wait_for(std::slice::from_mut(&mut self.holder), HOLDER_STOP_PATIENCE, asked_again);
        let _ = std::fs::remove_file(&self.address_file);
        others && holder
    }

    fn stop_others(&mut self, asked_again: &AtomicBool) -> bool {
        self.others.iter_mut().rev().for_each(Unit::terminate);
        wait_for(&mut self.others, STOP_PATIENCE, asked_again)
    }

    /// Fails if a process keeps dying.
    pub(super) fn verdict(&self) -> Result<(), CliError> {
        let crashing: Vec<String> = self
            .units()
            .filter(|unit| unit.crashing())
            .map(|unit| format!("{} died {} times in a row", unit.name(), unit.deaths()))
            .collect();
        if crashing.is_empty() { Ok(()) } else { Err(CliError::failed(crashing.join("; "))) }
    }
}

fn refused(unit: &Unit) -> CliError {
    CliError::bad_input(format!("{} refuses its input or config; see above", unit.name()))
}

/// Waits until all are gone and kills who is not by then, or at once when `asked_again`; true if nobody had to be killed.
fn wait_for(units: &mut [Unit], patience: Duration, asked_again: &AtomicBool) -> bool {
    let deadline = Instant::now() + patience;
    while Instant::now() < deadline && !asked_again.load(Ordering::Acquire) {
        if units.iter_mut().all(Unit::gone) {
            return true;
        }
        std::thread::sleep(STOP_POLL);
    }
    units.iter_mut().for_each(Unit::kill);
    false
}
