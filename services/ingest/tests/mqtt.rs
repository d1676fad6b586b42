//! Samples from a real broker: every message becomes its rows, and the source outlives the broker's restart.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

use brokers::{Authority, FakeBroker, Manner};
use railgrip_ingest::feed::{Arrival, Feed, open};
use railgrip_messages::SourceCount;
use railgrip_requirements::MOSQUITTO;
use railgrip_settings::{Overrides, TrainSettings};
use rumqttc::{Client, ConnectionError, Event, MqttOptions, Packet, QoS};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

railgrip_requirements::tests! {
    messages_of_a_broker_become_samples: [MOSQUITTO],
    values_under_topics_become_samples: [MOSQUITTO],
    messages_by_tls_become_samples: [],
    a_broker_of_another_authority_brings_nothing: [],
}

#[path = "../../../common/mqtt/tests/support/mod.rs"]
mod brokers;

struct Broker(Child);

impl Drop for Broker {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn broker(port: u16) -> Broker {
    let mut command = Command::new(MOSQUITTO.path());
    command.args(["-p", &port.to_string()]).stdout(Stdio::null()).stderr(Stdio::null());
    let child = Broker(command.spawn().unwrap());
    let until = Instant::now() + Duration::from_secs(10);
    while std::net::TcpStream::connect(("127.0.0.1", port)).is_err() {
        assert!(Instant::now() < until, "the broker does not listen");
        std::thread::sleep(Duration::from_millis(20));
    }
    child
}

/// Publishes messages of ten rows each and waits until the broker has confirmed them.
fn publish(port: u16, from: u32, messages: u32) {
    let mut options = MqttOptions::new("sender", "127.0.0.1", port);
    options.set_max_packet_size(1 << 20, 1 << 20);
    let (client, mut connection) = Client::new(options, 1000);
    let row = |number: u32| format!("{{\"wagon\":1,\"t_s\":{},\"v_m_s\":20}}\n", f64::from(number) * 0.01);
    for message in from..from + messages {
        let rows: String = (0..10).map(|k| row(message * 10 + k)).collect();
        client.publish("train/1/samples", QoS::AtLeastOnce, false, rows).unwrap();
    }
    let confirmed =
        |event: &Result<Event, ConnectionError>| matches!(event, Ok(Event::Incoming(Packet::PubAck(_))));
    assert_eq!(connection.iter().filter(confirmed).take(messages as usize).count(), messages as usize);
}

/// Takes what arrives until there are so many rows, for 20 s at most.
fn rows(feed: &mut dyn Feed, wanted: usize) -> Vec<f64> {
    rows_within(feed, wanted, Duration::from_secs(20))
}

fn rows_within(feed: &mut dyn Feed, wanted: usize, patience: Duration) -> Vec<f64> {
    let mut times = Vec::new();
    let until = Instant::now() + patience;
    while times.len() < wanted && Instant::now() < until {
        feed.take_due(0.0, &mut |arrival| match arrival {
            Arrival::Row { row, .. } => times.push(row.t_s),
            other => panic!("{other:?}"),
        });
        std::thread::sleep(Duration::from_millis(5));
    }
    times
}

fn settings(host: &str, port: u16, more: &str) -> TrainSettings {
    let vehicle = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/vehicle.toml");
    let text = format!(
        "schema = 1\n[train]\nname = \"m\"\nwagons = 1\nvehicle = \"{vehicle}\"\n[source]\nkind = \"mqtt\"\n\
         host = \"{host}\"\nport = {port}\ntopic = \"train/+/samples\"\n{more}"
    );
    TrainSettings::parse(Path::new("train.toml"), &text, &Overrides::default()).unwrap()
}

fn messages_of_a_broker_become_samples() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    drop(listener);
    let settings = settings("127.0.0.1", port, "");
    // The source is there before its broker is.
    let mut feed = open(&settings).unwrap();
    let first = broker(port);
    std::thread::sleep(Duration::from_secs(3));
    publish(port, 0, 50);
    let times = rows(&mut *feed, 500);
    assert_eq!((times.len(), times.last().copied()), (500, Some(4.99)));
    drop(first);
    let _second = broker(port);
    std::thread::sleep(Duration::from_secs(3));
    publish(port, 50, 10);
    assert_eq!(rows(&mut *feed, 100).len(), 100);
}

