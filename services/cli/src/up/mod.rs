//! `railgrip up`: a whole train on one command.
//!
//! The holder comes first and leaves last. The death of a process wakes the supervisor, which starts it again at once; while it keeps
//! dying, after a pause that grows. So is one that hangs (its watchdog hears nothing for ten seconds); if the holder dies, its channels are gone, so all others are stopped and everything starts anew. A process
//! that refuses its config (exit code 2) ends the whole: starting it again would change nothing.
//!
//! On SIGHUP the config is read again ([`crate::reload`]). Processes start by what was accepted last, not by what the file says
//! at the moment: one that dies while somebody edits comes back as it was.
//!
//! # Glossary
//! * **bell**: what wakes the supervisor ([`bell::Bell`]).
//! * **unit**: one supervised process ([`unit::Unit`]).
//! * **fleet**: all units of a train ([`fleet::Fleet`]).

mod bell;
mod config;
mod fleet;
mod restart;
mod unit;
mod watchdog;

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::Path;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use railgrip_bus::{Holder, Lifecycle, own_folder};
use railgrip_health::access::Access;
use railgrip_settings::{Source, TrainSettings};
use rustix::io::Errno;
use rustix::process::{Pid, test_kill_process};

use crate::output::say;
use crate::train::TrainArgs;
use crate::{CliError, runner};
use bell::Bell;
use config::{Config, check_address};
use fleet::Fleet;

/// The supervisor looks at its children at least this often, for what does not ring: one that hangs.
const LONGEST_WAIT: Duration = Duration::from_millis(250);

/// How long a second `up` of the same train waits for the first to be gone.
const CLAIM_PATIENCE: Duration = Duration::from_millis(500);
/// How long it waits for what the first, which is dead, has left behind.
const HEIR_PATIENCE: Duration = Duration::from_secs(10);
const CLAIM_RETRY: Duration = Duration::from_millis(20);

/// Start a whole train.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    #[command(flatten)]
    train: TrainArgs,
    /// End by itself after so many seconds
    #[arg(long = "for", value_name = "SECONDS")]
    seconds: Option<f64>,
}

pub(crate) fn run(args: &Args) -> Result<(), CliError> {
    let deadline = match args.seconds.map(Duration::try_from_secs_f64) {
        None => None,
        Some(Ok(seconds)) => Some(Instant::now() + seconds),
        Some(Err(_)) => return Err(CliError::bad_input("--for: allowed is a number of seconds, 0 or more")),
    };
    let train = args.train.load()?;
    train.bus.validate()?;
    let settings = &train.settings;
    Access::check(settings).map_err(CliError::bad_input)?;
    let _lock = claim(settings)?;
    check_address(settings.http.listen)?;
    settings.instance.begin_session().map_err(CliError::failed)?;
    let (lifecycle, asked_again) = runner::prepare_to_supervise()?;
    let mut config = Config::accept(&args.train, &train)?;
    // After everybody who acts on a signal, so that whoever is woken finds that it has been acted on.
    let bell = Bell::hang().map_err(|error| CliError::failed(format!("cannot handle signals ({error})")))?;
    let mut fleet = Fleet::new(&train.bus, settings, &args.train.to_options())?;
    let result = supervise(&mut fleet, &mut config, settings, &bell, &lifecycle, deadline);
    asked_again.store(false, Ordering::Release);
    let clean = fleet.stop(&asked_again);
    drop(config);
    Holder::sweep(&train.bus)?;
    result?;
    if clean { Ok(()) } else { Err(CliError::failed("a process had to be killed; see the log above")) }
}

fn supervise(
    fleet: &mut Fleet,
    config: &mut Config<'_>,
    settings: &TrainSettings,
    bell: &Bell,
    lifecycle: &Lifecycle,
    deadline: Option<Instant>,
) -> Result<(), CliError> {
    let address_file = settings.instance.http_address_file();
    let mut shown = false;
    while !lifecycle.should_stop() && deadline.is_none_or(|deadline| Instant::now() < deadline) {
        let now = Instant::now();
        fleet.look(now)?;
        config.look(fleet, lifecycle);
        if !shown && let Some(address) = http_address(&address_file) {
            shown = true;
            say(&welcome(settings, &address));
            lifecycle.ready();
        }
        lifecycle.beat();
        let next = fleet.due_after(now).into_iter().chain(deadline).min();
        let patience = next.map_or(LONGEST_WAIT, |next| next.saturating_duration_since(Instant::now()));
        bell.wait(fleet.sockets(), patience.min(LONGEST_WAIT)).map_err(CliError::failed)?;
    }
    fleet.verdict()
}

