//! Notification of a real HTTP receiver that fails at first, and to a real MQTT broker that comes late.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]
#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use brokers::{Authority, FakeBroker, Manner};
use railgrip_health::alerts::journal::Journal;
use railgrip_health::alerts::notify::{self, ReceiverStates};
use railgrip_health::alerts::{AlertBook, Symptom};
use railgrip_health::api::grade::Grade;
use railgrip_messages::Stamp;
use railgrip_requirements::MOSQUITTO;
use railgrip_settings::{
    AlertSettings, BrokerTls, MqttSettings, NotifySettings, ReceiverSettings, ReceiverWay, WebhookSettings,
};
use serde_json::Value;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

railgrip_requirements::tests! {
    a_receiver_that_fails_at_first_gets_every_notification_in_order_after_a_restart_too: [],
    a_broker_that_comes_late_gets_every_notification: [MOSQUITTO],
    a_broker_by_tls_gets_every_notification_if_its_certificate_is_good: [],
    no_broker_holds_its_receiver: [],
}

#[path = "../../../common/mqtt/tests/support/mod.rs"]
mod brokers;

/// Puts notifications about one alert, raised and cleared, into the outbox.
fn write_notifications(journal: &Path, settings: &NotifySettings) {
    let alerts = AlertSettings { raise_after_s: 0.0, clear_after_s: 0.0, ..AlertSettings::default() };
    let mut book = AlertBook::new(alerts, 8, PathBuf::new());
    let opened = Journal::open(journal, "demo", notify::receivers(settings), 100).unwrap();
    book.keep_in(opened, Vec::new());
    for (second, grade) in [(1, Grade::Act), (2, Grade::Ok)] {
        let now =
            Stamp { unix_ns: second * 1_000_000_000, monotonic_ns: second.unsigned_abs() * 1_000_000_000 };
        let symptom = Symptom { wagon: 3, wheelset: None, rule: "brake_friction" };
        for _ in 0..2 {
            book.judge(symptom.clone(), grade, "far too low", now);
        }
        book.settle(now);
    }
}

/// One receiver.
fn notify_by(name: &str, way: ReceiverWay) -> NotifySettings {
    let receiver = ReceiverSettings { name: name.to_owned(), act_only: false, way };
    NotifySettings {
        receivers: vec![receiver],
        longest_pause_s: 1.0,
        most_waiting: 100,
        deprecated: Vec::new(),
    }
}

fn wait_until(what: &str, done: impl Fn() -> bool) {
    let began = Instant::now();
    while !done() {
        assert!(began.elapsed() < Duration::from_secs(30), "{what} did not happen");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Idempotency keys and bodies of requests.
type Notifications = Arc<Mutex<Vec<(String, Value)>>>;

/// Idempotency key and body of every request; the first `failures` get status 503.
fn receiver(failures: usize) -> (String, Notifications) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}/alerts", listener.local_addr().unwrap());
    let seen = Arc::new(Mutex::new(Vec::new()));
    let kept = Arc::clone(&seen);
    std::thread::spawn(move || {
        for stream in listener.incoming() {
            let mut stream: TcpStream = stream.unwrap();
            let (mut text, mut part) = (Vec::new(), [0; 4096]);
            let body = loop {
                let count = stream.read(&mut part).unwrap();
                text.extend_from_slice(&part[..count]);
                let whole = String::from_utf8_lossy(&text).into_owned();
                let Some((head, body)) = whole.split_once("\r\n\r\n") else { continue };
                let header = |name: &str| {
                    head.lines()
                        .find_map(|line| line.to_lowercase().strip_prefix(name).map(|v| v.trim().to_owned()))
                };
                let length: usize = header("content-length:").unwrap().parse().unwrap();
                if body.len() >= length {
                    break (header("idempotency-key:").unwrap(), serde_json::from_str(body).unwrap());
                }
            };
            let mut kept = kept.lock().unwrap();
            kept.push(body);
            let status = if kept.len() <= failures { "503 Service Unavailable" } else { "200 OK" };
            write!(stream, "HTTP/1.1 {status}\r\ncontent-length: 0\r\nconnection: close\r\n\r\n").unwrap();
        }
    });
    (url, seen)
}

