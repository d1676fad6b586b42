//! What wakes the supervisor: the death of a child, a signal for itself, a word of a process to its watchdog. Between these it sleeps,
//! so that nothing that happens waits for the next look.

use std::io::{self, ErrorKind, Read};
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixStream;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;
use signal_hook::consts::{SIGCHLD, SIGHUP, SIGINT, SIGTERM};
use signal_hook::low_level::pipe;

/// Rings for signals; others may ring along.
pub(super) struct Bell {
    /// A byte for each signal, so that none is lost that comes while nobody listens.
    signals: UnixStream,
}

impl Bell {
    /// From now on signals ring. What they mean is left to whoever handles them besides.
    pub(super) fn hang() -> io::Result<Self> {
        let (signals, rung) = UnixStream::pair()?;
        signals.set_nonblocking(true)?;
        for signal in [SIGCHLD, SIGTERM, SIGINT, SIGHUP] {
            pipe::register(signal, rung.try_clone()?)?;
        }
        Ok(Self { signals })
    }

    /// Sleeps until it rings, one of `others` can be read, or the time is over; false if it is.
    pub(super) fn wait<'a>(
        &'a self,
        others: impl Iterator<Item = BorrowedFd<'a>>,
        patience: Duration,
    ) -> io::Result<bool> {
        let ends = std::iter::once(self.signals.as_fd()).chain(others);
        let mut ends: Vec<_> = ends.map(|end| PollFd::from_borrowed_fd(end, PollFlags::IN)).collect();
        let patience = Timespec::try_from(patience).map_err(|_| ErrorKind::InvalidInput)?;
        let rung = match poll(&mut ends, Some(&patience)) {
            // By a signal, which has rung all the same.
            Err(Errno::INTR) => 1,
            result => result?,
        };
        let mut bytes = [0; 64];
        while matches!((&self.signals).read(&mut bytes), Ok(count) if count > 0) {}
        Ok(rung > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::up::watchdog::Watchdog;
    use std::process::Command;

    const LONG: Duration = Duration::from_secs(60);

    #[test]
    fn deaths_signals_and_words_ring_and_nothing_else_does() {
        let folder = tempfile::tempdir().expect("folder");
        let watchdog = Watchdog::listen(folder.path().join("notify-0")).expect("listen");
        let bell = Bell::hang().expect("hung");
        let wait = |patience| bell.wait(std::iter::once(watchdog.socket()), patience).expect("usable");
        // Children of other tests may ring.
        let silent = || (0..1000).any(|_| !wait(Duration::from_millis(1)));
        assert!(silent(), "nothing has happened");
        let mut child = Command::new("cat").stdin(std::process::Stdio::piped()).spawn().expect("started");
        child.kill().expect("killed");
        assert!(wait(LONG), "a child has died");
        assert!(!child.wait().expect("waited for").success());
        signal_hook::low_level::raise(SIGHUP).expect("raised");
        assert!(wait(LONG), "a signal has come");
        assert!(silent(), "what has rung is over");
        let process = std::os::unix::net::UnixDatagram::unbound().expect("socket");
        process.send_to(b"READY=1", watchdog.path()).expect("sent");
        assert!(wait(LONG), "a process has said something");
    }
}
