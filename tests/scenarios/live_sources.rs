//! Samples that others send: each arrives as one estimate or is counted under a name, whatever the packets look like.

#![allow(clippy::print_stdout, reason = "tests print what they measure")]

use std::io::Write;
use std::process::{Child, ChildStdin, Stdio};
use std::time::{Duration, Instant};

use railgrip_tests::{TrainUnderTest, program, within};
use serde_json::Value;

const PATIENCE: Duration = Duration::from_secs(20);

fn config(name: &str, source: &str) -> String {
    let vehicle = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/vehicle.toml");
    format!(
        "schema = 1\n[train]\nname = \"{name}\"\nwagons = 1\nvehicle = \"{vehicle}\"\n[source]\n{source}\n\
         [logging]\nlevel = \"info\"\nformat = \"text\"\n"
    )
}

/// A line of a coach that rolls at 20 m/s.
fn line(t_s: f64) -> String {
    let omega = 20.0 / 0.44;
    format!(
        "{{\"wagon\":1,\"t_s\":{t_s:.4},\"v_m_s\":20,\"omega_f_rad_s\":{omega},\"omega_r_rad_s\":{omega},\
         \"f_perp_f_n\":0,\"f_perp_r_n\":0}}\n"
    )
}

/// A train that reads our lines.
struct Fed {
    train: TrainUnderTest,
    up: Child,
}

impl Fed {
    fn start(name: &str, source: &str) -> (Self, ChildStdin) {
        let train = TrainUnderTest::new(program!(), &config(name, source));
        let log = std::fs::File::create(train.folder().join("log")).expect("log");
        let mut command = train.command(&["up"]);
        let mut up =
            command.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(log).spawn().expect("start `up`");
        let input = up.stdin.take().expect("piped");
        let fed = Self { train, up };
        let there = within(PATIENCE, || fed.process("estimator").and(fed.process("ingest")));
        assert!(
            there.is_some(),
            "{}",
            std::fs::read_to_string(fed.train.folder().join("log")).unwrap_or_default()
        );
        (fed, input)
    }

    /// A process by its last heartbeat.
    fn process(&self, kind: &str) -> Option<Value> {
        let view = self.train.http()?.json("/api/v1/train")?;
        view["processes"].as_array()?.iter().find(|process| process["process"] == kind).cloned()
    }

    /// Waits until a process has counted so many.
    fn counts(&self, kind: &str, name: &str, count: u64) {
        let seen = || self.process(kind).filter(|process| process[name].as_u64() == Some(count));
        assert!(within(PATIENCE, seen).is_some(), "{kind} {name}: {:?}", self.process(kind));
    }
}

impl Drop for Fed {
    fn drop(&mut self) {
        let _ = self.up.kill();
        let _ = self.up.wait();
    }
}

#[test]
fn two_hundred_a_second_and_packets_of_ten_arrive_without_loss_and_repeats_are_counted() {
    let (fed, mut input) = Fed::start("lines", "kind = \"stdin\"");
    let begin = Instant::now();
    for k in 0..600_u32 {
        let due = begin + Duration::from_millis(5) * k;
        std::thread::sleep(due.saturating_duration_since(Instant::now()));
        input.write_all(line(f64::from(k) * 0.005).as_bytes()).expect("written");
    }
    for packet in 0..30_u32 {
        let lines: String = (0..10).map(|k| line(3.0 + f64::from(packet * 10 + k) * 0.005)).collect();
        input.write_all(lines.as_bytes()).expect("written");
        std::thread::sleep(Duration::from_millis(50));
    }
    // The last packet once more, and a line that is wrong.
    let again: String = (290..300).map(|k| line(3.0 + f64::from(k) * 0.005)).collect();
    input.write_all(again.as_bytes()).expect("written");
    input.write_all(b"nonsense\n").expect("written");
    input.flush().expect("flushed");
    fed.counts("ingest", "received", 911);
    fed.counts("ingest", "published", 900);
    fed.counts("ingest", "late", 10);
    fed.counts("ingest", "rejected", 1);
    fed.counts("estimator", "received", 900);
    for name in ["late", "missed", "rejected"] {
        fed.counts("estimator", name, 0);
    }
    println!("{:?}", fed.process("estimator"));
}

/// A port that is free now.
fn free_port() -> u16 {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    listener.local_addr().expect("its address").port()
}

#[test]
fn connections_come_and_go_and_their_own_names_and_units_are_mapped() {
    let address = format!("127.0.0.1:{}", free_port());
    let source = format!(
        "kind = \"tcp\"\nlisten = \"{address}\"\n[mapping]\nt_s = {{ from = \"ms\", unit = \"ms\" }}\n\
         v_m_s = {{ from = [\"gps\", \"radar\"], unit = \"km/h\" }}\n\
         omega_f_rad_s = {{ from = \"n1\", unit = \"rpm\" }}\nomega_r_rad_s = {{ from = \"n2\", unit = \"rpm\", sign = -1.0 }}\n\
         f_perp_f_n = {{ from = \"p\", unit = \"bar\", scale = 0.16 }}\nf_perp_r_n = {{ from = \"p\", unit = \"bar\", scale = 0.16 }}"
    );
    let (fed, _input) = Fed::start("tcp", &source);
    let rpm = 20.0 / 0.44 * 60.0 / std::f64::consts::TAU;
    let mut ms = 0;
    for _ in 0..3 {
        let mut connection = std::net::TcpStream::connect(&address).expect("connected");
        for _ in 0..100 {
            let line = format!(
                "{{\"ms\":{ms},\"radar\":72,\"n1\":{rpm},\"n2\":-{rpm},\"p\":0,\"driver\":\"Ada\"}}\n"
            );
            connection.write_all(line.as_bytes()).expect("written");
            ms += 10;
            std::thread::sleep(Duration::from_millis(2));
        }
    }
    fed.counts("ingest", "published", 300);
    fed.counts("ingest", "rejected", 0);
    fed.counts("estimator", "received", 300);
    let speed = || {
        let view = fed.train.http()?.json("/api/v1/wagons")?;
        view["wagons"][0]["v_m_s"].as_f64()
    };
    // Speed in km/h and speeds of the wheelsets in rpm agree on 20 m/s, or the filter would say otherwise.
    let mut told = Vec::new();
    for _ in 0..20 {
        let mut connection = std::net::TcpStream::connect(&address).expect("connected");
        let line = format!("{{\"ms\":{ms},\"radar\":72,\"n1\":{rpm},\"n2\":-{rpm},\"p\":0}}\n");
        connection.write_all(line.as_bytes()).expect("written");
        ms += 10;
        std::thread::sleep(Duration::from_millis(50));
        told.extend(speed());
    }
    assert!(told.iter().any(|v_m_s| (v_m_s - 20.0).abs() < 0.2), "{told:?}");
}