/// One value a topic: the rows of the wagons that the topics name, and nothing of what the broker had kept from before.
fn values_under_topics_become_samples() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    drop(listener);
    let _broker = broker(port);
    let (client, mut connection) = Client::new(MqttOptions::new("sender", "127.0.0.1", port), 1000);
    let mut say = |retain: bool, topic: &str, value: &str| {
        client.publish(topic, QoS::AtLeastOnce, retain, value).unwrap();
        assert!(connection.iter().any(|event| matches!(event, Ok(Event::Incoming(Packet::PubAck(_))))));
    };
    say(true, "train/1/bogie1/axle1", "999");
    let vehicle = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/vehicle.toml");
    let text = format!(
        "schema = 1\n[train]\nname = \"m\"\nwagons = 2\nvehicle = \"{vehicle}\"\n[source]\nkind = \"mqtt\"\nhost = \"127.0.0.1\"\n\
         port = {port}\nhold_ms = 60000\ntopics = [{{ topic = \"train/{{wagon}}/bogie1/{{name}}\" }},\n{{ topic = \"loco/gps\", name = \"gps\" }}]\n\
         [mapping]\nomega_f_rad_s = {{ from = \"axle1\", unit = \"rpm\" }}\nv_m_s = {{ from = \"gps.v\", unit = \"km/h\" }}\n"
    );
    let settings = TrainSettings::parse(Path::new("train.toml"), &text, &Overrides::default()).unwrap();
    let mut feed = open(&settings).unwrap();
    let until = Instant::now() + Duration::from_secs(20);
    let old = |feed: &dyn Feed| feed.accounts().unwrap().0.counts[SourceCount::Old.code() as usize];
    while old(&*feed) == 0 {
        assert!(Instant::now() < until, "the kept message does not come");
        std::thread::sleep(Duration::from_millis(20));
    }
    let mut rows = Vec::new();
    for k in 0..50 {
        say(false, "loco/gps", "{\"v\": 72, \"fix\": \"3d\"}");
        say(false, "train/1/bogie1/axle1", &format!("{}", 300 + k));
        say(false, "train/2/bogie1/axle1", "150");
    }
    while rows.len() < 100 && Instant::now() < until {
        feed.take_due(0.0, &mut |arrival| match arrival {
            Arrival::Row { wagon, row, .. } => rows.push((wagon, row.v_m_s, row.wheel_speed_rad_s[0])),
            other => panic!("{other:?}"),
        });
        std::thread::sleep(Duration::from_millis(5));
    }
    let of = |wagon: usize| rows.iter().filter(|row| row.0 == wagon).map(|row| row.2).collect::<Vec<_>>();
    let rad_s = std::f64::consts::TAU / 60.0;
    assert!(rows.iter().all(|row| (row.1 - 20.0).abs() < 1e-9), "{rows:?}");
    let close = |found: &[f64], rpm: &dyn Fn(usize) -> f64| {
        found.len() == 50 && found.iter().enumerate().all(|(k, found)| (found - rpm(k) * rad_s).abs() < 1e-9)
    };
    assert!(close(&of(0), &|k| 300.0 + k as f64) && close(&of(1), &|_| 150.0), "{rows:?}");
}

/// Messages of ten rows each.
fn messages(count: u32) -> Vec<String> {
    let row = |number: u32| format!("{{\"wagon\":1,\"t_s\":{},\"v_m_s\":20}}\n", f64::from(number) * 0.01);
    (0..count).map(|message| (0..10).map(|k| row(message * 10 + k)).collect()).collect()
}

fn messages_by_tls_become_samples() {
    let folder = tempfile::tempdir().unwrap();
    let (authority, ca_file) = (Authority::new(), folder.path().join("ca.pem"));
    std::fs::write(&ca_file, authority.pem()).unwrap();
    let broker = FakeBroker::start(Some(authority.server(&["localhost"])), Manner::Good(messages(50)));
    let tls = format!("tls = true\nca_file = \"{}\"\n", ca_file.display());
    let mut feed = open(&settings("localhost", broker.port, &tls)).unwrap();
    let times = rows(&mut *feed, 500);
    assert_eq!((times.len(), times.last().copied()), (500, Some(4.99)));
}

fn a_broker_of_another_authority_brings_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let ca_file = folder.path().join("ca.pem");
    std::fs::write(&ca_file, Authority::new().pem()).unwrap();
    let broker = FakeBroker::start(Some(Authority::new().server(&["localhost"])), Manner::Good(messages(1)));
    let tls = format!("tls = true\nca_file = \"{}\"\n", ca_file.display());
    let mut feed = open(&settings("localhost", broker.port, &tls)).unwrap();
    assert_eq!(rows_within(&mut *feed, 1, Duration::from_secs(3)), Vec::<f64>::new());
    assert!(broker.seen.lock().unwrap().is_empty(), "it was told nothing");
    assert!(broker.connections.load(std::sync::atomic::Ordering::Relaxed) > 1, "it is tried again");
}
