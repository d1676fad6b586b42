//! What every long-running process needs around its work: signals, the death of its supervisor, systemd.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use railgrip_bus::Lifecycle;
use rustix::process::{Signal, getppid, set_parent_process_death_signal};
use sd_notify::NotifyState;
use signal_hook::consts::{SIGINT, SIGTERM};

use crate::CliError;

/// Names the process id of `railgrip up` to its children, so that none outlives it.
pub(crate) const SUPERVISOR_VARIABLE: &str = "RAILGRIP_SUPERVISOR_PID";
/// How often readiness and beats are looked at, at least.
const NOTIFY_PERIOD: Duration = Duration::from_millis(100);

/// True if `railgrip up` or systemd started this process and starts it again when it ends.
pub(crate) fn is_supervised() -> bool {
    std::env::var_os(SUPERVISOR_VARIABLE).is_some() || std::env::var_os("NOTIFY_SOCKET").is_some()
}

/// Runs `work` until it ends by itself or a signal asks it to. A second signal ends the process at once.
pub(crate) fn run<E: Into<CliError>>(work: impl FnOnce(&Lifecycle) -> Result<(), E>) -> Result<(), CliError> {
    let lifecycle = prepare()?;
    let notifier = Notifier::start(&lifecycle);
    let result = work(&lifecycle).map_err(Into::into);
    if let Some(notifier) = notifier {
        notifier.finish();
    }
    result
}

/// Signals and the supervisor's death set the stop flag of the lifecycle that this returns.
pub(crate) fn prepare() -> Result<Lifecycle, CliError> {
    let lifecycle = Lifecycle::new();
    for signal in [SIGTERM, SIGINT] {
        signal_hook::flag::register_conditional_shutdown(signal, 128 + signal, lifecycle.stop_flag())
            .and_then(|_| signal_hook::flag::register(signal, lifecycle.stop_flag()))
            .map_err(|error| CliError::failed(format!("cannot handle signals ({error})")))?;
    }
    follow_supervisor(&lifecycle)?;
    Ok(lifecycle)
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

/// Tells systemd, or `railgrip up`, that the service is ready, that it makes progress, and that it stops.
struct Notifier {
    thread: std::thread::JoinHandle<()>,
    done: Lifecycle,
}

impl Notifier {
    /// `None` unless somebody listens.
    fn start(lifecycle: &Lifecycle) -> Option<Self> {
        std::env::var_os("NOTIFY_SOCKET")?;
        let watchdog = sd_notify::watchdog_enabled();
        let beat_period = watchdog.map(|limit| limit / 4);
        let period = beat_period.map_or(NOTIFY_PERIOD, |period| period.min(NOTIFY_PERIOD));
        let done = Lifecycle::new();
        let (lifecycle, until) = (lifecycle.clone(), done.clone());
        let thread = std::thread::spawn(move || {
            let (mut ready, mut stopping, mut beats) = (false, false, 0);
            let mut beaten = Instant::now();
            while !until.should_stop() {
                if lifecycle.is_ready() && !ready {
                    ready = true;
                    tell(&[NotifyState::Ready]);
                }
                if lifecycle.should_stop() && !stopping {
                    stopping = true;
                    tell(&[NotifyState::Stopping]);
                }
                let due = beat_period.is_some_and(|period| beaten.elapsed() >= period);
                if due && lifecycle.beats() != beats {
                    (beats, beaten) = (lifecycle.beats(), Instant::now());
                    tell(&[NotifyState::Watchdog]);
                }
                std::thread::sleep(period);
            }
            if !stopping {
                tell(&[NotifyState::Stopping]);
            }
        });
        Some(Self { thread, done })
    }

    fn finish(self) {
        self.done.stop();
        let _ = self.thread.join();
    }
}

fn tell(state: &[NotifyState<'_>]) {
    if let Err(error) = sd_notify::notify(state) {
        tracing::debug!(%error, "the supervisor does not listen");
    }
}
