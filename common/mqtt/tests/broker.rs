//! Connections to brokers of the test's own: by TLS, plain, and to brokers that mean no good.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

mod support;

use bytes::BytesMut;
use proptest::collection::vec;
use proptest::prelude::{any, proptest};
use railgrip_mqtt::{Authorities, Broker, Connection, MqttError, News};
use rumqttc::mqttbytes::v4::Packet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use support::{Authority, FakeBroker, Manner};

const KEEP_ALIVE: Duration = Duration::from_secs(30);

fn broker(port: u16, tls: Option<Authorities<'_>>) -> Broker<'_> {
    Broker { host: "localhost", port, client_id: "test", user: None, password_file: None, tls }
}

fn open_within(broker: &Broker<'_>, patience_s: f64) -> Result<Connection, MqttError> {
    let until = Instant::now() + Duration::from_secs_f64(patience_s);
    Connection::open(broker, KEEP_ALIVE, until, &Arc::default())
}

fn open(broker: &Broker<'_>) -> Result<Connection, MqttError> {
    open_within(broker, 10.0)
}

/// What it says, and how long it took, s.
fn refused<T>(what: impl FnOnce() -> Result<T, MqttError>) -> (MqttError, f64) {
    let began = Instant::now();
    let Err(error) = what() else { panic!("it was accepted") };
    let took_s = began.elapsed().as_secs_f64();
    println!("{error} after {took_s:.2} s");
    (error, took_s)
}

fn soon() -> Instant {
    Instant::now() + Duration::from_secs(10)
}

fn file(folder: &Path, name: &str, text: &str) -> PathBuf {
    let file = folder.join(name);
    std::fs::write(&file, text).unwrap();
    file
}

#[test]
fn a_broker_whom_the_authority_vouches_for_is_published_to_and_listened_to() {
    let folder = tempfile::tempdir().unwrap();
    let authority = Authority::new();
    let ca = file(folder.path(), "ca.pem", authority.pem());
    let password = file(folder.path(), "password", "word\n");
    let messages: Vec<String> = (0..500).map(|number| format!("{number} {}", "x".repeat(300))).collect();
    for tls in [None, Some(Authorities::File(&ca))] {
        let config = tls.map(|_| authority.server(&["localhost"]));
        let fake = FakeBroker::start(config, Manner::Good(messages.clone()));
        let known = Broker { user: Some("kim"), password_file: Some(&password), ..broker(fake.port, tls) };
        let mut connection = open(&known).unwrap();
        let large = vec![b'y'; 500_000];
        for body in [b"one".as_slice(), &large, b"three"] {
            connection.publish("a/b", body, true, soon()).unwrap();
        }
        let published = fake.published();
        assert_eq!(published.len(), 3);
        assert!(published[0] == ("a/b".to_owned(), b"one".to_vec()) && published[1].1 == large);
        let seen = format!("{:?}", fake.seen.lock().unwrap()[0]);
        assert!(seen.contains("kim") && seen.contains("\"word\""), "{seen}");

        connection.subscribe("t").unwrap();
        assert!(matches!(connection.news(KEEP_ALIVE).unwrap(), News::Subscribed));
        for message in &messages {
            let News::Message(found) = connection.news(KEEP_ALIVE).unwrap() else { panic!("a message") };
            assert_eq!(found.payload, message.as_bytes());
        }
        assert!(matches!(connection.news(Duration::from_millis(300)).unwrap(), News::None));
        let confirmed = fake
            .seen
            .lock()
            .unwrap()
            .iter()
            .filter(|packet| format!("{packet:?}").contains("PubAck"))
            .count();
        assert_eq!(confirmed, messages.len());
    }
}

#[test]
fn a_broker_whom_nobody_vouches_for_is_refused_and_the_error_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let (right, wrong) = (Authority::new(), Authority::new());
    let ours = file(folder.path(), "ours.pem", right.pem());
    let theirs = file(folder.path(), "theirs.pem", wrong.pem());
    let fake = FakeBroker::start(Some(right.server(&["localhost"])), Manner::Good(Vec::new()));
    for authorities in [Authorities::File(&theirs), Authorities::Public] {
        let (error, _) = refused(|| open(&broker(fake.port, Some(authorities))));
        assert!(error.to_string().starts_with("the broker's certificate is refused: "), "{error}");
    }
    // The certificate is sound, but of another host.
    let elsewhere = Broker { host: "127.0.0.1", ..broker(fake.port, Some(Authorities::File(&ours))) };
    let (error, _) = refused(|| open(&elsewhere));
    assert!(error.to_string().contains("not valid for name \"127.0.0.1\""), "{error}");
    assert_eq!(fake.seen.lock().unwrap().len(), 0, "nobody was told who we are");
    let empty = file(folder.path(), "empty.pem", "");
    for useless in [empty, folder.path().join("gone.pem")] {
        let (error, _) = refused(|| open(&broker(fake.port, Some(Authorities::File(&useless)))));
        assert!(error.to_string().starts_with(&useless.display().to_string()), "{error}");
    }
}