fn a_receiver_that_fails_at_first_gets_every_notification_in_order_after_a_restart_too() {
    let folder = tempfile::tempdir().unwrap();
    let journal = folder.path().join("alerts.db");
    let (url, seen) = receiver(2);
    let way = ReceiverWay::Webhook(WebhookSettings { url, token_file: None });
    let settings = notify_by("depot", way);
    // The writer is gone, as after a kill, before anything is delivered.
    write_notifications(&journal, &settings);
    let (receiver_states, stop) = (ReceiverStates::default(), Arc::new(AtomicBool::new(false)));
    let threads = notify::start(&settings, "demo", &journal, &receiver_states, &stop);
    wait_until("delivery", || receiver_states.view().receivers.iter().any(|one| one.delivered == 2));
    stop.store(true, Ordering::Relaxed);
    threads.into_iter().for_each(|thread| thread.join().unwrap());
    let seen = seen.lock().unwrap();
    let told: Vec<(&str, &str)> =
        seen.iter().map(|(key, body)| (key.as_str(), body["change"].as_str().unwrap())).collect();
    println!("{told:?}");
    let changes: Vec<&str> = told.iter().map(|(_, change)| *change).collect();
    assert_eq!(changes, ["raised", "raised", "raised", "cleared"]);
    assert!(
        told[0].0 == told[2].0 && told[2].0 != told[3].0,
        "one key a notification, however often it is sent"
    );
    assert_eq!((&seen[3].1["train"], &seen[3].1["alert"]["wagon"]), (&"demo".into(), &3.into()));
}

/// A broker of this test's own; killed at the end.
struct Broker(Child);

impl Broker {
    fn start(port: u16) -> Self {
        let mut command = Command::new(MOSQUITTO.path());
        command.args(["-p", &port.to_string()]).stdout(Stdio::null()).stderr(Stdio::null());
        Self(command.spawn().unwrap())
    }
}

