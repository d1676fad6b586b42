//! The watchdog of one process, in the words of systemd: the process is told a socket (`NOTIFY_SOCKET`) and a time
//! (`WATCHDOG_USEC`), says `READY=1` when it works, and then `WATCHDOG=1` while its loop goes round.

use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A process that works and has been silent for so long hangs.
pub(super) const LIMIT: Duration = Duration::from_secs(10);
/// Longest message of a process.
const MAX_MESSAGE: usize = 256;

/// What one process says of itself.
pub(super) struct Watchdog {
    socket: UnixDatagram,
    path: PathBuf,
    /// When it said that it works.
    ready: Option<Instant>,
    heard: Option<Instant>,
}

impl Watchdog {
    /// Listens at `path`, in a folder that only this user can open.
    pub(super) fn listen(path: PathBuf) -> io::Result<Self> {
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
        let socket = UnixDatagram::bind(&path)?;
        socket.set_nonblocking(true)?;
        Ok(Self { socket, path, ready: None, heard: None })
    }

    /// Where the process shall report.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Can be read as soon as the process has said something.
    pub(super) fn socket(&self) -> BorrowedFd<'_> {
        self.socket.as_fd()
    }

    /// A new process begins: it hangs only after it has said that it works.
    pub(super) fn begin(&mut self) {
        self.listen_now();
        (self.ready, self.heard) = (None, None);
    }

    /// Since when the process works, if it does.
    pub(super) fn ready(&self) -> Option<Instant> {
        self.ready
    }

    /// Takes in what the process has said. Nobody else reads it, and a process whose messages pile up would wait.
    pub(super) fn listen_now(&mut self) {
        let mut message = [0; MAX_MESSAGE];
        while let Ok(length) = self.socket.recv(&mut message) {
            let said = |word: &[u8]| message[..length].split(|byte| *byte == b'\n').any(|line| line == word);
            if said(b"READY=1") {
                self.ready = Some(Instant::now());
            }
            if said(b"READY=1") || (said(b"WATCHDOG=1") && self.heard.is_some()) {
                self.heard = Some(Instant::now());
            }
        }
    }

    /// How long the process has been silent, if that is too long.
    pub(super) fn silent(&self) -> Option<Duration> {
        self.heard.map(|heard| heard.elapsed()).filter(|silent| *silent > LIMIT)
    }
}

impl Drop for Watchdog {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_process_that_worked_can_hang() {
        let folder = tempfile::tempdir().expect("folder");
        let mut watchdog = Watchdog::listen(folder.path().join("notify-0")).expect("listen");
        let process = UnixDatagram::unbound().expect("socket");
        process.send_to(b"WATCHDOG=1\n", watchdog.path()).expect("sent");
        watchdog.listen_now();
        assert!(watchdog.heard.is_none(), "it has not said that it works");
        process.send_to(b"STATUS=x\nREADY=1\n", watchdog.path()).expect("sent");
        watchdog.listen_now();
        assert!(watchdog.heard.is_some() && watchdog.silent().is_none());
        watchdog.heard = Instant::now().checked_sub(2 * LIMIT);
        assert!(watchdog.silent().is_some());
        process.send_to(b"WATCHDOG=1\n", watchdog.path()).expect("sent");
        watchdog.listen_now();
        assert!(watchdog.silent().is_none(), "it is back");
        watchdog.heard = Instant::now().checked_sub(2 * LIMIT);
        watchdog.begin();
        assert!(watchdog.silent().is_none(), "its successor has said nothing yet");
    }
}
