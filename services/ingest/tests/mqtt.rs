//! Samples from a real broker: every message becomes its rows, and the source outlives the broker's restart.
#![allow(clippy::unwrap_used, reason = "a test may end at what it does not expect")]

use railgrip_ingest::feed::{Arrival, Feed, open};
use railgrip_requirements::MOSQUITTO;
use railgrip_settings::{Overrides, TrainSettings};
use rumqttc::{Client, ConnectionError, Event, MqttOptions, Packet, QoS};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

railgrip_requirements::tests! {
    messages_of_a_broker_become_samples: [MOSQUITTO],
}

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

/// Takes what arrives until there are so many rows.
fn rows(feed: &mut dyn Feed, wanted: usize) -> Vec<f64> {
    let mut times = Vec::new();
    let until = Instant::now() + Duration::from_secs(20);
    while times.len() < wanted && Instant::now() < until {
        feed.take_due(0.0, &mut |arrival| match arrival {
            Arrival::Row { row, .. } => times.push(row.t_s),
            other => panic!("{other:?}"),
        });
        std::thread::sleep(Duration::from_millis(5));
    }
    times
}

fn messages_of_a_broker_become_samples() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    drop(listener);
    let vehicle = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/vehicle.toml");
    let text = format!(
        "schema = 1\n[train]\nname = \"m\"\nwagons = 1\nvehicle = \"{vehicle}\"\n[source]\nkind = \"mqtt\"\n\
         host = \"127.0.0.1\"\nport = {port}\ntopic = \"train/+/samples\"\n"
    );
    let settings = TrainSettings::parse(Path::new("train.toml"), &text, &Overrides::default()).unwrap();
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