#[test]
fn tls_and_plain_text_that_meet_each_other_end_soon_and_say_what_is_wrong() {
    let authority = Authority::new();
    let by_tls = FakeBroker::start(Some(authority.server(&["localhost"])), Manner::Good(Vec::new()));
    let (error, took_s) = refused(|| open(&broker(by_tls.port, None)));
    assert!(took_s < 2.0 && error.to_string().contains("tls = true"), "{error} after {took_s} s");
    let plain = FakeBroker::start(None, Manner::Good(Vec::new()));
    // The plain broker waits for the rest of what it takes for a long packet.
    let (_, took_s) = refused(|| open_within(&broker(plain.port, Some(Authorities::Public)), 1.0));
    assert!(took_s < 2.0, "{took_s} s");
}

#[test]
fn no_broker_holds_whoever_publishes() {
    for manner in [Manner::Floods, Manner::Trickles, Manner::Silent] {
        let fake = FakeBroker::start(None, manner.clone());
        let mut connection = open(&broker(fake.port, None)).unwrap();
        let until = Instant::now() + Duration::from_secs(1);
        let (error, took_s) = refused(|| connection.publish("a", b"b", false, until));
        match manner {
            Manner::Floods => assert!(matches!(error, MqttError::Unasked) && took_s < 1.0),
            _ => assert!(matches!(error, MqttError::Late) && (0.9..1.5).contains(&took_s), "{took_s} s"),
        }
    }
    let fake = FakeBroker::start(None, Manner::Closed);
    let (error, _) = refused(|| open(&broker(fake.port, None)));
    assert!(matches!(error, MqttError::Login(_)), "{error}");
    let fake = FakeBroker::start(None, Manner::Drips);
    let (error, took_s) = refused(|| open_within(&broker(fake.port, None), 1.0));
    assert!(matches!(error, MqttError::Late) && took_s < 1.5, "{error} after {took_s} s");
    // Takes connections, but never answers a handshake.
    let mute = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = mute.local_addr().unwrap().port();
    let (error, took_s) = refused(|| open_within(&broker(port, Some(Authorities::Public)), 1.0));
    assert!(matches!(error, MqttError::Late) && took_s < 1.5, "{error} after {took_s} s");
}

#[test]
fn whoever_publishes_stops_when_asked() {
    for (tls, manner) in [(None, Manner::Trickles), (None, Manner::Silent)] {
        let fake = FakeBroker::start(tls, manner);
        let stop = Arc::new(AtomicBool::new(false));
        let mut connection = Connection::open(&broker(fake.port, None), KEEP_ALIVE, soon(), &stop).unwrap();
        let asked = Arc::clone(&stop);
        std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(300));
            asked.store(true, Ordering::Relaxed);
        });
        let (error, took_s) = refused(|| connection.publish("a", b"b", false, soon()));
        assert!(matches!(error, MqttError::Stopped) && took_s < 1.0, "{error} after {took_s} s");
    }
}

#[test]
fn a_silent_broker_is_noticed_and_a_quiet_one_kept() {
    for (manner, kept) in [(Manner::Good(Vec::new()), true), (Manner::Silent, false)] {
        let fake = FakeBroker::start(None, manner);
        let keep_alive = Duration::from_secs(1);
        let mut connection =
            Connection::open(&broker(fake.port, None), keep_alive, soon(), &Arc::default()).unwrap();
        let until = Instant::now() + 5 * keep_alive;
        let told = std::iter::repeat_with(|| connection.news(keep_alive))
            .take_while(|_| Instant::now() < until)
            .find_map(Result::err);
        println!("{told:?}");
        assert_eq!(told.is_none(), kept, "{told:?}");
    }
}

proptest! {
    #[test]
    fn no_bytes_of_a_broker_make_the_reader_panic(bytes in vec(any::<u8>(), 0..200), kind in 0_u8..16, length in 0_u8..120) {
        let mut packet = BytesMut::from(&[kind << 4 | (bytes.len() as u8 & 0xf), length][..]);
        packet.extend_from_slice(&bytes);
        while Packet::read(&mut packet, 1 << 20).is_ok() {}
    }
}
