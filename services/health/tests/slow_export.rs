//! An export over a real socket whose reader is slow: it gives way to another, and whoever reads it sees that it is not whole.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

use railgrip_health::access::{self, Access};
use railgrip_health::api::router;
use railgrip_health::history::{History, columns};
use railgrip_health::shared::Shared;
use railgrip_health::store::Store;
use railgrip_messages::Stamp;
use railgrip_settings::{Overrides, TrainSettings};
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use tokio::sync::oneshot;

const NOW_S: i64 = 1_772_366_400;
const NOW: Stamp = Stamp { unix_ns: NOW_S * 1_000_000_000, monotonic_ns: 100_000_000_000 };
/// More than the sockets between here and there hold: a few megabytes.
const SECONDS: i64 = 12_000;
/// What the slow reader takes at once, and how often: less than a link must to keep its turn.
const SIP_BYTES: usize = 2048;
const PAUSE: Duration = Duration::from_millis(100);
/// How an answer in pieces ends when it is whole.
const WHOLE: &[u8] = b"\r\n0\r\n\r\n";

/// Hours of every figure of one wagon, by the second.
fn remember(database: &Path) {
    let all = columns::all(2);
    let names = columns::stored(&all);
    let names: Vec<_> = names.iter().map(|(name, keep)| (name.as_str(), *keep)).collect();
    let mut kept = railgrip_history::Store::open(database, &names).unwrap();
    for second in 0..SECONDS {
        let row: Vec<f32> = (0..names.len()).map(|column| column as f32 + 1e-3 * second as f32).collect();
        kept.push(1, NOW_S - SECONDS + second, &row).unwrap();
    }
    kept.flush(true).unwrap();
}

/// Serves until the sender goes.
fn serve(folder: &Path) -> (SocketAddr, oneshot::Sender<()>) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/railgrip.toml");
    let overrides = Overrides { instance_dir: Some(folder.join("i")), ..Overrides::default() };
    std::fs::create_dir(folder.join("i")).unwrap();
    let settings = TrainSettings::load(Some(&file), &overrides).unwrap();
    let shared = Shared::new(Store::new(&settings).snapshot(NOW), || NOW);
    shared.remember(Arc::new(History::new(folder.join("history.db"), 2)));
    let access = Access::open(&settings).unwrap();
    let router = access::guard(router(shared), &access);
    let (stop, stopped) = oneshot::channel::<()>();
    let (sender, receiver) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async move {
            let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
            sender.send(listener.local_addr().unwrap()).unwrap();
            access::serve(listener, None, router, access, async { drop(stopped.await) }).await;
        });
    });
    (receiver.recv().unwrap(), stop)
}

/// Asks for the table by the second.
fn ask(address: SocketAddr) -> TcpStream {
    let mut socket = TcpStream::connect(address).unwrap();
    let request = "GET /api/v1/history/export?step=1&format=csv HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n";
    socket.write_all(request.as_bytes()).unwrap();
    socket
}

/// Reads what is left; a connection that is reset has nothing left.
fn rest(socket: &mut TcpStream, taken: &mut Vec<u8>) {
    if let Err(error) = socket.read_to_end(taken) {
        assert_eq!(error.kind(), ErrorKind::ConnectionReset, "{error}");
    }
}

fn is_table(answer: &[u8]) -> bool {
    answer.starts_with(b"HTTP/1.1 200")
}

#[test]
fn a_slow_reader_gives_way_and_does_not_take_its_export_for_whole() {
    let folder = tempfile::tempdir().unwrap();
    remember(&folder.path().join("history.db"));
    let (address, stop) = serve(folder.path());
    let given_way = Arc::new(AtomicBool::new(false));
    let slow = std::thread::spawn({
        let given_way = Arc::clone(&given_way);
        let mut socket = ask(address);
        move || {
            let (mut taken, mut sip) = (Vec::new(), [0; SIP_BYTES]);
            while !given_way.load(Ordering::Relaxed) {
                let count = socket.read(&mut sip).unwrap();
                assert!(count > 0, "it is cut off before anybody else asks");
                taken.extend_from_slice(&sip[..count]);
                std::thread::sleep(PAUSE);
            }
            rest(&mut socket, &mut taken);
            taken
        }
    });
    // Whoever comes next is refused while the slow one may keep its turn, and served afterwards.
    let mut refused = 0;
    let whole = loop {
        let mut answer = Vec::new();
        rest(&mut ask(address), &mut answer);
        if is_table(&answer) {
            break answer;
        }
        assert!(answer.starts_with(b"HTTP/1.1 503"), "{}", String::from_utf8_lossy(&answer));
        refused += 1;
        std::thread::sleep(Duration::from_secs(1));
    };
    given_way.store(true, Ordering::Relaxed);
    let broken = slow.join().unwrap();
    assert!(refused > 0, "the slow one had the turn");
    assert!(whole.ends_with(WHOLE), "{} bytes", whole.len());
    assert!(is_table(&broken) && broken.len() < whole.len(), "{} of {} bytes", broken.len(), whole.len());
    assert!(!broken.ends_with(WHOLE), "{} bytes pass for the whole table", broken.len());
    drop(stop);
}
