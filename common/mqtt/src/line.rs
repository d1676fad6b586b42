//! The socket: whatever is done with it ends at a deadline, or soon after it is asked to stop.

use crate::MqttError;
use rustls::pki_types::ServerName;
use rustls::{ClientConfig, ClientConnection, StreamOwned};
use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::{Duration, Instant};

/// We look this often whether we shall stop.
const TURN: Duration = Duration::from_millis(200);

/// A socket with a deadline.
pub(crate) struct Line {
    socket: TcpStream,
    /// Until when.
    until: Instant,
    stop: Arc<AtomicBool>,
}

/// Why a line gave up, carried through what reads from it.
#[derive(Debug, thiserror::Error)]
enum GivenUp {
    #[error("out of time")]
    Late,
    #[error("stopped")]
    Stopped,
}

impl Line {
    fn patient(&self) -> io::Result<()> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(io::Error::other(GivenUp::Stopped));
        }
        if Instant::now() >= self.until {
            return Err(io::Error::other(GivenUp::Late));
        }
        Ok(())
    }

    /// Tries again and again, a turn each time.
    fn keep_trying<T>(&mut self, mut work: impl FnMut(&mut TcpStream) -> io::Result<T>) -> io::Result<T> {
        loop {
            self.patient()?;
            match work(&mut self.socket) {
                Err(error)
                    if matches!(
                        error.kind(),
                        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
                    ) => {}
                done => return done,
            }
        }
    }
}

impl Read for Line {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.keep_trying(|socket| socket.read(buffer))
    }
}

impl Write for Line {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        self.keep_trying(|socket| socket.write(buffer))
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// A line, plain or by TLS.
pub(crate) enum Stream {
    Plain(Line),
    Tls(Box<StreamOwned<ClientConnection, Line>>),
}

impl Stream {
    /// Reaches the host, and agrees on TLS where there is a config for it.
    pub fn open(
        host: &str,
        port: u16,
        tls: Option<Arc<ClientConfig>>,
        until: Instant,
        stop: &Arc<AtomicBool>,
    ) -> Result<Self, MqttError> {
        let name = ServerName::try_from(host).map(|name| name.to_owned());
        let mut line = Line { socket: reach(host, port, until, stop)?, until, stop: Arc::clone(stop) };
        let Some(config) = tls else { return Ok(Self::Plain(line)) };
        let name = name.map_err(|_| MqttError::Host(host.to_owned()))?;
        let mut session =
            ClientConnection::new(config, name).map_err(|error| MqttError::Tls(error.to_string()))?;
        while session.is_handshaking() {
            session.complete_io(&mut line).map_err(refusal)?;
        }
        Ok(Self::Tls(Box::new(StreamOwned::new(session, line))))
    }

    /// What is done from now on ends then.
    pub fn set_deadline(&mut self, until: Instant) {
        match self {
            Self::Plain(line) => line.until = until,
            Self::Tls(stream) => stream.sock.until = until,
        }
    }

    /// Reads what is there; waits for it.
    pub fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Plain(line) => line.read(buffer),
            Self::Tls(stream) => stream.read(buffer),
        }
    }

    /// Writes all of it.
    pub fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        match self {
            Self::Plain(line) => line.write_all(bytes),
            Self::Tls(stream) => {
                stream.write_all(bytes)?;
                stream.flush()
            }
        }
    }
}

/// What an error of a line means.
pub(crate) fn meaning(error: io::Error) -> MqttError {
    match error.get_ref().and_then(|inner| inner.downcast_ref::<GivenUp>()) {
        Some(GivenUp::Late) => MqttError::Late,
        Some(GivenUp::Stopped) => MqttError::Stopped,
        None if error.kind() == ErrorKind::UnexpectedEof => MqttError::Closed,
        None => MqttError::Socket(error),
    }
}

/// What it means that there is no TLS.
fn refusal(error: io::Error) -> MqttError {
    match error.get_ref().and_then(|inner| inner.downcast_ref::<rustls::Error>()) {
        Some(rustls::Error::InvalidCertificate(why)) => MqttError::Certificate(why.clone()),
        Some(other) => MqttError::Tls(other.to_string()),
        None if error.kind() == ErrorKind::UnexpectedEof => MqttError::Unanswered,
        None => meaning(error),
    }
}

/// Connects. The system's search for a name knows no deadline, so that it has a thread of its own, which nobody waits for longer.
fn reach(host: &str, port: u16, until: Instant, stop: &AtomicBool) -> Result<TcpStream, MqttError> {
    let (sender, receiver) = sync_channel(1);
    let host = host.to_owned();
    std::thread::Builder::new()
        .name("mqtt-dial".to_owned())
        .spawn(move || sender.send(dial(&host, port, until)))
        .map_err(MqttError::Socket)?;
    loop {
        match receiver.recv_timeout(TURN.min(until.saturating_duration_since(Instant::now()))) {
            Ok(dialled) => return dialled.map_err(MqttError::Socket),
            Err(_) if stop.load(Ordering::Relaxed) => return Err(MqttError::Stopped),
            Err(RecvTimeoutError::Timeout) if Instant::now() < until => {}
            Err(_) => return Err(MqttError::Socket(ErrorKind::TimedOut.into())),
        }
    }
}

/// Tries the addresses of a host one after another, each for its share of the time.
fn dial(host: &str, port: u16, until: Instant) -> io::Result<TcpStream> {
    let addresses: Vec<_> = (host, port).to_socket_addrs()?.collect();
    let mut failed = io::Error::new(ErrorKind::NotFound, "the host has no address");
    for (tried, address) in addresses.iter().enumerate() {
        let left = until.saturating_duration_since(Instant::now());
        let share = left / u32::try_from(addresses.len() - tried).unwrap_or(u32::MAX);
        if share.is_zero() {
            return Err(ErrorKind::TimedOut.into());
        }
        match TcpStream::connect_timeout(address, share) {
            Ok(socket) => {
                socket.set_nodelay(true)?;
                socket.set_read_timeout(Some(TURN))?;
                socket.set_write_timeout(Some(TURN))?;
                return Ok(socket);
            }
            Err(error) => failed = error,
        }
    }
    Err(failed)
}
