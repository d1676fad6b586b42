//! Clients that ask an HTTP service again as soon as they have an answer, as cheaply as a client can: plain sockets that
//! stay open, one buffer. What is measured is the service, not the client.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use crate::CliError;

/// What was measured.
#[derive(Debug, Clone, Copy, serde::Serialize)]
pub(crate) struct Load {
    pub requests_a_second: f64,
    pub p50_us: f64,
    pub p99_us: f64,
    /// Length of one answer, head included.
    pub answer_bytes: usize,
}

/// One open connection.
struct Client {
    stream: TcpStream,
    buffer: Vec<u8>,
    asked: Instant,
}

/// Asks for `path` with so many connections at once, all on this thread.
pub(crate) fn run(
    address: SocketAddr,
    path: &str,
    connections: usize,
    lasts: Duration,
) -> Result<Load, CliError> {
    let request = format!("GET {path} HTTP/1.1\r\nHost: {address}\r\nAccept: application/json\r\n\r\n");
    let mut clients = (0..connections).map(|_| Client::open(address)).collect::<Result<Vec<_>, _>>()?;
    for client in &mut clients {
        client.ask(&request)?;
    }
    let (started, mut took_us, mut answer_bytes) = (Instant::now(), Vec::new(), 0);
    while started.elapsed() < lasts {
        for client in &mut clients {
            answer_bytes = client.read()?;
            took_us.push(client.asked.elapsed().as_secs_f64() * 1e6);
            client.ask(&request)?;
        }
    }
    let seconds = started.elapsed().as_secs_f64();
    took_us.sort_by(f64::total_cmp);
    let at = |share: f64| took_us[((took_us.len() - 1) as f64 * share) as usize];
    let requests_a_second = took_us.len() as f64 / seconds;
    Ok(Load { requests_a_second, p50_us: at(0.5), p99_us: at(0.99), answer_bytes })
}

impl Client {
    fn open(address: SocketAddr) -> Result<Self, CliError> {
        let stream = TcpStream::connect(address).map_err(CliError::failed)?;
        stream.set_nodelay(true).map_err(CliError::failed)?;
        stream.set_read_timeout(Some(Duration::from_secs(5))).map_err(CliError::failed)?;
        Ok(Self { stream, buffer: vec![0; 256 * 1024], asked: Instant::now() })
    }

    fn ask(&mut self, request: &str) -> Result<(), CliError> {
        self.asked = Instant::now();
        self.stream.write_all(request.as_bytes()).map_err(CliError::failed)
    }

    /// Reads one answer whole and returns its length.
    fn read(&mut self) -> Result<usize, CliError> {
        let (mut filled, mut whole) = (0, None);
        while whole.is_none_or(|whole| filled < whole) {
            let got = self.stream.read(&mut self.buffer[filled..]).map_err(CliError::failed)?;
            if got == 0 {
                return Err(CliError::failed("the service closed the connection, or an answer is too long"));
            }
            filled += got;
            if whole.is_none() {
                whole = length(&self.buffer[..filled])?;
            }
        }
        Ok(filled)
    }
}

/// Length of the answer that begins here, once its head is there.
fn length(answer: &[u8]) -> Result<Option<usize>, CliError> {
    let Some(end) = answer.windows(4).position(|four| four == b"\r\n\r\n") else { return Ok(None) };
    let head = String::from_utf8_lossy(&answer[..end]).to_ascii_lowercase();
    if !head.starts_with("http/1.1 200") {
        return Err(CliError::failed(format!("answered {}", head.lines().next().unwrap_or_default())));
    }
    let length =
        head.lines().find_map(|line| line.strip_prefix("content-length:")?.trim().parse::<usize>().ok());
    length.map(|length| Some(end + 4 + length)).ok_or_else(|| CliError::failed("an answer without a length"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_are_read() {
        let text = b"HTTP/1.1 200 OK\r\nContent-Type: a\r\nContent-Length: 5\r\n\r\nhel";
        assert_eq!(length(text).ok().flatten(), Some(text.len() + 2));
        assert_eq!(length(b"HTTP/1.1 200 OK\r\nContent-").ok(), Some(None));
        assert!(length(b"HTTP/1.1 429 Too Many\r\n\r\n").is_err());
        assert!(length(b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n").is_err());
    }
}
