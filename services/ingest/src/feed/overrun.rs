//! What found no room in the queue of a socket, as the kernel counts it: a sender whose receiver is too slow loses datagrams and
//! frames without a sign.

use super::Tally;
use railgrip_messages::SourceCount;
use socketcan::SocketOptions;
use std::io::ErrorKind;
use std::os::fd::{AsFd, AsRawFd, BorrowedFd, RawFd};
use std::time::{Duration, Instant};

/// The kernel is asked this often; a socket that is read must not wait longer than that.
pub(super) const PERIOD: Duration = Duration::from_secs(1);
/// Room for what waits in a socket, bytes; the system may give less.
pub(super) const ROOM: usize = 4 << 20;
/// `SOL_SOCKET`, `SO_MEMINFO` of Linux, the size of what that gives, and where in it the losses stand.
const MEMORY_OF_SOCKET: (i32, i32) = (1, 55);
const MEMORY_BYTES: usize = 36;
const DROPS_AT: usize = 32;

/// Follows the losses of one socket.
#[derive(Debug)]
pub(super) struct Overruns {
    counted: u32,
    asked: Instant,
}

/// Any socket, as far as its options go.
struct Options<'a>(BorrowedFd<'a>);

impl AsRawFd for Options<'_> {
    fn as_raw_fd(&self) -> RawFd {
        self.0.as_raw_fd()
    }
}

impl SocketOptions for Options<'_> {}

impl Overruns {
    /// Of a socket that was just opened.
    pub fn new() -> Self {
        Self { counted: 0, asked: Instant::now() }
    }

    /// Counts what was lost since the last time, if it is time to ask again.
    pub fn look(&mut self, socket: &impl AsFd, tally: &Tally) {
        if self.asked.elapsed() < PERIOD {
            return;
        }
        self.asked = Instant::now();
        let now = losses(socket.as_fd()).unwrap_or(self.counted);
        tally.add(SourceCount::Overrun, u64::from(now.wrapping_sub(self.counted)));
        self.counted = now;
    }
}

/// True if a socket only had nothing to give for a while.
pub(super) fn is_pause(error: &std::io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}

/// What was lost since the socket was opened, modulo 2³².
fn losses(socket: BorrowedFd<'_>) -> Option<u32> {
    let mut memory = [0; MEMORY_BYTES];
    let (level, name) = MEMORY_OF_SOCKET;
    let filled = Options(socket).get_socket_option_bytes(level, name, &mut memory).ok()?;
    let bytes = memory.get(DROPS_AT..filled)?.first_chunk()?;
    Some(u32::from_ne_bytes(*bytes))
}
