//! What every long-running process needs around its work: signals, the death of its supervisor, systemd.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::Thread;
use std::time::{Duration, Instant};

use railgrip_bus::Lifecycle;
use rustix::process::{Signal, getppid, set_parent_process_death_signal};
use sd_notify::NotifyState;
use signal_hook::consts::{SIGINT, SIGTERM};

use crate::CliError;
use crate::reload::{Follower, Member};
use crate::supervisor::{SUPERVISOR_VARIABLE, is_supervised};

/// How often the end, beats and a changed config are looked at, at least.
const NOTIFY_PERIOD: Duration = Duration::from_millis(250);

/// Runs `work` until it ends by itself or a signal asks it to. A second signal ends the process at once. A `member` of a train
/// reads its config again on SIGHUP.
pub(crate) fn run<E: Into<CliError>>(
    member: Option<Member<'_>>,
    work: impl FnOnce(&Lifecycle) -> Result<(), E>,
) -> Result<(), CliError> {
    let lifecycle = prepare()?;
    let follower = member.map(Follower::new).transpose()?;
    std::thread::scope(|scope| {
        let mut done = StopWhenDropped { done: Lifecycle::new(), thread: None };
        if follower.is_some() || std::env::var_os("NOTIFY_SOCKET").is_some() {
            let (lifecycle, until) = (lifecycle.clone(), done.done.clone());
            let thread = scope.spawn(move || attend(&lifecycle, &until, follower));
            done.thread = Some(thread.thread().clone());
        }
        work(&lifecycle).map_err(Into::into)
    })
}

/// Stops a thread at once when it goes, also while a panic unwinds.
struct StopWhenDropped {
    done: Lifecycle,
    thread: Option<Thread>,
}

impl Drop for StopWhenDropped {
    fn drop(&mut self) {
        self.done.stop();
        if let Some(thread) = &self.thread {
            thread.unpark();
        }
    }
}

/// Signals and the supervisor's death set the stop flag of the lifecycle that this returns.
fn prepare() -> Result<Lifecycle, CliError> {
    keep_to_oneself();
    let lifecycle = Lifecycle::new();
    for signal in [SIGTERM, SIGINT] {
        // A supervisor has means of its own against a process that does not end, and may ask twice; what is half done then, such
        // as a snapshot or the channels' removal, is done.
        if !is_supervised() {
            signal_hook::flag::register_conditional_shutdown(signal, 128 + signal, lifecycle.stop_flag())
                .map_err(unhandled)?;
        }
        signal_hook::flag::register(signal, lifecycle.stop_flag()).map_err(unhandled)?;
    }
    follow_supervisor(&lifecycle)?;
    Ok(lifecycle)
}

/// The same for a supervisor, who leaves nobody behind however often it is asked to end: each signal sets the second flag too.
pub(crate) fn prepare_to_supervise() -> Result<(Lifecycle, Arc<AtomicBool>), CliError> {
    keep_to_oneself();
    let (lifecycle, again) = (Lifecycle::new(), Arc::new(AtomicBool::new(false)));
    for signal in [SIGTERM, SIGINT] {
        for flag in [lifecycle.stop_flag(), Arc::clone(&again)] {
            signal_hook::flag::register(signal, flag).map_err(unhandled)?;
        }
    }
    Ok((lifecycle, again))
}

/// History, alerts, recordings and logs tell of a train's operation: what a service writes is for its own user, as systemd's
/// `UMask=0077` has it.
fn keep_to_oneself() {
    rustix::process::umask(rustix::fs::Mode::RWXG | rustix::fs::Mode::RWXO);
}

fn unhandled(error: std::io::Error) -> CliError {
    CliError::failed(format!("cannot handle signals ({error})"))
}

/// The kernel sends SIGTERM when the supervisor dies, however it dies. If it died before we asked for that, we are
/// somebody else's child by now and stop at once.
fn follow_supervisor(lifecycle: &Lifecycle) -> Result<(), CliError> {
    let Some(supervisor) = std::env::var(SUPERVISOR_VARIABLE).ok().and_then(|text| text.parse::<i32>().ok())
    else {
        return Ok(());
    };
    set_parent_process_death_signal(Some(Signal::TERM))
        .map_err(|error| CliError::failed(format!("cannot follow the supervisor ({error})")))?;
    if getppid().map(|parent| parent.as_raw_nonzero().get()) != Some(supervisor) {
        lifecycle.stop_flag().store(true, Ordering::Release);
    }
    Ok(())
}

/// Looks after a service while it works: tells systemd, or `railgrip up`, that it is ready, that it makes progress and that it
/// stops; and reads its config again when asked to.
fn attend(lifecycle: &Lifecycle, until: &Lifecycle, mut follower: Option<Follower<'_>>) {
    let heard = std::env::var_os("NOTIFY_SOCKET").is_some();
    let tell = |state| {
        if heard {
            tell(&[state]);
        }
    };
    let watchdog = sd_notify::watchdog_enabled();
    let beat_period = watchdog.map(|limit| limit / 4);
    let period = beat_period.map_or(NOTIFY_PERIOD, |period| period.min(NOTIFY_PERIOD));
    lifecycle.wake_when_ready(std::thread::current());
    let (mut ready, mut stopping, mut beats) = (false, false, 0);
    let mut beaten = Instant::now();
    while !until.should_stop() {
        if lifecycle.is_ready() && !ready {
            ready = true;
            tell(NotifyState::Ready);
        }
        if lifecycle.should_stop() && !stopping {
            stopping = true;
            tell(NotifyState::Stopping);
        }
        let due = beat_period.is_some_and(|period| beaten.elapsed() >= period);
        if due && lifecycle.beats() != beats {
            (beats, beaten) = (lifecycle.beats(), Instant::now());
            tell(NotifyState::Watchdog);
        }
        if let Some(follower) = follower.as_mut().filter(|_| ready && !stopping) {
            follower.look(lifecycle);
        }
        std::thread::park_timeout(period);
    }
    if !stopping {
        tell(NotifyState::Stopping);
    }
}

fn tell(state: &[NotifyState<'_>]) {
    if let Err(error) = sd_notify::notify(state) {
        tracing::debug!(%error, "the supervisor does not listen");
    }
}