impl Drop for Broker {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn mqtt(host: &str, port: u16, tls: Option<BrokerTls>) -> MqttSettings {
    MqttSettings {
        host: host.to_owned(),
        port,
        topic: "railgrip/{train}/alerts/{id}".to_owned(),
        client_id: "railgrip-test".to_owned(),
        user: None,
        password_file: None,
        tls,
        retain: true,
    }
}

fn a_broker_that_comes_late_gets_every_notification() {
    let folder = tempfile::tempdir().unwrap();
    let journal = folder.path().join("alerts.db");
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let settings = notify_by("mqtt", ReceiverWay::Mqtt(mqtt("127.0.0.1", port, None)));
    write_notifications(&journal, &settings);
    let (receiver_states, stop) = (ReceiverStates::default(), Arc::new(AtomicBool::new(false)));
    let threads = notify::start(&settings, "demo", &journal, &receiver_states, &stop);
    wait_until("trouble", || receiver_states.view().receivers.iter().any(|one| one.trouble.is_some()));
    println!("{:?}", receiver_states.view().receivers[0]);
    let broker = Broker::start(port);
    wait_until("delivery", || receiver_states.view().receivers.iter().any(|one| one.delivered == 2));
    stop.store(true, Ordering::Relaxed);
    threads.into_iter().for_each(|thread| thread.join().unwrap());
    // The broker keeps the last notification for those who come later: read it back.
    let mut options = rumqttc::MqttOptions::new("reader", "127.0.0.1", port);
    options.set_max_packet_size(1 << 20, 1 << 20);
    let (client, mut connection) = rumqttc::Client::new(options, 10);
    client.subscribe("railgrip/demo/alerts/#", rumqttc::QoS::AtLeastOnce).unwrap();
    let kept = loop {
        let event = connection.recv_timeout(Duration::from_secs(10)).unwrap().unwrap();
        if let rumqttc::Event::Incoming(rumqttc::Packet::Publish(notification)) = event {
            break notification;
        }
    };
    let body: Value = serde_json::from_slice(&kept.payload).unwrap();
    println!("{}: {} {}", kept.topic, body["change"], body["key"]);
    assert_eq!((kept.topic.as_str(), &body["change"]), ("railgrip/demo/alerts/1", &"cleared".into()));
    drop(broker);
}

fn a_broker_by_tls_gets_every_notification_if_its_certificate_is_good() {
    let folder = tempfile::tempdir().unwrap();
    let (right, wrong) = (Authority::new(), Authority::new());
    let ca_file = folder.path().join("ca.pem");
    let broker = FakeBroker::start(Some(right.server(&["localhost"])), Manner::Good(Vec::new()));
    let tls = Some(BrokerTls { ca_file: Some(ca_file.clone()) });
    let settings = notify_by("yard", ReceiverWay::Mqtt(mqtt("localhost", broker.port, tls)));
    let journal = folder.path().join("alerts.db");
    write_notifications(&journal, &settings);
    std::fs::write(&ca_file, wrong.pem()).unwrap();
    let (states, stop) = (ReceiverStates::default(), Arc::new(AtomicBool::new(false)));
    let threads = notify::start(&settings, "demo", &journal, &states, &stop);
    wait_until("trouble", || states.view().receivers.iter().any(|one| one.trouble.is_some()));
    let trouble = states.view().receivers[0].trouble.clone().unwrap();
    println!("{trouble}");
    assert!(trouble.contains("the broker's certificate is refused"), "{trouble}");
    assert!(broker.published().is_empty());
    // The file is read again at every connection.
    std::fs::write(&ca_file, right.pem()).unwrap();
    wait_until("delivery", || states.view().receivers.iter().any(|one| one.delivered == 2));
    stop.store(true, Ordering::Relaxed);
    threads.into_iter().for_each(|thread| thread.join().unwrap());
    let changes: Vec<Value> = broker
        .published()
        .iter()
        .map(|(topic, body)| {
            assert_eq!(topic, "railgrip/demo/alerts/1");
            serde_json::from_slice::<Value>(body).unwrap()["change"].clone()
        })
        .collect();
    assert_eq!(changes, ["raised", "cleared"]);
}

fn no_broker_holds_its_receiver() {
    for (manner, said, within_s) in [
        (Manner::Floods, "sends what nobody asked for", 3.0),
        (Manner::Trickles, "did not confirm in time", 12.0),
        (Manner::Silent, "did not confirm in time", 12.0),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let journal = folder.path().join("alerts.db");
        let broker = FakeBroker::start(None, manner.clone());
        let settings = notify_by("mqtt", ReceiverWay::Mqtt(mqtt("127.0.0.1", broker.port, None)));
        write_notifications(&journal, &settings);
        let (states, stop) = (ReceiverStates::default(), Arc::new(AtomicBool::new(false)));
        let began = Instant::now();
        let threads = notify::start(&settings, "demo", &journal, &states, &stop);
        wait_until("trouble", || states.view().receivers.iter().any(|one| one.trouble.is_some()));
        let (took_s, trouble) = (began.elapsed().as_secs_f64(), states.view().receivers[0].trouble.clone());
        let trouble = trouble.unwrap();
        println!("{manner:?}: {trouble} after {took_s:.1} s");
        assert!(trouble.contains(said) && took_s < within_s, "{manner:?}: {trouble} after {took_s} s");
        // In the middle of the next attempt it is asked to stop.
        wait_until("another attempt", || broker.connections.load(Ordering::Relaxed) > 1);
        let asked = Instant::now();
        stop.store(true, Ordering::Relaxed);
        threads.into_iter().for_each(|thread| thread.join().unwrap());
        let took_s = asked.elapsed().as_secs_f64();
        println!("{manner:?}: stopped after {took_s:.2} s");
        assert!(took_s < 1.0, "{manner:?}: stopped after {took_s} s");
        let view = states.view().receivers[0].clone();
        assert_eq!((view.delivered, view.waiting), (0, 2), "nothing is lost, and nothing confirmed");
        assert_eq!(view.trouble.as_deref(), Some(trouble.as_str()), "stopping is no trouble");
    }
}