#[test]
fn datagrams_of_several_lines_arrive() {
    let address = format!("127.0.0.1:{}", free_port());
    let (fed, _input) = Fed::start("udp", &format!("kind = \"udp\"\nlisten = \"{address}\""));
    let socket = std::net::UdpSocket::bind("127.0.0.1:0").expect("a socket");
    for packet in 0..60_u32 {
        let lines: String = (0..5).map(|k| line(f64::from(packet * 5 + k) * 0.01)).collect();
        socket.send_to(lines.as_bytes(), &address).expect("sent");
        std::thread::sleep(Duration::from_millis(10));
    }
    fed.counts("ingest", "published", 300);
    fed.counts("estimator", "received", 300);
    fed.counts("estimator", "late", 0);
}

#[test]
fn datagrams_that_find_no_room_are_counted() {
    let port = {
        let socket = std::net::UdpSocket::bind("127.0.0.1:0").expect("a port");
        socket.local_addr().expect("its address").port()
    };
    let (fed, _input) = Fed::start("udp", &format!("kind = \"udp\"\nlisten = \"127.0.0.1:{port}\""));
    let sender = std::net::UdpSocket::bind("127.0.0.1:0").expect("a socket");
    let address = format!("127.0.0.1:{port}");
    // While ingest stands still, its queue runs over.
    let ingest = fed.train.process("ingest");
    ingest.signal(rustix::process::Signal::STOP);
    let sent = 30_000_u32;
    for k in 0..sent {
        sender.send_to(line(f64::from(k) * 1e-3).as_bytes(), &address).expect("sent");
    }
    ingest.signal(rustix::process::Signal::CONT);
    let count = |name: &str| {
        let view = fed.train.http()?.json("/api/v1/train")?;
        let whole = view["sources"].as_array()?.iter().find(|source| source["wagon"].is_null())?.clone();
        whole["counts"][name].as_u64()
    };
    let all = within(PATIENCE, || {
        let (arrived, lost) = (count("arrived")?, count("overrun")?);
        (arrived + lost == u64::from(sent)).then_some((arrived, lost))
    });
    println!("(arrived, lost): {all:?}");
    assert!(
        all.is_some_and(|(arrived, lost)| arrived > 0 && lost > 0),
        "{:?} {:?}",
        count("arrived"),
        count("overrun")
    );
    let (_, metrics) = fed.train.http().and_then(|http| http.get("/metrics")).expect("metrics");
    let told = metrics.lines().find(|line| line.contains("source_events_total") && line.contains("overrun"));
    assert!(told.is_some(), "{metrics}");
    assert_eq!(fed.train.process("ingest"), ingest, "a pause of ingest is no death");
}

#[test]
fn what_dies_with_ingest_is_counted_and_what_waited_does_not_look_new() {
    let address = format!("127.0.0.1:{}", free_port());
    let (fed, _input) = Fed::start("heir", &format!("kind = \"tcp\"\nlisten = \"{address}\""));
    let send = |numbers: std::ops::Range<u32>| {
        let mut connection =
            within(PATIENCE, || std::net::TcpStream::connect(&address).ok()).expect("connected");
        for k in numbers {
            connection.write_all(line(f64::from(k) * 0.002).as_bytes()).expect("written");
            std::thread::sleep(Duration::from_millis(2));
        }
        connection
    };
    let count = |name: &str| {
        let view = fed.train.http()?.json("/api/v1/train")?;
        let wagon = view["sources"].as_array()?.iter().find(|source| source["wagon"] == 1)?.clone();
        wagon["counts"][name].as_u64()
    };
    let first = send(0..600);
    let ingest = fed.train.process("ingest");
    ingest.kill();
    drop(first);
    let _ = fed.train.successor(&ingest);
    // A hundred samples are taken while nobody listens.
    let _second = send(700..900);
    let received = || fed.process("estimator")?["received"].as_u64();
    let all = within(PATIENCE, || {
        let (received, skipped) = (received()?, count("skipped")?);
        (received + skipped == 900).then_some((received, skipped))
    });
    println!("(received, skipped): {all:?}");
    assert!(all.is_some_and(|(_, skipped)| skipped >= 100), "{:?} {:?}", received(), count("skipped"));
    // The counts of the one that died live on: what it handed on, and what its successor did.
    let both = within(PATIENCE, || (count("samples")? == received()?).then_some(()));
    assert!(both.is_some(), "{:?} {:?}", count("samples"), received());
}
