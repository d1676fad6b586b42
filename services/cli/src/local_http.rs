//! Asks the health service of a train on this machine through its local socket in the folder of the train, which
//! only the user that runs the train can open. It asks for no token and speaks no TLS, whatever the network address asks.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::Duration;

use serde_json::Value;

/// Largest answer that is taken, bytes.
const MAX_ANSWER: u64 = 16 << 20;

/// The JSON at a path of the service.
pub(crate) fn get(socket: &Path, path: &str, patience: Duration) -> Result<Value, String> {
    let answer = ask(socket, path, patience).map_err(|error| error.to_string())?;
    let (head, body) = split(&answer).ok_or("no answer in HTTP")?;
    let status = head.split(' ').nth(1).unwrap_or_default();
    if status != "200" {
        return Err(format!("answers {}", head.lines().next().unwrap_or_default()));
    }
    serde_json::from_slice(body).map_err(|error| format!("no JSON: {error}"))
}

/// HTTP/1.0: the answer is not cut into pieces and ends with the connection.
fn ask(socket: &Path, path: &str, patience: Duration) -> std::io::Result<Vec<u8>> {
    let mut stream = UnixStream::connect(socket)?;
    stream.set_read_timeout(Some(patience))?;
    stream.set_write_timeout(Some(patience))?;
    write!(stream, "GET {path} HTTP/1.0\r\nHost: localhost\r\nAccept: application/json\r\n\r\n")?;
    let mut answer = Vec::new();
    stream.take(MAX_ANSWER).read_to_end(&mut answer)?;
    Ok(answer)
}

fn split(answer: &[u8]) -> Option<(&str, &[u8])> {
    let end = answer.windows(4).position(|four| four == b"\r\n\r\n")?;
    Some((std::str::from_utf8(&answer[..end]).ok()?, &answer[end + 4..]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::net::UnixListener;

    fn answered(answer: &'static str) -> Result<Value, String> {
        let folder = tempfile::tempdir().expect("folder");
        let socket = folder.path().join("s");
        let listener = UnixListener::bind(&socket).expect("bind");
        let server = std::thread::spawn(move || {
            let (mut stream, _) = listener.accept().expect("accept");
            let mut asked = [0; 1024];
            let _ = stream.read(&mut asked);
            stream.write_all(answer.as_bytes()).expect("write");
        });
        let result = get(&socket, "/x", Duration::from_secs(2));
        server.join().expect("server");
        result
    }

    #[test]
    fn answers_are_taken_apart() {
        assert_eq!(answered("HTTP/1.0 200 OK\r\nA: b\r\n\r\n{\"a\":1}").expect("JSON")["a"], 1);
        assert!(answered("HTTP/1.0 503 Service Unavailable\r\n\r\n{}").expect_err("503").contains("503"));
        assert!(answered("nonsense").is_err());
        assert!(answered("HTTP/1.0 200 OK\r\n\r\nnonsense").expect_err("text").contains("no JSON"));
    }
}