/// What a person wants to know once the train runs.
fn welcome(settings: &TrainSettings, address: &str) -> String {
    let source = match &settings.source {
        Source::Simulate { scenario, .. } => format!("simulated ({})", scenario.name),
        Source::Rig { programme, .. } => format!("simulated rigs ({})", programme.name()),
        Source::Replay { runs, .. } => format!("{} recordings", runs.len()),
        Source::Stdin => "the standard input".to_owned(),
        Source::Tcp(address) => format!("TCP connections to {address}"),
        Source::Udp(address) => format!("UDP datagrams to {address}"),
        Source::Mqtt(broker) => format!("the MQTT broker {}:{}", broker.host, broker.port),
        Source::Can(can) => match &can.log {
            Some(log) => format!("frames of {}", log.file.display()),
            None => format!("CAN {}", can.interfaces.join(", ")),
        },
        Source::Trdp(trdp) => format!("TRDP telegrams to {}", trdp.listen),
        Source::External => "other programs".to_owned(),
    };
    let address = if address.contains("://") { address.to_owned() } else { format!("http://{address}") };
    let curl = match settings.access.token_file {
        Some(_) => "curl -H \"Authorization: Bearer $RAILGRIP_TOKEN\"",
        None => "curl",
    };
    format!(
        "train \"{}\": {} wagons, samples from {source}\n  \
         look   {address}/\n  \
         wagons {curl} {address}/api/v1/wagons\n  \
         table  railgrip status\n  \
         stop   Ctrl-C",
        settings.name,
        settings.wagons.len()
    )
}

/// The address that the health service wrote.
fn http_address(file: &Path) -> Option<String> {
    let text = std::fs::read_to_string(file).ok()?;
    let address = text.trim();
    (!address.is_empty()).then(|| address.to_owned())
}

/// One `up` a train: a lock that the kernel releases however we die.
fn claim(settings: &TrainSettings) -> Result<File, CliError> {
    let dir = &settings.instance.dir;
    let path = dir.join("up.lock");
    let failed = |error: std::io::Error| CliError::failed(format!("{}: {error}", path.display()));
    own_folder(dir)?;
    let mut file =
        OpenOptions::new().create(true).truncate(false).read(true).write(true).open(&path).map_err(failed)?;
    if !take(&mut file).map_err(failed)? {
        return Err(already_up(settings, &mut file));
    }
    let write = file.set_len(0).and_then(|()| file.rewind());
    write.and_then(|()| writeln!(file, "{}", std::process::id())).map_err(failed)?;
    Ok(file)
}

/// Locks the file; false if somebody else keeps it. A predecessor that was killed between fork and exec of a child leaves the lock
/// with that child, and a busy machine may let it wait for seconds.
fn take(file: &mut File) -> std::io::Result<bool> {
    let began = Instant::now();
    loop {
        match file.try_lock() {
            Ok(()) => return Ok(true),
            Err(TryLockError::WouldBlock) => {}
            Err(TryLockError::Error(error)) => return Err(error),
        }
        let patience = if is_dead(&keeper(file)) { HEIR_PATIENCE } else { CLAIM_PATIENCE };
        if began.elapsed() >= patience {
            return Ok(false);
        }
        std::thread::sleep(CLAIM_RETRY);
    }
}

/// What the one who has the lock, or had it last, wrote into the file: its process id.
fn keeper(file: &mut File) -> String {
    let mut pid = String::new();
    let _ = file.rewind().and_then(|()| file.read_to_string(&mut pid));
    pid.trim().to_owned()
}

/// Whether no process has this id.
fn is_dead(pid: &str) -> bool {
    let pid = pid.parse().ok().and_then(Pid::from_raw);
    pid.is_some_and(|pid| test_kill_process(pid) == Err(Errno::SRCH))
}

fn already_up(settings: &TrainSettings, file: &mut File) -> CliError {
    let pid = keeper(file);
    CliError::failed(format!(
        "train \"{}\" is already up (process {pid}, folder {}); stop it first, or give this one another [train] name or \
         --instance folder",
        settings.name,
        settings.instance.dir.display()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lock_file(folder: &Path) -> File {
        let mut options = OpenOptions::new();
        options.create(true).truncate(false).read(true).write(true);
        options.open(folder.join("up.lock")).expect("a file")
    }

    #[test]
    fn a_child_that_a_dead_predecessor_left_the_lock_is_waited_for_and_a_living_one_is_told_soon() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut gone = std::process::Command::new("true").spawn().expect("a process");
        gone.wait().expect("its end");
        let mut first = lock_file(folder.path());
        first.try_lock().expect("nobody else");
        write!(first, "{}", gone.id()).expect("written");
        let heir = std::thread::spawn(move || {
            std::thread::sleep(3 * CLAIM_PATIENCE);
            drop(first);
        });
        let mut second = lock_file(folder.path());
        assert!(take(&mut second).expect("a lock"), "the child is gone by now");
        heir.join().expect("no panic");
        second.set_len(0).and_then(|()| second.rewind()).expect("emptied");
        write!(second, "{}", std::process::id()).expect("written");
        let began = Instant::now();
        assert!(!take(&mut lock_file(folder.path())).expect("a lock"), "this process lives");
        assert!(began.elapsed() < HEIR_PATIENCE / 2);
    }
}
